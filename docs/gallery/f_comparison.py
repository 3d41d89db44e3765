"""
A fair comparison
=================

Laws are compared on identical realisations, and differences are taken realisation by realisation: what the waves do to
both falls out.
"""

import matplotlib.pyplot as plt
import numpy as np

import gyroctl as gy
from gyroctl.statistics import paired_difference

plant, sea = gy.zhang2017(), gy.SeaState()
waves = [gy.realise(plant, sea, seed, 400.0) for seed in range(1, 9)]
laws = {name: gy.law(name) for name in ("coupling", "load_angle", "stabiliser")}
ds = gy.compare(plant, laws, waves, quiet=True, workers=1)

# %%
# Each realisation by itself, and the mean difference to ``load_angle`` with its 95 % interval.

figure, (left, right) = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
for name in laws:
    left.plot(ds.realisation, ds.mean_power.sel(law=name), "o-", label=name)
left.set(title="Mean power by realisation", xlabel="seed", ylabel="power [W]")
left.legend()
for place, name in enumerate(("coupling", "stabiliser")):
    found, _ = paired_difference(ds.mean_power.sel(law=name).values, ds.mean_power.sel(law="load_angle").values)
    right.errorbar(place, found.value, [[found.value - found.low], [found.high - found.value]], fmt="o", capsize=6)
right.axhline(0.0, color="grey", linewidth=1.0)
right.set(title="Difference to load_angle", ylabel="power [W]", xlim=(-0.6, 1.6))
right.set_xticks(np.arange(2), ["coupling", "stabiliser"])
plt.show()

# %%
# From an experiment file to a report: :doc:`/docs/experiment`. The default comparison and its tables: :doc:`/README`.
