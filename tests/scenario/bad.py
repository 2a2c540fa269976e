"""What tests of bad scenarios are made of."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from gm_ompl.scenario.scenario import Scenario

LoadChanged = Callable[..., Scenario]
"""Loads a valid text, changed."""


class Bad(NamedTuple):
    """A change of a valid text, and what the message must hold."""

    old: str
    new: str
    line: int
    key: str
    remedy: str
