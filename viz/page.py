"""One HTML file that shows a plan, plots as inline SVG: works offline, asks for nothing."""

from __future__ import annotations

import base64
import html
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from itertools import groupby
from typing import Any, Final

from gm_ompl.arrays import Array
from gm_ompl.planfile.model import Plan
from gm_ompl.planners.planner import Status
from gm_ompl.tolerance.report import Tolerance

from . import palette
from .animation import Animation, animate
from .region import View
from .scene import scene_messages, viewer_script
from .score import score, z_top

WIDTH: Final = 1000.0
HEIGHT: Final = 60.0
COLOURS: Final = (
    "position", "force", "lifted", "object", "obstacle", "static", "sliding", "margin",
)  # fmt: skip
"""What the page's style sheet asks for."""
RIBBON: Final = 12.0  # height of the ribbon of control modes above a finger's forces


def _bands(animation: Animation) -> Iterator[str]:
    """Yield the plots from top to bottom; none without a plan."""
    if not animation.segments:
        return
    top, threshold = z_top(animation), animation.problem.mechanics.z_min
    low = HEIGHT * (1.0 - threshold / top)
    levels = [min(max(segment.record.z, 0.0) / top, 1.0) for segment in animation.segments]
    curve = _steps(animation, levels, 0.0, HEIGHT)
    yield _band(f"z (z_min = {threshold:.4g})", top, [
        *_regrasps(animation),
        f'<rect class="below" x="0" y="{low:.2f}" width="{WIDTH:g}" height="{HEIGHT - low:.2f}"/>',
        f'<path class="threshold" d="M0 {low:.2f}H{WIDTH:g}"/>',
        f'<path class="z" d="{curve}"/>',
    ])  # fmt: skip
    for i, limit in enumerate(animation.problem.fingers.max_normal_force.tolist()):
        forces = [segment.record.f_com[i] for segment in animation.segments]
        shares = [None if f is None else f / limit if limit > 0 else 0.0 for f in forces]
        curve = f'<path class="force" d="{_steps(animation, shares, RIBBON + 4.0, HEIGHT)}"/>'
        parts = [*_regrasps(animation), *_ribbon(animation, i), curve]
        yield _band(f"{animation.finger_name(i)}: f_com, mode", limit, parts)


def _factors(animation: Animation, tolerance: Tolerance | None) -> Iterator[str]:
    """Yield the plot of how far all ranges may be widened together, step by step."""
    if tolerance is None or tolerance.together is None:
        return
    factors = {step.step: step.together.x for step in tolerance.steps if step.together}
    top = max([1.0, *factors.values()])
    levels = [factors[segment.step] / top for segment in animation.segments]
    one = HEIGHT * (1.0 - 1.0 / top)
    yield _band("ranges may be widened by", top, [
        *_regrasps(animation),
        f'<path class="threshold" d="M0 {one:.2f}H{WIDTH:g}"/>',
        f'<path class="z" d="{_steps(animation, levels, 0.0, HEIGHT)}"/>',
    ])  # fmt: skip


def _tolerated(tolerance: Tolerance | None) -> str:
    """Return what the plan tolerates, to be read."""
    if tolerance is None:
        return ""
    return (
        '<details id="tolerance" open><summary>What it tolerates</summary>'
        f"<pre>{escaped(tolerance.table())}</pre></details>"
    )


def _band(label: str, top: float, parts: Iterable[str]) -> str:
    """Return a plot: its quantity, what its upper edge means, and its drawing."""
    return (
        f'<div class="band"><div class="label"><span>{escaped(label)}</span>'
        f'<span class="top">{top:.3g}</span></div>'
        f'<svg viewBox="0 0 {WIDTH:g} {HEIGHT:g}" preserveAspectRatio="none" aria-hidden="true">'
        f"{''.join(parts)}</svg></div>"
    )


def _ribbon(animation: Animation, i: int) -> Iterator[str]:
    """Yield the control modes: a full bar is position, a half one force, a thin one lifted."""
    looks = {"P": ("position", RIBBON), "F": ("forced", 0.5 * RIBBON), "L": ("lifted", 2.0)}
    for mode, group in groupby(animation.segments, key=lambda segment: segment.modes[i]):
        segments = list(group)
        name, height = looks[mode]
        x, width = _span(animation, segments[0].start, segments[-1].end)
        yield (
            f'<rect class="{name}" x="{x:.2f}" y="{0.5 * (RIBBON - height):.2f}" '
            f'width="{width:.2f}" height="{height:g}"/>'
        )


def _regrasps(animation: Animation) -> Iterator[str]:
    for segment in animation.segments:
        if segment.regrasp:
            x, width = _span(animation, segment.start, segment.end)
            yield (
                f'<rect class="regrasp" x="{x:.2f}" y="0" width="{width:.2f}" height="{HEIGHT:g}"/>'
            )


def _steps(animation: Animation, levels: Iterable[float | None], top: float, bottom: float) -> str:
    """Return the path of a step curve; a level is 0 at the bottom, 1 at the top, None a gap."""
    commands: list[str] = []
    drawing, last = False, ""
    for segment, value in zip(animation.segments, levels, strict=True):
        if value is None:
            drawing = False
            continue
        start, width = _span(animation, segment.start, segment.end)
        y = f"{bottom + value * (top - bottom):.2f}"
        if not drawing:
            commands.append(f"M{start:.2f} {y}")
        elif y != last:
            commands.append(f"V{y}")
        commands.append(f"H{start + width:.2f}")
        drawing, last = True, y
    return "".join(commands)


def _span(animation: Animation, start: float, end: float) -> tuple[float, float]:
    """Return where a stretch of time begins and how wide it is."""
    per_second = WIDTH / animation.duration
    return start * per_second, (end - start) * per_second


POLICY: Final = (
    "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data: blob:; base-uri 'none'; form-action 'none'"
)
"""What the stand-alone page may load: what is in it."""


@dataclass(frozen=True, eq=False)
class Shown:
    """What a page says of a plan: pieces of HTML, all that a user wrote escaped in them."""

    title: str
    description: str
    summary: str
    bands: str
    chain: str
    fingers: str
    tolerance: str
    score: dict[str, Any]  # what the page's script plays from
    messages: tuple[str, ...]  # the scene's, packed, in base 64
    camera: tuple[str, ...]  # likewise; they say from where it is looked at
    parts: tuple[tuple[int, Array], ...]  # of obstacles, see ``SceneMessages``

    def pieces(self) -> dict[str, str]:
        """Return the pieces by the names that they have in the page's template."""
        names = ("title", "description", "summary", "bands", "chain", "fingers", "tolerance")
        return {name.upper(): getattr(self, name) for name in names}


def shown(
    animation: Animation, region: View | None = None, tolerance: Tolerance | None = None
) -> Shown:
    """Return what is shown of a plan, perhaps what it tolerates; see ``scene_messages``."""
    scene = scene_messages(animation, region)
    return Shown(
        title=escaped(animation.name),
        description=escaped(str(animation.plan.scenario.get("description", ""))),
        summary=_summary(animation),
        bands="".join([*_bands(animation), *_factors(animation, tolerance)]),
        chain="".join(f"<li>{escaped(link.words)}</li>" for link in animation.chain),
        fingers="".join(
            f'<tr id="finger{i}"><th scope="row">{i}</th><td class="place"></td>'
            '<td class="mode"></td><td class="f"></td></tr>'
            for i in range(animation.problem.fingers.count)
        ),
        tolerance=_tolerated(tolerance),
        score=score(animation, scene),
        messages=_in_base64(scene.messages),
        camera=_in_base64(scene.camera),
        parts=scene.parts,
    )


def _in_base64(messages: Iterable[bytes]) -> tuple[str, ...]:
    return tuple(base64.b64encode(message).decode("ascii") for message in messages)


def page(plan: Plan, tolerance: Tolerance | None = None) -> str:
    """Return the whole page of ``plan``, one HTML text, perhaps with what the plan tolerates.

    Raises:
        ScenarioError: the scenario inside the plan cannot be used.
    """
    seen = shown(animate(plan), tolerance=tolerance)
    data = {"score": seen.score, "messages": seen.messages, "camera": seen.camera}
    tags = [
        *(
            f'<script type="application/json" id="{name}">{embedded(value)}</script>'
            for name, value in data.items()
        ),
        *(f"<script>{text}</script>" for text in (viewer_script(), asset("page.js"), _START)),
    ]
    return filled({
        **seen.pieces(), "POLICY": POLICY, "STYLE": asset("page.css"), "KNOBS": "",
        "SCRIPTS": "\n".join(tags),
    })  # fmt: skip


_START = """
gmOmpl.present(...["score", "messages", "camera"].map(
  (id) => JSON.parse(document.getElementById(id).textContent)));
"""


def filled(parts: Mapping[str, str]) -> str:
    """Return the page's template with its names replaced by their parts."""
    colours = " ".join(
        f"--{name}: {palette.css(getattr(palette, name.upper()))};" for name in COLOURS
    )
    every = {**parts, "COLOURS": colours}
    pieces = asset("page.html").split("@@")
    # Odd pieces are names; what is filled in is never searched for names again.
    return "".join(every[p] if k % 2 else p for k, p in enumerate(pieces))


def escaped(text: str) -> str:
    """Return ``text`` so that HTML shows it as it is, whatever it says.

    Control characters, and lone surrogates that UTF-8 cannot hold, become replacement signs.
    """
    kept = " \n\u200c\u200d\u00a0\u3000\u00ad"  # joiners and spaces mean something in other scripts
    visible = "".join(c if c.isprintable() or c in kept else "\ufffd" for c in text)
    return html.escape(visible, quote=True)


def embedded(value: Any) -> str:
    """Return ``value`` as JSON that is safe inside a script element."""
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))  # ASCII alone
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def asset(name: str) -> str:
    """Return the text of a file that pages are made of."""
    return (files("gm_ompl.viz") / "pages" / name).read_text(encoding="utf-8")


def _summary(animation: Animation) -> str:
    plan = animation.plan
    if plan.cost is None:
        facts = [Status(plan.status).sentence]
    else:
        facts = [
            f"cost {plan.cost:.6g}" + (" (proven optimal on the lattice)" if plan.optimal else ""),
            f"{len(plan.steps)} steps",
            f"{plan.regrasps} regrasp" + ("" if plan.regrasps == 1 else "s"),
        ]
    facts.append(f"planner {plan.planner}")
    off = plan.scenario["object"]["shape"].get("deviation")
    if off:
        facts.append(f"shape up to {off:.3g} off its file's surface")
    return "".join(f"<li><bdi>{escaped(fact)}</bdi></li>" for fact in facts)
