# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl[plot]"]
# ///
"""Friction from low to high: how the plan changes, as a curve."""

# %%
from matplotlib.figure import Figure

import gm_ompl

scenario = gm_ompl.load("paper/slide", {"lattice.segments": 3, "fingers.placements.grid": [3, 3]})
frictions = [0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]
plans = [gm_ompl.plan(scenario.with_({"friction.environment": mu})) for mu in frictions]
for mu, plan in zip(frictions, plans, strict=True):
    faces = "-" if plan.cost is None else ", ".join(p.face for p in plan.steps[0].placements)
    print(f"{mu}: {plan.status}, fingers on {faces}")

# %%
figure = Figure(figsize=(4, 2.5))
axes = figure.subplots()
axes.plot(frictions, [plan.least_z for plan in plans], marker="o")
axes.set(xlabel="friction with the floor", ylabel="least z")
figure
