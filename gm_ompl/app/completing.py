"""What a shell offers after a word that was begun: ``gm-ompl --install-completion``.

Nothing may fail here: a shell that completes shows no message.
"""

from __future__ import annotations

MOTIONS = ("slide", "tumble", "planar", "free")


def scenarios(incomplete: str) -> list[str]:
    """Return the shipped names that begin so; the shell itself offers files where none does."""
    from gm_ompl.scenario.load import shipped

    return [name for name in shipped() if name.startswith(incomplete)]


def planners(incomplete: str) -> list[str]:
    """Return the planners' names that begin so."""
    from gm_ompl.planners.registry import PLANNERS

    return [name for name in PLANNERS if name.startswith(incomplete)]


def motions(incomplete: str) -> list[str]:
    """Return the kinds of motion that begin so."""
    return [name for name in MOTIONS if name.startswith(incomplete)]
