"""
Margins
=======

How far may the load rise before lock breaks? The orbit is followed in the generator gain until it meets its unstable
twin. With a law in the loop, gain, phase, delay and disk margins come from the multipliers of the loop.
"""

import matplotlib.pyplot as plt
import numpy as np

import gyroctl as gy

plant, wave = gy.zhang2017(), gy.Regular(height=0.2, wp=3.14)

gains = np.linspace(2e-4, 6e-3, 30)
orbits = [gy.lock_orbit(plant, wave, cc=0.052, cg=cg, nearest=False) for cg in gains]
found = [(cg, orbit) for cg, orbit in zip(gains, orbits, strict=True) if orbit.status != "no orbit"]

figure, axes = plt.subplots(figsize=(9, 3.2), layout="constrained")
for status, mark in (("stable", "o"), ("unstable", "x")):
    here = [(1e3 * cg, orbit.lock_share) for cg, orbit in found if orbit.status == status]
    if here:
        axes.plot(*zip(*here, strict=True), mark, label=status)
axes.set(title="Used share of what the wave can pull", xlabel="cg [10⁻³ Nms]", ylabel="N cg / (J4 V)")
axes.legend()
plt.show()

# %%
# The averaged model of the slow modes is an ordinary linear system: what the load does to the angle of the ring, within
# its range of validity.

averaged = gy.lock_orbit(plant, wave, cc=0.052, cg=3.5e-4).linearise().averaged()
omega = np.linspace(0.02, averaged.valid_frequency, 200)
row, column = averaged.outputs.index("psi"), averaged.inputs.index("cg")
identity = np.eye(len(averaged.states))
response = [averaged.C @ np.linalg.solve(1j * w * identity - averaged.A, averaged.B) + averaged.D for w in omega]
figure, axes = plt.subplots(figsize=(9, 3.2), layout="constrained")
axes.plot(omega, 20.0 * np.log10([abs(one[row, column]) * 3.5e-4 for one in response]))
axes.set(title="From a relative change of cg to ψ", xlabel="ω [rad/s]", ylabel="gain [dB re 1 rad]")
plt.show()

# %%
# All margins of a law, with what each means: :doc:`/docs/margins`.
