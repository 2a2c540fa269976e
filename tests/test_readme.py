"""README.md is short, and its picture moves; what it shows runs with the pages (tests/docs)."""

from __future__ import annotations

import re
from pathlib import Path

from PIL import Image

README = Path(__file__).resolve().parents[1] / "README.md"
SCREEN = 50
"""Lines of text on a screen, about."""


def test_it_fits_two_screens() -> None:
    """Not counting the lines that only wrap the text in its file."""
    assert len(README.read_text().splitlines()) <= 2 * SCREEN


def test_its_picture_moves_and_is_small() -> None:
    """The first picture is a film of at most 1 MB in which something changes."""
    (picture, *_) = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", README.read_text())
    file = README.parent / picture
    assert file.stat().st_size < 1_000_000
    with Image.open(file) as film:
        assert film.n_frames > 20  # type: ignore[attr-defined]


def test_links_lead_somewhere() -> None:
    """Every file that is named is there."""
    links = re.findall(r"\]\(([^)#]+)", README.read_text())
    assert [link for link in links if not (README.parent / link).exists()] == []
