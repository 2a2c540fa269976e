"""Measured normal forces beside the plan's, and the object's errors: the paper's Fig. 12."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gm_ompl.simulation.measure import Measurement

from .canvas import COLUMN, check_suffix, new_figure, save, styled


def draw_execution(measured: Measurement, path: Path) -> None:
    """Draw what an execution measured.

    Args:
        measured: what happened.
        path: the file; its suffix names the format.

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
