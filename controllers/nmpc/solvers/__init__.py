"""Solvers of the planning problem: Riccati recursions, projected gradients, OSQP as the baseline."""
