"""Control modes along a plan: of the combinations that are good enough, the fewest switches."""

from __future__ import annotations

from collections.abc import Sequence, Set
from itertools import pairwise

from gm_ompl.contact.decision import ControlMode, ModeDecision

PerFinger = tuple[ControlMode | None, ...]
"""Modes per finger of the whole hand; None for a finger in the air."""


def spread(decision: ModeDecision, fingers: Sequence[int], count: int) -> PerFinger:
    """Return the modes of ``decision``, made for ``fingers``, per finger of a hand of ``count``."""
    modes: list[ControlMode | None] = [None] * count
    for finger, mode in zip(fingers, decision.modes, strict=True):
        modes[finger] = mode
    return tuple(modes)


def switches(before: PerFinger, after: PerFinger) -> int:
    """Return how many fingers change their mode; lifting and touching down are no switches."""
    return sum(
        a is not None and b is not None and a is not b for a, b in zip(before, after, strict=True)
    )


Broken = tuple[int, PerFinger, PerFinger]
"""Two combinations of modes, at an instant and the next, between which no ramp holds."""


def fewest_switches(
    options: Sequence[Sequence[ModeDecision]],
    fingers: Sequence[Sequence[int]],
    count: int,
    broken: Set[Broken] = frozenset(),
) -> list[ModeDecision]:
    """Choose one decision per instant so that modes switch as rarely as can be.

    A shortest path over the instants; what is broken is passed as rarely as can be, before all
    else. Of paths with equally few switches the one with more position control is taken, then the
    one with the earlier fingers under position control.

    Args:
        options: per instant, in order, at least one decision.
        fingers: per instant, the fingers that its decisions are made for.
        count: fingers of the hand.
        broken: by the number of the first of the two instants.
    """
    layers = [
        [(spread(option, touching, count), option) for option in choices]
        for choices, touching in zip(options, fingers, strict=True)
    ]
    best = [(0, 0, *_taste(modes)) for modes, _ in layers[0]]
    comes_from: list[list[int]] = []
    for number, (before, after) in enumerate(pairwise(layers)):
        costs, parents = [], []
        for modes, _ in after:
            ways = [
                (
                    cost[0] + ((number, earlier, modes) in broken),
                    cost[1] + switches(earlier, modes),
                    *cost[2:],
                    k,
                )
                for k, (cost, (earlier, _)) in enumerate(zip(best, before, strict=True))
            ]
            least, taste = min(ways), _taste(modes)
            costs.append((*least[:2], least[2] + taste[0], least[3] + taste[1]))
            parents.append(least[4])
        best = costs
        comes_from.append(parents)
    k = min(range(len(best)), key=best.__getitem__)
    chosen = [layers[-1][k][1]]
    for layer, parents in zip(layers[-2::-1], comes_from[::-1], strict=True):
        k = parents[k]
        chosen.append(layer[k][1])
    return chosen[::-1]


def _taste(modes: PerFinger) -> tuple[int, int]:
    """Return (force-controlled fingers, their place among combinations)."""
    forces = [i for i, mode in enumerate(modes) if mode is ControlMode.FORCE]
    return len(forces), sum(1 << (len(modes) - 1 - i) for i in forces)
