"""What two mode decisions must have in common to be the same decision (fact of Sec. 3)."""

from __future__ import annotations

import numpy as np

from gm_ompl.contact.state import ContactState
from gm_ompl.problem import Problem

DECIMALS = 9
"""Contact states equal to so many decimals (lengths over D) share their decisions."""


def finger_kinds(problem: Problem) -> tuple[int, ...]:
    """Return per finger the first finger that is like it to the mechanics."""
    hand = problem.fingers
    traits = list(zip(hand.max_normal_force.tolist(), hand.friction.tolist(), strict=True))
    return tuple(traits.index(trait) for trait in traits)


def contact_key(contacts: ContactState, diagonal: float) -> bytes:
    """Return what a mode decision depends on in ``contacts``, rounded relative to D.

    The order of the contacts does not matter.
    """
    columns = (contacts.points / diagonal, contacts.normals, contacts.slip)
    # Adding zero turns -0.0 into 0.0: they are different bytes.
    rows = np.round(np.concatenate(columns, axis=1), DECIMALS) + 0.0
    rotation = np.round(contacts.rotation, DECIMALS) + 0.0
    return rows[np.lexsort(rows.T)].tobytes() + rotation.tobytes()
