"""The judge, against the reference's plain judgements and by hand."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gm_ompl.contact.decision import ModeDecision, Outcome
from gm_ompl.errors import InputError, SolverError
from gm_ompl.feasibility import reference_backend
from gm_ompl.feasibility.backends import BACKENDS, Backend, make_backend
from gm_ompl.feasibility.judge import Judge
from gm_ompl.feasibility.kernel_backend import KernelBackend
from gm_ompl.feasibility.reference_backend import ReferenceBackend
from gm_ompl.feasibility.verdict import Finding, Verdict
from gm_ompl.plain.judge import ReferenceJudge
from gm_ompl.problem import Problem
from gm_ompl.reference import proof
from gm_ompl.scenario.load import load


@pytest.fixture(scope="module")
def slide() -> Problem:
    """The paper's slide on a coarse grid."""
    return load("paper/slide", ["fingers.placements.grid=[2, 2]"]).problem


@pytest.mark.parametrize("seed", range(12))
def test_agrees_with_the_reference_judge(seed: int) -> None:
    """Nodes, segments and rests at random coordinates: the same verdicts, the same z."""
    problem = load(f"random/small/{seed}").problem
    judge, plain = Judge(problem, ReferenceBackend(problem)), ReferenceJudge(problem)
    rng = np.random.default_rng(seed)
    n, P = problem.fingers.count, len(problem.fingers.placements)
    for _ in range(6):
        q, dq = (float(rng.random()),), (float(rng.choice([-0.1, 0.1])),)
        placements = tuple(int(p) for p in rng.integers(0, P, n))
        pose, moment = problem.motion.pose(q), problem.motion.moment(q, dq)
        assert judge.placements_valid(pose, placements) == plain.node_valid(pose, placements)
        ours, theirs = judge.segment(moment, placements), plain.segment(moment, placements)
        assert ours.finding.name == _NAMES[theirs.finding.name]
        if ours.decision is not None and theirs.decision is not None:
            assert ours.decision.z == pytest.approx(theirs.decision.z, rel=1e-9)
        others = tuple(range(1, n))
        rest = judge.rest(pose, others, placements[1:])
        ours = Verdict.of(rest, problem.mechanics.z_min)
        assert ours.finding.name == _NAMES[plain.rest(pose, placements, 0).finding.name]


_NAMES = {
    "HOLDS": "HOLDS",
    "PENETRATION": "GEOMETRY",
    "INTERNAL_FORCE": "INTERNAL_FORCE",
    "NO_EQUILIBRIUM": "NO_EQUILIBRIUM",
    "TOO_WEAK": "UNSTABLE",
}


def test_every_finding_by_hand() -> None:
    """Each outcome of a mode decision has its finding; the threshold itself passes."""

    def finding(outcome: Outcome, z: float) -> Finding:
        return Verdict.of(ModeDecision(outcome, z), 0.5).finding

    assert finding(Outcome.STABLE, 0.5) is Finding.HOLDS
    assert finding(Outcome.STABLE, 0.49) is Finding.UNSTABLE
    assert finding(Outcome.BELOW, 0.3) is Finding.UNSTABLE
    assert finding(Outcome.INTERNAL_FORCE, -np.inf) is Finding.INTERNAL_FORCE
    assert finding(Outcome.NO_EQUILIBRIUM, -np.inf) is Finding.NO_EQUILIBRIUM


def test_two_fingertips_do_not_share_a_place(slide: Problem) -> None:
    """A placement clears itself for no pair of fingers; far corners of the top clear each other."""
    judge = Judge(slide, ReferenceBackend(slide))
    for placement in range(len(slide.fingers.placements)):
        assert not judge.apart((placement, placement))
    corners = [slide.fingers.placements.find("+z", cell) for cell in ([0, 0], [1, 1])]
    assert judge.apart(tuple(c for c in corners if c is not None))


def test_no_fingertip_under_the_object(slide: Problem) -> None:
    """On the floor, no placement of the bottom face is free, and all others are."""
    judge = Judge(slide, ReferenceBackend(slide))
    table = slide.fingers.placements
    node = judge.node(slide.motion.pose(slide.start))
    below = table.face == table.labels.index("-z")
    assert node.object_free
    assert not node.free[0][below].any()
    high = table.points[:, 2] - slide.fingers.radius[0] >= -2.5
    assert node.free[0][~below & high].all()
    assert node.free[0] is node.free[1]


def test_the_contact_state_of_a_slide_is_one(slide: Problem) -> None:
    """Along a slide nothing changes in the object's frame: one number, another one at rest."""
    judge = Judge(slide, ReferenceBackend(slide))
    forth = {
        judge.environment(slide.motion.moment((s,), (0.1,))) for s in np.linspace(0.05, 0.95, 7)
    }
    back = {
        judge.environment(slide.motion.moment((s,), (-0.1,))) for s in np.linspace(0.05, 0.95, 7)
    }
    rest = {judge.environment(slide.motion.moment((s,))) for s in np.linspace(0.05, 0.95, 7)}
    assert [len(states) for states in (forth, back, rest)] == [1, 1, 1]
    assert len(forth | back | rest) == 3


def test_decisions_are_counted_once(slide: Problem) -> None:
    """The memo answers the second time; interchangeable fingers share; forgetting starts anew."""
    backend = ReferenceBackend(slide)
    judge = Judge(slide, backend)
    top = slide.fingers.placements.find("+z", [0, 0])
    assert top is not None
    start = slide.motion.pose(slide.start)
    for _ in range(2):
        judge.rest(start, (0,), (top,))
        judge.rest(start, (1,), (top,))
    assert judge.mode_decisions == 1
    environment = judge.environment(slide.motion.moment(slide.start))
    z = judge.rest(start, (0,), (top,)).z
    assert backend.bound(environment, (1,), (top,)) == z
    backend.forget()
    assert backend.bound(environment, (1,), (top,)) == np.inf
    assert judge.rest(start, (0,), (top,)).z == z
    assert judge.mode_decisions == 2


def test_back_ends_by_name(slide: Problem) -> None:
    """Every listed back end can be made; another name is refused with the valid ones."""
    for name in BACKENDS:
        settings = dataclasses.replace(slide.mechanics, backend=name)
        make_backend(dataclasses.replace(slide, mechanics=settings))
    wrong = dataclasses.replace(slide.mechanics, backend="hihgs")
    with pytest.raises(InputError, match="did you mean 'highs'"):
        make_backend(dataclasses.replace(slide, mechanics=wrong))


def _gives_up(*_: object) -> ModeDecision:
    raise SolverError("HiGHS ended with 'Unknown'")


def test_exact_arithmetic_decides_where_highs_gives_up(slide: Problem) -> None:
    """The same outcome and z as by HiGHS."""
    rows = [slide.fingers.placements.find(face, [0, 0]) for face in ("-x", "+z")]
    pair = tuple(row for row in rows if row is not None)
    told = []
    for backend in (ReferenceBackend(slide), ReferenceBackend(slide, _gives_up)):
        judge = Judge(slide, backend)
        environment = judge.environment(slide.motion.moment((0.5,), (1.0,)))
        told.append(backend.decide(environment, (0, 1), pair))
    assert told[0].outcome is told[1].outcome is Outcome.STABLE
    assert told[1].z == pytest.approx(told[0].z, rel=1e-6)


@pytest.mark.parametrize("name", BACKENDS)
def test_what_nobody_proves_is_counted_and_optimistic_in_bounds(
    name: str, slide: Problem, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By every back end: no decision in a plan, any z in a bound."""
    monkeypatch.setattr(proof, "proven_decision", lambda _: None)
    monkeypatch.setattr(reference_backend, "proven_decision", lambda _: None)
    monkeypatch.setattr(KernelBackend, "_solve", lambda *_: None)
    made: dict[str, Backend] = {
        "kernel": KernelBackend(slide), "highs": ReferenceBackend(slide, _gives_up),
    }  # fmt: skip
    backend, judge = made[name], Judge(slide, made[name])
    environment = judge.environment(slide.motion.moment((0.5,), (1.0,)))
    assert backend.decide(environment, (0,), (0,)).outcome is Outcome.UNDECIDED
    assert backend.undecided == 1
    backend.forget()
    backend.optimistic = True
    assert backend.decide(environment, (0,), (0,)).z == np.inf
