# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl"]
# ///
"""To a controller: a plan over time, without a file in between."""

# %%
import numpy as np

import gm_ompl
from gm_ompl.simulation.export import table
from gm_ompl.simulation.timeline import Pace

plan = gm_ompl.plan("paper/cork")
text = table(plan, Pace(speed=0.3), 50.0)  # 50 rows a second
lines = [line for line in text.splitlines() if not line.startswith("#")]
names = lines[0].split(",")
print(len(lines) - 1, "rows of", len(names), "columns")

# %% The path of a fingertip, ready for an arm.
columns = [names.index(f"finger0_{axis}") for axis in "xyz"]
path = np.array([[float(line.split(",")[k]) for k in columns] for line in lines[1:]])
print("finger 0 travels", f"{np.linalg.norm(np.diff(path, axis=0), axis=1).sum():.3f}")
