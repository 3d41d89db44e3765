"""Laws made of what is no law yet: a linear system, a table over measured quantities, a casadi function, a function.

Each form is a law by the protocol of `gyroctl.harness.protocol`: a nest of numbers whose `step` is the same text in
Python and in machine code. `gyroctl.harness.law_from` chooses the form and refuses what cannot be one.
"""
