"""A box is pushed across the floor: planned with OMPL's own RRTConnect."""

from ompl import geometric as og
from ompl import util as ou

import gm_ompl

ou.setLogLevel(ou.LogLevel.LOG_NONE)


def main() -> None:
    """Plan, and print the plan."""
    setup = gm_ompl.setup("paper/push", seed=1)  # an og.SimpleSetup with everything in place
    planner = og.RRTConnect(setup.getSpaceInformation())
    planner.setRange(setup.getStateSpace().getMaximumExtent())
    setup.setPlanner(planner)
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
