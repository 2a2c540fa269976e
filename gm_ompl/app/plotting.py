"""``gm-ompl plot``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, writable
from gm_ompl.app.show_verbs import PlotVerb
from gm_ompl.errors import InputError, did_you_mean
from gm_ompl.plan.model import Plan

if TYPE_CHECKING:
    from gm_ompl.viz.story import Story


PICTURES = ("forces", "snapshots", "search")


def plot_command(request: PlotVerb) -> Exit:
    """Draw the plan into a file.

    Raises:
        InputError: a file cannot be read or written, or there is nothing to draw.
    """
    from gm_ompl.viz.canvas import check_suffix, save, styled
    from gm_ompl.viz.story import tell

    show, trace = request.show, request.trace
    if show not in PICTURES:
        hint = did_you_mean(show, PICTURES)
        raise InputError(f"--show {show}: no such picture{hint}; pictures: {', '.join(PICTURES)}")
    check_suffix(request.output)
    target = writable(request.output)
    assert target is not None
    if trace is not None and show != "search":
        raise InputError(f"--trace {trace}: is for --show search; add that")
    with styled():
        save(_figure(tell(Plan.load(request.plan_file)), show, trace), target)
    note(f"written to {request.output}")
    return Exit.OK


def _figure(story: Story, show: str, trace: Path | None) -> Any:
    if show == "search":
        from gm_ompl.planners.trace_file import read_trace
        from gm_ompl.viz.search import search_figure

        return search_figure(story, None if trace is None else read_trace(trace))
    if show == "snapshots":
        from gm_ompl.viz.snapshots import snapshots_figure

        return snapshots_figure(story)
    from gm_ompl.viz.figures import forces_figure

    return forces_figure(story)
