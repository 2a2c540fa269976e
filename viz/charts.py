"""The page's plots as inline SVG: z, commanded forces and control modes over time.

Each band is drawn in a box of ``WIDTH`` by its height and stretched to the page's width, so
there is no text inside: labels stand beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Final

from .animation import Animation, ShownSegment
from .score import z_top

WIDTH: Final = 1000.0
HEIGHT: Final = 60.0
RIBBON: Final = 12.0
"""Height of the ribbon of control modes above a finger's forces."""


@dataclass(frozen=True)
class Band:
    """One plot.

    Attributes:
        label: its quantity, plain text.
        top: what its upper edge means.
        svg: the drawing.
    """

    label: str
    top: str
    svg: str


def bands(animation: Animation) -> list[Band]:
    """Return the plots from top to bottom; none without a plan."""
    if not animation.segments:
        return []
    fingers = range(animation.problem.fingers.count)
    return [_stability(animation), *(_finger(animation, i) for i in fingers)]


def _stability(animation: Animation) -> Band:
    top = z_top(animation)
    threshold = animation.problem.mechanics.z_min
    low = HEIGHT * (1.0 - threshold / top)
    curve = _steps(
        animation, lambda segment: min(max(segment.record.z, 0.0) / top, 1.0), 0.0, HEIGHT
    )
    parts = [
        *_regrasps(animation),
        f'<rect class="below" x="0" y="{low:.2f}" width="{WIDTH:g}" height="{HEIGHT - low:.2f}"/>',
        f'<path class="threshold" d="M0 {low:.2f}H{WIDTH:g}"/>',
        f'<path class="z" d="{curve}"/>',
    ]
    return Band(f"z (z_min = {threshold:.4g})", f"{top:.3g}", _svg(parts, HEIGHT))


def _finger(animation: Animation, i: int) -> Band:
    limit = float(animation.problem.fingers.max_normal_force[i])

    def level(segment: ShownSegment) -> float | None:
        force = segment.record.f_com[i]
        return None if force is None else force / limit if limit > 0 else 0.0

    curve = _steps(animation, level, RIBBON + 4.0, HEIGHT)
    parts = [*_regrasps(animation), *_ribbon(animation, i), f'<path class="force" d="{curve}"/>']
    return Band(f"finger {i}: f_com, mode", f"{limit:.3g}", _svg(parts, HEIGHT))


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


def _steps(
    animation: Animation, level: Callable[[ShownSegment], float | None], top: float, bottom: float
) -> str:
    """Return the path of a step curve; ``level`` is 0 at the bottom, 1 at the top, None a gap."""
    commands: list[str] = []
    drawing, last = False, ""
    for segment in animation.segments:
        value = level(segment)
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


def _svg(parts: list[str], height: float) -> str:
    inside = "".join(parts)
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {height:g}" preserveAspectRatio="none" '
        f'aria-hidden="true">{inside}</svg>'
    )
