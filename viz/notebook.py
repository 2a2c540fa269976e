"""Plans and scenarios in a notebook: a picture and a table; a plan's scene inside a frame."""

from __future__ import annotations

import base64
import html
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import Final

from gm_ompl.errors import MissingExtraError
from gm_ompl.planfile.assemble import assemble
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.planner import Status
from gm_ompl.scenario.scenario import Scenario

from .animation import Animation, animate
from .canvas import save_to, styled
from .snapshots import snapshots_figure

ROWS: Final = 12  # of a table at most
HEIGHT: Final = 620  # of a scene's frame [px]


@dataclass(frozen=True)
class InlineScene:
    """A plan's page in a frame of a notebook: meshcat's scene, to be turned, zoomed and played.

    Attributes:
        page: the whole page.
    """

    page: str

    def __repr__(self) -> str:
        return f"<InlineScene of {len(self.page) / 2**20:.1f} MiB>"

    def _repr_html_(self) -> str:
        # The page's own policy lets it ask for nothing; the frame may run its script, no more.
        source = html.escape(self.page, quote=True)
        return (
            f'<iframe title="the plan in meshcat" sandbox="allow-scripts" srcdoc="{source}" '
            f'style="width: 100%; height: {HEIGHT}px; border: 0"></iframe>'
        )


def scene_of(plan: Plan) -> InlineScene:
    """Return the scene of a plan.

    Raises:
        MissingExtraError: meshcat is not installed.
    """
    from .page import page  # loads meshcat

    return InlineScene(page(plan))


def html_of(value: Plan | Scenario) -> str:
    """Return what a notebook shows of a plan or a scenario."""
    if isinstance(value, Scenario):
        nothing = {"time_s": 0.0, "expanded": 0, "mode_decisions": 0, "history": []}
        plan = assemble(
            value.problem,
            value.resolved(),
            (),
            status="interrupted",
            planner="",
            statistics=nothing,
        )
        animation, rows = animate(plan), list(_scenario_rows(value))
    else:
        animation, rows = animate(value), list(_plan_rows(value))
        rows += [(_steps(*link.steps), link.words) for link in animation.chain]
    return f"{_picture(animation)}{_table(rows)}"


def _steps(first: int, last: int) -> str:
    return f"step {first + 1}" if first == last else f"steps {first + 1} to {last + 1}"


def _plan_rows(plan: Plan) -> Iterator[tuple[str, str]]:
    yield "scenario", str(plan.scenario.get("name", ""))
    yield "status", Status(plan.status).sentence
    yield "planner", plan.planner
    if plan.cost is not None:
        proven = ", proven optimal on the lattice" if plan.optimal else ""
        yield "cost", f"{plan.cost:.6g}{proven}"
        yield "regrasps", str(plan.regrasps)
    if plan.least_z is not None:
        yield "least margin z", f"{plan.least_z:.4g}"


def _scenario_rows(scenario: Scenario) -> Iterator[tuple[str, str]]:
    yield "scenario", scenario.name
    if scenario.model.description:
        yield "shows", scenario.model.description
    yield from scenario.facts()


def _picture(animation: Animation) -> str:
    """Return the decisive moments as an image, or how to get them."""
    try:
        with styled():
            content = BytesIO()
            save_to(content, snapshots_figure(animation), "svg")
    except MissingExtraError as missing:
        return f"<p>{html.escape(str(missing))}</p>"
    data = base64.b64encode(content.getvalue()).decode("ascii")
    alt = html.escape(f"{animation.name}: start, regrasps and goal", quote=True)
    return f'<img alt="{alt}" style="max-width: 100%" src="data:image/svg+xml;base64,{data}">'


def _table(rows: Iterable[tuple[str, str]]) -> str:
    shown = list(rows)
    if len(shown) > ROWS:
        shown[ROWS - 1 :] = [("", f"and {len(shown) - ROWS + 1} more")]
    lines = (
        f'<tr><th scope="row" style="text-align: left">{html.escape(name)}</th>'
        f'<td style="text-align: left">{html.escape(text)}</td></tr>'
        for name, text in shown
    )
    return f"<table>{''.join(lines)}</table>"
