# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl"]
# ///
"""What one of gm_ompl's planners explored, as OMPL's PlannerData."""

from collections import Counter
from pathlib import Path
from tempfile import TemporaryDirectory

from ompl import base as ob
from ompl import util as ou

import gm_ompl

ou.setLogLevel(ou.LogLevel.LOG_NONE)


def main() -> None:
    """Plan, print what was explored, store it and load it again."""
    setup = gm_ompl.setup("paper/regrasp", "HybridRRTConnect", seed=1)
    setup.solve(60.0)
    data = setup.planner_data()
    setup.clear()  # the data is a copy

    vertices = [data.getVertex(k) for k in range(data.numVertices())]
    tags = Counter(vertex.getTag() for vertex in vertices)
    print(f"{tags[1]} states grew from the start, {tags[2]} from the goal")
    sets = {setup.codec.read(vertex.getState()).placements for vertex in vertices}
    print(f"{data.numEdges()} motions with {len(sets)} sets of placements")

    with TemporaryDirectory() as folder:
        file, storage = str(Path(folder) / "tree.bin"), ob.PlannerDataStorage()
        storage.store(data, file)
        read = ob.PlannerData(setup.getSpaceInformation())
        storage.load(file, read)
    print("the same when loaded:", read.numEdges() == data.numEdges())


main()
