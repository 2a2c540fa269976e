"""``gm-ompl plot``."""

from __future__ import annotations

import enum
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gm_ompl.app.exits import Exit
from gm_ompl.app.output import note, writable
from gm_ompl.app.plan_files import opened
from gm_ompl.errors import InputError, did_you_mean

if TYPE_CHECKING:
    from gm_ompl.viz.story import Story


class Picture(enum.StrEnum):
    """What to draw."""

    FORCES = "forces"
    SNAPSHOTS = "snapshots"
    SEARCH = "search"


def plot_command(plan_file: Path, output: Path, show: str, trace: Path | None) -> Exit:
    """Draw the plan into a file.

    Args:
        plan_file: the plan.
        output: the file; its suffix names the format.
        show: what to draw, a value of ``Picture``.
        trace: what the search did, for "search".

    Raises:
        InputError: a file cannot be read or written, or there is nothing to draw.
    """
    from gm_ompl.viz.canvas import check_suffix, save, styled
    from gm_ompl.viz.story import tell

    names = [picture.value for picture in Picture]
    if show not in names:
        hint = did_you_mean(show, names)
        raise InputError(f"--show {show}: no such picture{hint}; pictures: {', '.join(names)}")
    picture = Picture(show)
    check_suffix(output)
    target = writable(output)
    assert target is not None
    if trace is not None and picture is not Picture.SEARCH:
        raise InputError(f"--trace {trace}: is for --show search; add that")
    with styled(), opened(plan_file) as plan:
        save(_figure(tell(plan), picture, trace), target)
    note(f"written to {output}")
    return Exit.OK


def _figure(story: Story, picture: Picture, trace: Path | None) -> Any:
    if picture is Picture.SEARCH:
        from gm_ompl.viz.search import read_trace, search_figure

        return search_figure(story, None if trace is None else read_trace(trace))
    if picture is Picture.SNAPSHOTS:
        from gm_ompl.viz.snapshots import snapshots_figure

        return snapshots_figure(story)
    from gm_ompl.viz.figures import forces_figure

    return forces_figure(story)
