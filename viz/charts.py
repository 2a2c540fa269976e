"""The page's plots as inline SVG: z, commanded forces and control modes over time.

Each band is drawn in a box of ``WIDTH`` by its height and stretched to the page's width, so
there is no text inside: labels stand beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import groupby
from typing import Final

from .score import z_top
from .story import Beat, Story

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


def bands(story: Story) -> list[Band]:
    """Return the plots from top to bottom; none without a plan."""
    if not story.beats:
        return []
    fingers = range(story.problem.fingers.count)
    return [_stability(story), *(_finger(story, i) for i in fingers)]


def _stability(story: Story) -> Band:
    top = z_top(story)
    threshold = story.problem.mechanics.z_min
    low = HEIGHT * (1.0 - threshold / top)
    curve = _steps(story, lambda beat: min(max(beat.z, 0.0) / top, 1.0), 0.0, HEIGHT)
    parts = [
        *_regrasps(story),
        f'<rect class="below" x="0" y="{low:.2f}" width="{WIDTH:g}" height="{HEIGHT - low:.2f}"/>',
        f'<path class="threshold" d="M0 {low:.2f}H{WIDTH:g}"/>',
        f'<path class="z" d="{curve}"/>',
    ]
    return Band(f"z (z_min = {threshold:.4g})", f"{top:.3g}", _svg(parts, HEIGHT))


def _finger(story: Story, i: int) -> Band:
    limit = float(story.problem.fingers.max_normal_force[i])

    def level(beat: Beat) -> float | None:
        force = beat.f_com[i]
        return None if force is None else force / limit if limit > 0 else 0.0

    curve = _steps(story, level, RIBBON + 4.0, HEIGHT)
    parts = [*_regrasps(story), *_ribbon(story, i), f'<path class="force" d="{curve}"/>']
    return Band(f"finger {i}: f_com, mode", f"{limit:.3g}", _svg(parts, HEIGHT))


def _ribbon(story: Story, i: int) -> Iterator[str]:
    """Yield the control modes: a full bar is position, a half one force, a thin one lifted."""
    looks = {"P": ("position", RIBBON), "F": ("forced", 0.5 * RIBBON), "L": ("lifted", 2.0)}
    for mode, group in groupby(story.beats, key=lambda beat: beat.modes[i]):
        beats = list(group)
        name, height = looks[mode]
        x, width = _span(story, beats[0].start, beats[-1].end)
        yield (
            f'<rect class="{name}" x="{x:.2f}" y="{0.5 * (RIBBON - height):.2f}" '
            f'width="{width:.2f}" height="{height:g}"/>'
        )


def _regrasps(story: Story) -> Iterator[str]:
    for beat in story.beats:
        if beat.regrasp:
            x, width = _span(story, beat.start, beat.end)
            yield (
                f'<rect class="regrasp" x="{x:.2f}" y="0" width="{width:.2f}" height="{HEIGHT:g}"/>'
            )


def _steps(story: Story, level: Callable[[Beat], float | None], top: float, bottom: float) -> str:
    """Return the path of a step curve; ``level`` is 0 at the bottom, 1 at the top, None a gap."""
    commands: list[str] = []
    drawing, last = False, ""
    for beat in story.beats:
        value = level(beat)
        if value is None:
            drawing = False
            continue
        start, width = _span(story, beat.start, beat.end)
        y = f"{bottom + value * (top - bottom):.2f}"
        if not drawing:
            commands.append(f"M{start:.2f} {y}")
        elif y != last:
            commands.append(f"V{y}")
        commands.append(f"H{start + width:.2f}")
        drawing, last = True, y
    return "".join(commands)


def _span(story: Story, start: float, end: float) -> tuple[float, float]:
    """Return where a stretch of time begins and how wide it is."""
    per_second = WIDTH / story.duration
    return start * per_second, (end - start) * per_second


def _svg(parts: list[str], height: float) -> str:
    inside = "".join(parts)
    return (
        f'<svg viewBox="0 0 {WIDTH:g} {height:g}" preserveAspectRatio="none" '
        f'aria-hidden="true">{inside}</svg>'
    )
