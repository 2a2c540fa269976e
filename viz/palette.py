"""Colours, told apart by people with any colour vision (Okabe and Ito's), and their meaning.

No meaning hangs on colour alone: every look also has its own shape or hatching.
"""

from __future__ import annotations

from typing import Final

POSITION: Final = 0x0072B2  # blue; a cube's frame around the fingertip
FORCE: Final = 0xD55E00  # vermilion; a ring around the fingertip, and an arrow
LIFTED: Final = 0x8C8C8C  # grey, translucent
OBJECT: Final = 0xD9B36A
EDGE: Final = 0x3A2A10
OBSTACLE: Final = 0x6F7F8F
FLOOR: Final = 0xE4E4DE
STATIC: Final = 0x111111  # a cube
SLIDING: Final = 0xCC79A7  # a ball
MARGIN: Final = 0x009E73  # z


def css(colour: int) -> str:
    """Return ``colour`` as CSS writes it."""
    return f"#{colour:06x}"
