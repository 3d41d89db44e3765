"""
The locked orbit
================

In a regular wave the lock is a periodic orbit. Newton's method finds it, and its Floquet multipliers tell what is left
of a small disturbance after one wave: inside the unit circle it dies out.
"""

import matplotlib.pyplot as plt
import numpy as np

import gyroctl as gy

plant, wave = gy.zhang2017(), gy.Regular(height=0.2, wp=3.14)
orbit = gy.lock_orbit(plant, wave, cc=0.052, cg=3.5e-4)
print(orbit.status, f"{orbit.power:.2f} W; {100 * orbit.lock_share:.0f} % of the lock capacity used")

# %%
# The orbit over one wave, and its multipliers with those of a weaker coupling, where the float's swing grows.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
states = orbit.states(65)
left.plot(np.linspace(0.0, 1.0, 65), states[:, 0], label="φ1")
left.plot(np.linspace(0.0, 1.0, 65), states[:, 1], label="φ3")
left.set(title="The float on the orbit", xlabel="part of the wave's period", ylabel="angle [rad]")
left.legend()
circle = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 200))
right.plot(circle.real, circle.imag, color="grey", linewidth=1.0)
for cc, mark in ((0.052, "o"), (0.02, "x")):
    multipliers = gy.lock_orbit(plant, wave, cc=cc, cg=3.5e-4).multipliers
    right.plot(multipliers.real, multipliers.imag, mark, label=f"cc {cc:g} Nms")
right.set(title="Floquet multipliers", xlabel="real part", ylabel="imaginary part", aspect="equal")
right.legend()
plt.show()
