"""Measured normal forces beside the plan's, and the object's errors: the paper's Fig. 12."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.simulation.measure import Measurement

SUFFIXES = (".png", ".svg", ".pdf")


def draw(measured: Measurement, path: Path) -> None:
    """Draw an execution.

    Args:
        measured: what happened.
        path: a .png, .svg or .pdf file.

    Raises:
        InputError: another kind of file.
        MissingExtraError: matplotlib is not installed.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise InputError(f"--plot {path}: must end in {', '.join(SUFFIXES)}")
    try:
        from matplotlib.figure import Figure
    except ModuleNotFoundError as error:
        raise MissingExtraError("matplotlib", "plot") from error
    line, rows = measured.timeline, measured.rows
    time, n = line.time[rows], line.fingers
    figure = Figure(figsize=(8, 2.0 * (n + 1)), layout="constrained")
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
        axis.legend(loc="lower right", fontsize="small", ncols=3)
    size = measured.problem.body.diagonal
    axes[n].plot(time, 100 * measured.position_error() / size, label="position [% of D]")
    axes[n].plot(time, measured.angle_error(), label="angle [deg]")
    axes[n].set_ylabel("object's error")
    axes[n].set_xlabel("time [s]")
    axes[n].legend(loc="lower right", fontsize="small", ncols=2)
    figure.suptitle(measured.problem.name)
    figure.savefig(path)
