"""
Seas and waves
==============

A sea is a spectrum; a sea, a seed and a time grid make one realisation, which its content hash names. The float feels
the waves as two moments.
"""

import matplotlib.pyplot as plt
import numpy as np

import gyroctl as gy

plant = gy.zhang2017()
omega = np.linspace(1.5, 6.0, 400)

figure, axes = plt.subplots(figsize=(9, 3.2), layout="constrained")
for gamma in (1.0, 5.0, 50.0):
    axes.plot(omega, gy.SeaState(gamma=gamma).spectrum(omega), label=f"γ = {gamma:g}")
axes.set(title="JONSWAP spectra of Hs 0.283 m", xlabel="ω [rad/s]", ylabel="S [m² s]", yscale="log", ylim=(1e-5, 0.1))
axes.legend()
plt.show()

# %%
# The moments of the default sea. Their phases differ by some 82°, which picks the sense in which the ring locks.

waves = gy.realise(plant, gy.SeaState(), seed=1, duration=100.0)
figure, axes = plt.subplots(figsize=(9, 3.2), layout="constrained")
soon = waves.time <= 20.0
axes.plot(waves.time[soon], waves.moments[0, soon], label="Me1, about the vertical")
axes.plot(waves.time[soon], waves.moments[1, soon], label="Me3, about the horizontal")
axes.set(title=f"Moments of realisation {waves.sha256[:8]}", xlabel="time [s]", ylabel="moment [Nm]")
axes.legend()
plt.show()
