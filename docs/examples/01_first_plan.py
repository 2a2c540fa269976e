# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl[view,plot]"]
# ///
"""A first plan: slide a box, check the plan, look at it."""

# %%
import gm_ompl

scenario = gm_ompl.load("paper/slide")
print(scenario)

# %%
plan = gm_ompl.plan(scenario)
print(plan)
plan

# %%
first = plan.steps[0]
for finger, place in enumerate(first.placements):
    print(f"finger {finger} on {place.face}, {first.segments[0].modes[finger]}-controlled")

# %% A second, independent program judges every step anew.
print(gm_ompl.check(plan).holds)

# %% In a notebook: meshcat's scene, to be turned and played.
scene = plan.scene()
scene
