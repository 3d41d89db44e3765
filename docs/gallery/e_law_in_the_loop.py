"""
A law in the loop
=================

A law is two functions: ``init`` gives its first state, ``step`` takes the time, the measurement and the state, and
gives the controls and the next state. Nothing else is asked of it.
"""

import matplotlib.pyplot as plt

import gyroctl as gy


class Governor:
    """Loads the generator while the ring is fast, and eases it while the ring is slow."""

    period = 0.1  # [s]
    information = "sensors"

    def init(self):
        return 3.14  # slow part of the ring speed [rad/s]

    def step(self, t, y, speed):
        speed = speed + 0.03 * (y.psi_rate - speed)
        cg = max(0.0, 4e-4 + 8e-4 * (speed - 3.14))
        return (0.06, cg), speed


plant = gy.zhang2017()
waves = gy.realise(plant, gy.SeaState(), seed=1, duration=300.0)
mine = gy.simulate(plant, Governor(), waves)
shipped = gy.simulate(plant, gy.law("coupling"), waves)

# %%
# The same loop runs a law of one's own and the shipped ones: measured with noise, held between samples.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
for run, words in ((mine, "Governor"), (shipped, "coupling")):
    left.plot(run.time, run.power, label=words)
    right.plot(run.time, 1e3 * run.cg, label=words)
left.set(title="Power", xlabel="time [s]", ylabel="power [W]")
right.set(title="What the law asks of the generator", xlabel="time [s]", ylabel="cg [10⁻³ Nms]")
left.legend()
plt.show()

# %%
# As a file with typed fields, checked, tuned and compared: :doc:`/docs/experiment`.
