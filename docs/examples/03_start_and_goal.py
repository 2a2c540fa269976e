# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl[view,plot]"]
# ///
"""Start and goal only: a cube climbs two steps, and the way is found."""

# %%
import gm_ompl

plan = gm_ompl.plan("free/stairs")
print(plan)
plan

# %% What each step does, and how large a disturbance it resists.
for number, step in enumerate(plan.steps):
    if step.kind == "regrasp":
        print(f"{number}: finger {step.finger} moves to {step.to.face}")
    else:
        print(f"{number}: to {step.pose_to.position}, z = {min(s.z for s in step.segments):.2f}")
