"""
Device and lock
===============

A float on a lever carries a ring and a flywheel. When the ring turns once per wave, the device is *locked*: the
flywheel spins at nearly a constant speed, and the power is smooth. If the generator pulls too hard, lock is lost.
"""

import matplotlib.pyplot as plt

import gyroctl as gy

plant = gy.zhang2017()
waves = gy.realise(plant, gy.SeaState(hs=0.283, wp=3.14, gamma=5.0), seed=1, duration=600.0)

# %%
# Two constant pairs on the same waves: one that the waves can carry, and one with three times the load.

figure, (ring, power) = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
for cg, words in ((3.5e-4, "cg 3.5e-4 Nms"), (1.2e-3, "cg 1.2e-3 Nms")):
    run = gy.simulate(plant, gy.law("constant", cc=0.052, cg=cg), waves)
    ring.plot(run.time, run.psi_rate.rolling(time=100).mean(), label=words)
    power.plot(run.time, run.power, label=words)
ring.axhline(0.5 * 3.14, color="grey", linestyle="--")
ring.set(title="Ring speed, 10 s mean", xlabel="time [s]", ylabel="ψ′ [rad/s]")
power.set(title="Power", xlabel="time [s]", ylabel="cg ω′² [W]")
ring.legend()
plt.show()

# %%
# Below the dashed line the ring turns at less than half the speed of the waves: there lock is lost by definition
# (:doc:`/docs/nomenclature`). One run is chance near the limit; verdicts come from many (:doc:`f_comparison`).
