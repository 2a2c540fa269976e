# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl"]
# ///
"""Why there is no plan, and the least change that gives one."""

# %%
import gm_ompl

weak = gm_ompl.load(
    "paper/slide", {"fingers.max_normal_force": 2, "fingers.placements.grid": [3, 3]}
)
print(gm_ompl.plan(weak))

# %%
explanation = gm_ompl.explain(weak, time_limit=20)
print(explanation.verdict)
for remedy in explanation.remedies:
    print("helps  " if remedy.helps else "no help", remedy.change)
