"""Hands: two libraries agree on where fingertips are; inverse kinematics gets there."""

from __future__ import annotations

import numpy as np
import pytest

from gm_ompl.checking.second_hand import SecondHand
from gm_ompl.geometry.pose import Pose, rotation_about
from gm_ompl.geometry.solids import Body, box
from gm_ompl.hand.build import Wanted, hand_spec
from gm_ompl.hand.efforts import Efforts
from gm_ompl.hand.inverse import ACCURACY, InverseKinematics
from gm_ompl.hand.model import HandModel
from gm_ompl.hand.spec import HandSpec

CUBE = Body((box([-0.03] * 3, [0.03] * 3),))
HANDS = [("trifinger", 3), ("arm-hand", 2)]


def shipped(name: str, fingers: int) -> HandSpec:
    """A shipped hand on a base that stands askew."""
    base = Pose(rotation_about([1.0, 2.0, 3.0], 0.7), np.array([0.1, -0.2, 0.3]))
    return hand_spec(Wanted(name, None, {}, None, base, None, {}, None, None), fingers)


@pytest.mark.parametrize(("name", "fingers"), HANDS)
def test_two_libraries_agree(name: str, fingers: int) -> None:
    """MuJoCo and Pinocchio put the fingertips at the same places to 1e-9 m, limits alike."""
    spec, rng = shipped(name, fingers), np.random.default_rng(0)
    first, second = HandModel(spec, CUBE), SecondHand(spec, CUBE, [], True)
    for _ in range(200):
        q = rng.uniform(spec.low, spec.high)
        first.place(q)
        second.place(q)
        assert first.tips() == pytest.approx(second.tips(), abs=1e-9)
    assert np.array(second.limits()) == pytest.approx(np.array([spec.low, spec.high]))


@pytest.mark.parametrize(("name", "fingers"), HANDS)
def test_jacobians_are_derivatives(name: str, fingers: int) -> None:
    """How a fingertip moves with the hinges is what finite differences say, to 1e-6."""
    spec, rng = shipped(name, fingers), np.random.default_rng(1)
    model, step = HandModel(spec, CUBE), 1e-6
    q = rng.uniform(spec.low, spec.high)
    for k in range(len(q)):
        ends = []
        for sign in (1.0, -1.0):
            model.place(q + sign * step * np.eye(len(q))[k])
            ends.append(model.tips())
        slope = (ends[0] - ends[1]) / (2.0 * step)
        model.place(q)
        for i in range(fingers):
            assert model.jacobian(i)[:, k] == pytest.approx(slope[i], abs=1e-6)


@pytest.mark.parametrize(("name", "fingers"), HANDS)
def test_what_is_reached_is_found_again(name: str, fingers: int) -> None:
    """Of 200 places that a fingertip can be at, inverse kinematics finds a way to all but 1 %."""
    spec, rng = shipped(name, fingers), np.random.default_rng(2)
    model = HandModel(spec, CUBE)
    solver, missed = InverseKinematics(model), 0
    for _ in range(200):
        model.place(rng.uniform(spec.low, spec.high))
        target = model.tips()[0]
        q = next(solver.solutions(0, target, spec.home), None)
        if q is None:
            missed += 1
            continue
        assert (spec.low <= q).all() and (q <= spec.high).all()
        model.place(q)
        assert model.tips()[0] == pytest.approx(target, abs=ACCURACY)
    assert missed <= 2


@pytest.mark.parametrize(("name", "fingers"), HANDS)
def test_two_libraries_ask_the_same_torques(name: str, fingers: int) -> None:
    """Weight and levers of forces and moments agree to 1e-9, and are virtual work's."""
    spec, rng = shipped(name, fingers), np.random.default_rng(3)
    model, second = HandModel(spec, CUBE), SecondHand(spec, CUBE, [], True)
    efforts = Efforts(model, 9.81)
    for _ in range(20):
        q = rng.uniform(spec.low, spec.high)
        model.place(q)
        second.place(q)
        points = model.tips() + rng.uniform(-0.01, 0.01, (fingers, 3))
        assert efforts.weight() == pytest.approx(second.weight(9.81), abs=1e-9)
        assert efforts.levers(points) == pytest.approx(second.levers(points), abs=1e-9)
        assert efforts.levers(model.tips())[0, :3] == pytest.approx(model.jacobian(0), abs=1e-12)


def test_chains_of_an_arm_are_shared() -> None:
    """A TriFinger's fingers share no hinge; those of the arm share five."""
    apart, shared = (HandModel(shipped(*hand), CUBE) for hand in HANDS)
    assert np.sum(apart.chains, axis=0).max() == 1
    assert np.sum(shared.chains, axis=0).tolist() == [2] * 5 + [1] * 6


def test_links_in_the_object_are_seen() -> None:
    """An object amid a finger is hit by its links, by both libraries."""
    spec = shipped("trifinger", 3)
    first, second = HandModel(spec, CUBE, (), False), SecondHand(spec, CUBE, [], False)
    first.place(spec.home)
    pose = Pose(np.eye(3), first.tips()[0] + [0.0, 0.0, 0.02])
    first.place(spec.home, pose)
    second.place(spec.home)
    hit = first.hit(np.zeros(3))
    assert hit is not None and "object" in hit.names
    assert second.deepest(pose, np.zeros(3))[0] > 0.005
