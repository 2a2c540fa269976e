from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gm_ompl.viz.animation import Animation, animate
from gm_ompl.viz.canvas import save, styled, title
from gm_ompl.viz.figures import axis_of, forces_figure
from gm_ompl.viz.snapshots import pictures, snapshots_figure
from PIL import Image
from scipy.optimize import linprog
from typer.testing import CliRunner

from gm_ompl import api
from gm_ompl.app.main import app
from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.planfile.assemble import placement_record
from gm_ompl.planfile.model import Plan
from gm_ompl.simulation.balance import balance, statics_at
from gm_ompl.simulation.segments import commanded

MAGIC = {".png": b"\x89PNG", ".svg": b"<?xml", ".pdf": b"%PDF"}


@pytest.fixture(scope="module")
def animation(regrasp: Plan) -> Animation:
    return animate(regrasp)


def curve(axes: Any, label: str) -> Any:
    """Return the data (k, 2) of the line with this label."""
    return next(line.get_xydata() for line in axes.lines if line.get_label() == label)


def test_forces_and_z_are_the_plans(animation: Animation) -> None:
    """The curves hold each segment's f_com and z at its place along s."""
    with styled():
        figure = forces_figure(animation)
    segments = [
        (step.from_[0], step.to[0], segment)
        for step in animation.plan.steps
        if step.kind == "displacement"
        for segment in step.segments
    ]
    z = curve(figure.axes[3], "z")
    np.testing.assert_array_equal(z[::2, 1], [segment.z for *_, segment in segments])
    np.testing.assert_allclose(z[::6, 0], [low for low, *_ in segments][::3], atol=1e-12)
    for i in range(2):
        force = curve(figure.axes[i], "commanded")[::2, 1]
        wanted = [np.nan if s.f_com[i] is None else s.f_com[i] for *_, s in segments]
        np.testing.assert_array_equal(force, np.array(wanted, dtype=float))
    assert curve(figure.axes[3], "z_min")[0][1] == 0.5


def test_regrasps_are_marked_where_they_happen(animation: Animation) -> None:
    """Every panel has a line at the regrasp's s; the first names the finger."""
    with styled():
        figure = forces_figure(animation)
    step = next(step for step in animation.plan.steps if step.kind == "regrasp")
    for axes in figure.axes:
        assert any(np.all(np.array(line.get_xdata()) == step.at[0]) for line in axes.lines)
    assert [t.get_text() for t in figure.axes[0].texts] == [f"finger {step.finger} regrasps"]


def test_the_figure_fits_a_papers_column(animation: Animation) -> None:
    """It is 3.4 inches wide, and no letter is smaller than 5 points."""
    from matplotlib.text import Text

    with styled():
        figure = forces_figure(animation)
    assert figure.get_figwidth() == pytest.approx(3.4)
    assert min(text.get_fontsize() for text in figure.findobj(Text) if text.get_text()) >= 5.0


def test_travel_is_what_the_cost_charges_for(slide: Plan) -> None:
    """With X_stab = 0 a plan without regrasps costs what its busiest finger travels."""
    few = ["lattice.segments=3", "fingers.placements.grid=[2, 2]", "cost.stability=0"]
    plan = api.plan(api.load("paper/slide", few))
    assert axis_of(animate(plan)).travel[-1].max() == pytest.approx(plan.cost)
    assert (np.diff(axis_of(animate(slide)).travel, axis=0) > 0).all()


def test_normal_forces_against_another_solver(animation: Animation) -> None:
    """The range of each position-controlled finger agrees with scipy's linear programs."""
    told = [segment for segment in animation.segments if "P" in segment.modes][::9]
    assert len(told) > 5
    for segment in told:
        hand = [i for i, mode in enumerate(segment.modes) if mode != "L"]
        model = statics_at(animation.problem, segment.middle, segment.placements, hand)
        wrenches = np.hstack([model.W_env @ model.C_env, model.W_rob @ model.C_rob])
        normal = np.hstack([np.zeros((len(hand), model.C_env.shape[1])), model.normal_parts])
        force, f_com = commanded(segment.record)
        forced = [k for k, i in enumerate(hand) if force[i]]
        exact = np.vstack([wrenches, normal[forced]])
        right = [*-model.Q_known, *(f_com[hand][forced] / model.scale)]
        moved = segment.regrasp
        found = balance(
            animation.problem, segment.middle, segment.placements, force, f_com,
            None if moved is None else moved.finger,
        )  # fmt: skip
        for k, i in enumerate(hand):
            ends = [
                sign * linprog(
                    sign * normal[k], normal, model.f_max, exact, right, method="highs-ipm"
                ).fun * model.scale
                for sign in (1.0, -1.0)
            ]  # fmt: skip
            np.testing.assert_allclose((found.least[i], found.most[i]), ends, atol=1e-4)


def test_a_frictionless_push_overcomes_the_floors_friction() -> None:
    """One frictionless finger that pushes a box along: its normal force is mu M g, its limit 10."""
    changes = ["fingers.count=1", "friction.finger=0", "fingers.placements.grid=[1, 1]"]
    problem = api.load("paper/slide", changes).problem
    row = problem.fingers.placements.find("-x", (0, 0))
    assert row is not None
    found = balance(
        problem, problem.motion.moment((0.5,), (1.0,)), (placement_record(problem, row),),
        np.array([False]), np.zeros(1),
    )  # fmt: skip
    np.testing.assert_allclose((found.least, found.most), [[4.9], [4.9]], rtol=1e-6)


def test_snapshots_are_start_regrasps_and_goal(animation: Animation, infeasible: Plan) -> None:
    """Start, before and after the regrasp, goal; only the start where there is no plan."""
    shown = pictures(animation)
    captions = ["start", "before regrasp 1", "after regrasp 1", "goal"]
    assert [moment.caption for moment in shown] == captions
    before, after = shown[1], shown[2]
    np.testing.assert_array_equal(before.pose, after.pose)
    step = next(step for step in animation.plan.steps if step.kind == "regrasp")
    assert before.segment is not None
    assert after.segment is not None
    assert before.segment.placements[step.finger] == step.from_
    assert after.segment.placements[step.finger] == step.to
    assert [moment.caption for moment in pictures(animate(infeasible))] == ["start"]


def test_snapshots_look_alike_at_every_scale(
    regrasp: Plan, rescaled: Callable[[Plan, float], Plan], tmp_path: Path
) -> None:
    """A scene of a millimetre or of metres gives the same picture."""
    images = []
    for factor in (1.0, 1e-4, 100.0):
        with styled():
            figure = snapshots_figure(animate(rescaled(regrasp, factor)))
            save(figure, tmp_path / "picture.png")
        with Image.open(tmp_path / "picture.png") as image:
            images.append(np.asarray(image.convert("RGB"), dtype=float))
    assert images[0].std() > 20.0
    for other in images[1:]:
        assert np.abs(other - images[0]).mean() < 0.5


@pytest.mark.parametrize("suffix", MAGIC)
@pytest.mark.parametrize("show", ["forces", "snapshots", "search"])
def test_plot_writes_what_the_suffix_says(
    slide: Plan, tmp_path: Path, suffix: str, show: str
) -> None:
    """``plot`` writes PNG, SVG or PDF."""
    plan, target = tmp_path / "plan.json", tmp_path / f"picture{suffix}"
    slide.save(plan)
    result = CliRunner().invoke(app, ["plot", str(plan), "-o", str(target), "--show", show])
    assert result.exit_code == 0, result.output
    assert target.read_bytes().startswith(MAGIC[suffix])


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["-o", "x.gif"], ".png, .svg, .pdf"),
        (["-o", "x.png", "--show", "force"], "forces"),
        (["-o", "x.png", "--trace", "t"], "--show search"),
        (["-o", "x.png", "--show", "search", "--trace", "missing"], "missing"),
        (["-o", "no-such-folder/x.png"], "no-such-folder"),
    ],
)
def test_bad_requests_end_with_2(
    slide: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, options: list[str], message: str
) -> None:
    """A wrong suffix, picture, trace or folder: exit code 2, nothing written."""
    monkeypatch.chdir(tmp_path)
    slide.save("plan.json")
    result = CliRunner().invoke(app, ["plot", "plan.json", *options])
    assert result.exit_code == 2
    assert message in result.stderr
    assert [p.name for p in tmp_path.iterdir()] == ["plan.json"]


def test_without_matplotlib_the_message_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    """The plots are an extra: its absence is bad input, and the remedy is said."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(MissingExtraError, match=r"gm-ompl\[plot\]"), styled():
        pass


@pytest.mark.parametrize("name", ["$\\frac{", "掴み بدون", "a\nb\x00" * 50, "<script>&amp;"])
def test_hostile_names_are_drawn_as_text(
    renamed: Callable[[str], Plan], tmp_path: Path, name: str
) -> None:
    """No name is taken for mathematics or markup; a long one is shortened."""
    animation = animate(renamed(name))
    with styled():
        figure = forces_figure(animation)
        save(figure, tmp_path / "picture.svg")
        save(figure, tmp_path / "picture.png")
    assert figure.get_suptitle() == title(name, 48)
    assert len(title(name)) <= 60
    assert "<script>" not in (tmp_path / "picture.svg").read_text(encoding="utf-8")


def test_a_plan_without_steps_has_no_force_plot(infeasible: Plan) -> None:
    """There is nothing to plot, and the message says so."""
    with styled(), pytest.raises(InputError, match="no displacement"):
        forces_figure(animate(infeasible))
