"""``list``, ``check``, ``tolerate``, ``strong``, ``view``, ``plot``: what there is, what plans say.

What one of them alone needs is imported inside it.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gm_ompl.app.commands import Exit
from gm_ompl.app.output import note, say, say_json, writable
from gm_ompl.app.verbs import CheckVerb, ListVerb, PlotVerb, StrongVerb, TolerateVerb, ViewVerb
from gm_ompl.errors import (
    InputError,
    MisfitError,
    MissingExtraError,
    PlanError,
    ScenarioError,
    did_you_mean,
)
from gm_ompl.planfile.fit import in_file
from gm_ompl.planfile.model import Plan
from gm_ompl.writing import write_text

if TYPE_CHECKING:
    from gm_ompl.viz.animation import Animation

KEYS = ("name", "description", "source")

PICTURES = ("forces", "snapshots", "tolerance", "strong", "search", "film")


@contextmanager
def opened(path: Path) -> Iterator[Plan]:
    """Give the plan in ``path``; what is found wrong with it meanwhile is told with file and line.

    Raises:
        PlanError: the file cannot be read, is no plan, or its steps or its scenario cannot
            be used.
    """
    plan = Plan.load(path)
    try:
        yield plan
    except MisfitError as error:
        raise in_file(error, path) from None
    except ScenarioError as error:
        raise PlanError("\n".join(f"{path}: {line}" for line in error.problems)) from None


def list_command(request: ListVerb) -> Exit:
    """Show the shipped scenarios and name the random families."""
    from gm_ompl.scenario.load import random_names, read, shipped

    rows = []
    for name in shipped():
        tree = read(name).tree  # the text alone: nothing is built
        fields = tree if isinstance(tree, dict) else {}
        rows.append({"name": name} | {key: str(fields.get(key, "")) for key in KEYS[1:]})
    if request.as_json:
        say_json({"scenarios": rows, "families": list(random_names())})
        return Exit.OK
    widths = [max((len(row[key]) for row in rows), default=0) for key in KEYS]
    for row in rows:
        cells = (row[key].ljust(width) for key, width in zip(KEYS, widths, strict=True))
        say("  ".join(cells).rstrip())
    note(f"random families: {', '.join(random_names())}")
    return Exit.OK


def check_command(request: CheckVerb) -> Exit:
    """Judge the plan in the file and show what holds."""
    import gm_ompl

    with opened(request.plan_file) as plan:
        report = gm_ompl.check(plan)
    if request.as_json:
        say_json(report.to_dict())
    else:
        say(report.table())
    return Exit.OK if report.holds else Exit.REFUTED


def tolerate_command(request: TolerateVerb) -> Exit:
    """Show what the plan in the file tolerates."""
    import gm_ompl

    with opened(request.plan_file) as plan:
        found = gm_ompl.tolerate(plan, request.overrides or ())
    if request.as_json:
        say_json(found.to_dict())
    else:
        say(found.table())
    return Exit.OK if found.holds else Exit.REFUTED


def strong_command(request: StrongVerb) -> Exit:
    """Show both margins of the plan in the file."""
    import gm_ompl

    with opened(request.plan_file) as plan:
        found = gm_ompl.strong(plan)
    if request.as_json:
        say_json(found.to_dict())
    else:
        say(found.table())
    return Exit.OK


def view_command(request: ViewVerb) -> Exit:
    """Show the plan in the browser until interrupted, or write its page."""
    target = writable(request.html, "--html")
    check_viewer()
    if target is not None:
        with opened(request.plan_file) as plan:
            write_html(plan, target, tolerance=request.tolerance)
        note(f"written to {request.html}")
        return Exit.OK
    from gm_ompl.viz.server import address, serving

    with opened(request.plan_file) as plan:
        text = _page(plan, tolerance=request.tolerance)
    with serving(lambda: text, request.port) as server:
        try:
            say(f"{request.plan_file} is shown at {address(server)} (Ctrl-C ends)")
            sys.stdout.flush()
            server.serve_forever()
        except KeyboardInterrupt:
            note("")  # the terminal shows ^C on the line
    return Exit.OK


def check_viewer() -> None:
    """Refuse to begin what would end without its page.

    Raises:
        MissingExtraError: meshcat is not installed.
    """
    if find_spec("meshcat") is None:
        raise MissingExtraError("meshcat", "view")


def write_html(plan: Plan, target: Path, *, tolerance: bool = False) -> None:
    """Write the stand-alone page of ``plan``, perhaps with what it tolerates."""
    write_text(target, _page(plan, tolerance=tolerance))


def _page(plan: Plan, *, tolerance: bool) -> str:
    import gm_ompl
    from gm_ompl.viz.page import page

    text: str = page(plan, gm_ompl.tolerate(plan) if tolerance else None)
    return text


def plot_command(request: PlotVerb) -> Exit:
    """Draw the plan into a file.

    Raises:
        InputError: a file cannot be read or written, or there is nothing to draw.
    """
    from gm_ompl.viz.animation import animate
    from gm_ompl.viz.canvas import check_suffix, save, styled
    from gm_ompl.viz.film import check_film, write_film

    show, trace = request.show, request.trace
    if show not in PICTURES:
        hint = did_you_mean(show, PICTURES)
        raise InputError(f"--show {show}: no such picture{hint}; pictures: {', '.join(PICTURES)}")
    (check_film if show == "film" else check_suffix)(request.output)
    target = writable(request.output)
    assert target is not None
    if trace is not None and show != "search":
        raise InputError(f"--trace {trace}: is for --show search; add that")
    with styled(), opened(request.plan_file) as plan:
        if show == "film":
            write_film(animate(plan), target)
        else:
            save(_figure(animate(plan), show, trace), target)
    note(f"written to {request.output}")
    return Exit.OK


def _figure(animation: Animation, show: str, trace: Path | None) -> Any:
    if show == "search":
        from gm_ompl.planners.trace_file import read_trace
        from gm_ompl.viz.search import search_figure

        return search_figure(animation, None if trace is None else read_trace(trace))
    if show == "snapshots":
        from gm_ompl.viz.snapshots import snapshots_figure

        return snapshots_figure(animation)
    if show == "tolerance":
        import gm_ompl
        from gm_ompl.viz.tolerance import tolerance_figure

        return tolerance_figure(animation, gm_ompl.tolerate(animation.plan))
    if show == "strong":
        import gm_ompl
        from gm_ompl.viz.strong import strong_figure

        return strong_figure(animation, gm_ompl.strong(animation.plan))
    from gm_ompl.viz.figures import forces_figure

    return forces_figure(animation)
