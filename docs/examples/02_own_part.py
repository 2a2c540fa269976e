# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl[plot]"]
# ///
"""Your own part: a scenario around an STL file, in Python alone."""

# %%
from pathlib import Path

import gm_ompl

FOLDER = Path(__file__).parent if "__file__" in globals() else Path("..")

scenario = gm_ompl.load(
    {
        "name": "my/bracket",
        "object": {"shape": {"mesh": str(FOLDER / "bracket.stl")}, "mass": 0.08},  # mm and kg
        "friction": {"environment": 0.3, "finger": 0.8},
        "fingers": {
            "count": 2,
            "radius": 4,
            "max_normal_force": 2,
            "placements": {"grid": [5, 5]},
        },
        "motion": {"start": {"position": [0, 0, "rest"]}, "path": [{"slide": {"by": [40, 0, 0]}}]},
        "lattice": {"segments": 8},
        "mechanics": {"z_min": 0.02},
        "cost": {"regrasp": 400, "stability": 0.0005},
    }
)
print(scenario)

# %%
plan = gm_ompl.plan(scenario)
print(plan, "holds:", gm_ompl.check(plan).holds)
plan
