# /// script
# requires-python = ">=3.11,<3.14"
# dependencies = ["gm-ompl"]
# ///
"""OMPL's own Benchmark on a scenario, with three of OMPL's planners."""

from pathlib import Path
from tempfile import TemporaryDirectory

from ompl import geometric as og
from ompl import tools as ot
from ompl import util as ou

import gm_ompl

ou.setLogLevel(ou.LogLevel.LOG_NONE)


def main() -> None:
    """Run each planner three times, print how often it succeeded, save OMPL's log."""
    setup = gm_ompl.setup("paper/slide", seed=1)
    si = setup.getSpaceInformation()
    setup.stop_at_first_plan()
    bench = ot.Benchmark(setup, "slide")
    for planner in (og.RRT(si), og.RRTConnect(si), og.RRTstar(si)):
        bench.addPlanner(planner)
    # 60 s and 4096 MB per run, 3 runs; no progress bar, no console log, no simplification.
    bench.benchmark(ot.Request(60.0, 4096.0, 3, 0.05, False, False, False))
    setup.guard.settle()  # raises what went wrong inside a callback, if anything did

    for planner in bench.getRecordedExperimentData().planners:
        runs = [run.to_dict() for run in planner.runs]
        solved = sum(run["solved BOOLEAN"] == "1" for run in runs)
        print(f"{planner.name.removeprefix('geometric_')}: {solved} of {len(runs)} solved")
    with TemporaryDirectory() as folder:
        file = Path(folder) / "slide.log"  # for ompl_benchmark_statistics and Planner Arena
        bench.saveResultsToFile(str(file))
        print("log:", file.read_text().splitlines()[0])


main()
