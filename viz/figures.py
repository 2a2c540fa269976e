"""Forces along a plan, as planned and as an execution measured them, with modes, z and travel."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from typing import Any, Final

import numpy as np

from gm_ompl.arrays import Array
from gm_ompl.errors import InputError
from gm_ompl.geometry.pose import Pose
from gm_ompl.simulation.balance import balance
from gm_ompl.simulation.measure import Measurement
from gm_ompl.simulation.segments import commanded

from . import palette
from .animation import Animation, ShownSegment
from .canvas import COLUMN, check_suffix, new_figure, save, styled, title

RANGES: Final = 400
"""Ranges of normal force are computed for at most this many segments, evenly chosen."""

LOGARITHMIC: Final = 30.0
"""z is drawn on a logarithmic scale where its greatest value is this many times z_min."""

LINES: Final = ("-", "--", "-.", ":")


@dataclass(frozen=True, eq=False)
class PlanAxis:
    """Where each displacement segment lies along the plan."""

    segments: tuple[ShownSegment, ...]  # the displacement segments, in order
    start: Array  # (b,), where they begin
    end: Array  # (b,), where they end
    regrasps: tuple[tuple[float, int], ...]  # per regrasp, its place and its finger
    label: str  # what the axis counts
    travel: Array  # (b + 1, n), how far each fingertip's centre has come; regrasps add nothing


def axis_of(animation: Animation) -> PlanAxis:
    """Return the axis: s along a path that is never retraced, else displacement steps."""
    displacements = [step for step in animation.plan.steps if step.kind == "displacement"]
    forward = len(animation.problem.motion.names) == 1 and all(
        step.to[0] >= step.from_[0] for step in displacements
    )
    segments, start, end, regrasps = [], [], [], []
    travel = [np.zeros(animation.problem.fingers.count)]
    done = 0
    for segment in animation.segments:
        step = animation.plan.steps[segment.step]
        if step.kind == "regrasp":
            regrasps.append((step.at[0] if forward else float(done), step.finger))
            continue
        assert segment.segment is not None
        low, high = (step.from_[0], step.to[0]) if forward else (float(done), done + 1.0)
        width = (high - low) / len(step.segments)
        segments.append(segment)
        start.append(low + segment.segment * width)
        end.append(low + (segment.segment + 1) * width)
        # as Eq. (9) measures it
        first, last = (Pose.from_quaternion(row[:3], row[3:]) for row in segment.poses[[0, -1]])
        centres = np.array([animation.centre(i, p) for i, p in enumerate(segment.placements)])
        moved = np.linalg.norm(last.apply(centres) - first.apply(centres), axis=1)
        travel.append(travel[-1] + moved)
        done += segment.segment == len(step.segments) - 1
    return PlanAxis(
        tuple(segments), np.array(start), np.array(end), tuple(regrasps),
        f"{animation.problem.motion.names[0]} along the path" if forward else "displacement steps",
        np.array(travel),
    )  # fmt: skip


def forces_figure(animation: Animation) -> Any:
    """Return the figure of a plan's forces, modes, z and travel, a paper's column wide.

    Under force control the commanded force is drawn; under position control, where statics
    leaves the force open, the range that equilibrium allows.

    Raises:
        InputError: the plan has no displacement.
    """
    axis = axis_of(animation)
    if not axis.segments:
        raise InputError("the plan has no displacement steps: there is nothing to plot")
    n = animation.problem.fingers.count
    heights = [0.8] * n + [0.22 * n + 0.1, 1.0, 0.8]
    figure = new_figure(COLUMN, 0.7 + sum(heights))
    axes = figure.subplots(n + 3, 1, sharex=True, height_ratios=heights)
    figure.suptitle(title(animation.name, 48), fontsize=8, parse_math=False)
    ranges = _ranges(animation, axis)
    for i in range(n):
        _force(axes[i], animation, axis, i, ranges[:, i])
    _modes(axes[n], axis, n)
    _stability(axes[n + 1], animation, axis)
    _travel(axes[n + 2], axis)
    for ax in axes:
        ax.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False, handlelength=1.4)
        for x, _ in axis.regrasps:
            ax.axvline(x, color="0.35", linewidth=0.8, linestyle=(0, (4, 2)))
    for x, finger in axis.regrasps:
        axes[0].annotate(
            f"finger {finger} regrasps", (x, 1.0), xycoords=("data", "axes fraction"),
            xytext=(0, 1), textcoords="offset points", ha="center", va="bottom", fontsize=5.5,
        )  # fmt: skip
    axes[-1].set_xlabel(axis.label)
    axes[-1].set_xlim(axis.start.min(), axis.end.max())
    figure.align_ylabels(axes)
    return figure


def _ranges(animation: Animation, axis: PlanAxis) -> Array:
    """Return the ranges of normal force (b, n, 2); NaN where they were not computed."""
    count = len(axis.segments)
    ranges = np.full((count, animation.problem.fingers.count, 2), np.nan)
    for k in np.unique(np.linspace(0, count - 1, min(count, RANGES)).round().astype(int)):
        segment = axis.segments[k]
        if "P" in segment.modes:
            told = commanded(segment.record)
            found = balance(animation.problem, segment.middle, segment.placements, *told)
            ranges[k] = np.stack([found.least, found.most], axis=1)
    return ranges


def _edges(axis: PlanAxis, values: Array, rows: Any = slice(None)) -> tuple[Array, Array]:
    """Return a step curve's corners: each value from its segment's start to its end."""
    x = np.stack([axis.start[rows], axis.end[rows]], axis=1).ravel()
    return x, np.repeat(values[rows], 2)


def _force(ax: Any, animation: Animation, axis: PlanAxis, i: int, ranges: Array) -> None:
    limit = float(animation.problem.fingers.max_normal_force[i])
    force = np.array([segment.record.f_com[i] for segment in axis.segments], dtype=float)
    position = np.array([b.modes[i] == "P" for b in axis.segments])
    known = position & ~np.isnan(ranges).any(axis=1)
    blue, orange = palette.css(palette.POSITION), palette.css(palette.FORCE)
    if known.any():
        rows = known if len(axis.segments) > RANGES else slice(None)
        bounds = np.where(known[:, None], ranges, np.nan)
        (x, low), (_, high) = (_edges(axis, bounds[:, side], rows) for side in (0, 1))
        ax.fill_between(x, low, high, color=blue, alpha=0.3, linewidth=0.6, label="possible")
    if (~np.isnan(force)).any():
        ax.plot(*_edges(axis, force), color=orange, linewidth=1.4, label="commanded")
    ax.axhline(limit, color="0.3", linewidth=0.7, linestyle=":", label="limit")
    ax.set_ylabel(f"normal force\n{animation.finger_name(i)}")
    ax.set_ylim(-0.05 * limit if limit else -0.05, 1.15 * limit if limit else 1.0)


def _modes(ax: Any, axis: PlanAxis, n: int) -> None:
    """Draw one ribbon per finger: plain under position control, hatched under force control."""
    looks = {"P": ("position", palette.POSITION, ""), "F": ("force", palette.FORCE, "////")}
    seen: set[str] = set()
    for i in range(n):
        modes = [segment.modes[i] for segment in axis.segments]
        for mode, group in groupby(range(len(modes)), key=modes.__getitem__):
            rows = list(group)
            low, high = axis.start[rows].min(), axis.end[rows].max()
            name, colour, hatch = looks[mode]
            ax.barh(
                i, high - low, left=low, height=0.62, color=palette.css(colour), hatch=hatch,
                edgecolor="white", linewidth=0.0, label="" if mode in seen else name,
            )  # fmt: skip
            seen.add(mode)
    ax.set_yticks(range(n), [str(i) for i in range(n)])
    ax.set_ylim(n - 0.5, -0.5)
    ax.set_ylabel("mode of\nfinger")


def _stability(ax: Any, animation: Animation, axis: PlanAxis) -> None:
    z = np.array([segment.record.z for segment in axis.segments])
    threshold = animation.problem.mechanics.z_min
    ax.plot(*_edges(axis, z), color=palette.css(palette.MARGIN), label="z")
    ax.axhline(threshold, color="#b00000", linewidth=0.8, linestyle="--", label="z_min")
    if threshold > 0 and z.min() > 0 and z.max() > LOGARITHMIC * threshold:
        ax.set_yscale("log")
    else:
        ax.set_ylim(bottom=min(0.0, float(z.min())))
    ax.set_ylabel("stability z")


def _travel(ax: Any, axis: PlanAxis) -> None:
    x = np.append(axis.start[:1], axis.end)
    for i, travel in enumerate(axis.travel.T):
        ax.plot(x, travel, color="0.15", linestyle=LINES[i % len(LINES)], label=f"finger {i}")
    ax.set_ylabel("fingertip\ntravel")
    ax.set_ylim(bottom=0.0)


def draw_execution(measured: Measurement, path: Path) -> None:
    """Draw what an execution measured; the file's suffix names the format.

    Raises:
        InputError: another kind of file.
        MissingExtraError: matplotlib is not installed.
    """
    check_suffix(path)
    line, rows = measured.timeline, measured.rows
    time, n = line.time[rows], line.fingers
    with styled():
        figure = new_figure(2.0 * COLUMN, 1.4 * (n + 1))
        axes = figure.subplots(n + 1, 1, sharex=True, squeeze=False)[:, 0]
        for i, axis in enumerate(axes[:n]):
            share = line.force_share[rows, i]
            asked = np.where(share >= 1.0, line.f_com[rows, i], np.nan)
            axis.fill_between(
                time, line.least[rows, i], line.most[rows, i], where=share <= 0.0,
                color="tab:blue", alpha=0.15, linewidth=0, label="statical range",
            )  # fmt: skip
            axis.plot(time, measured.averaged(i), color="tab:blue", label="measured, 50 ms")
            axis.plot(time, asked, "k--", linewidth=1, label="commanded")
            axis.set_ylim(0, 1.15 * float(measured.problem.fingers.max_normal_force[i]))
            axis.set_ylabel(f"finger {i}: normal force")
            axis.legend(loc="lower right", ncols=3)
        size = measured.problem.body.diagonal
        axes[n].plot(time, 100 * measured.position_error() / size, label="position [% of D]")
        axes[n].plot(time, measured.angle_error(), label="angle [deg]")
        axes[n].set_ylabel("object's error")
        axes[n].set_xlabel("time [s]")
        axes[n].legend(loc="lower right", ncols=2)
        figure.suptitle(measured.problem.name)
        save(figure, path)
