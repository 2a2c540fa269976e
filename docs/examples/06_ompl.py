# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl"]
# ///
"""A box is tumbled between two walls: planned with OMPL's own RRTConnect."""

from ompl import geometric as og
from ompl import util as ou

import gm_ompl

ou.setLogLevel(ou.LogLevel.LOG_NONE)


def main() -> None:
    """Plan, and print the plan."""
    setup = gm_ompl.setup("paper/regrasp", seed=1)  # an og.SimpleSetup with everything in place
    setup.setPlanner(og.RRTConnect(setup.getSpaceInformation()))
    setup.solve(60.0)

    plan = gm_ompl.plan_from(setup)
    print(plan.status, "by", plan.planner)
    for step in plan.steps:
        if step.kind == "regrasp":
            print(f"at {step.at[0]:.2f} finger {step.finger} moves to face {step.to.face}")
    faces = [place.face for place in plan.steps[-1].placements]
    print("the object arrives with the fingers on", " and ".join(faces))
    print("holds:", gm_ompl.check(plan).holds)


main()
