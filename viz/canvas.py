"""Matplotlib without global state: figures that are written by their file's suffix."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, Final

from gm_ompl.errors import InputError, MissingExtraError
from gm_ompl.writing import write_bytes

COLUMN: Final = 3.4  # width of a paper's column [inch]

SUFFIXES: Final = (".png", ".svg", ".pdf")

STDOUT: Final = (Path("-"), Path("/dev/stdout"))
"""Has no suffix: what comes out there is SVG."""

_STYLE: Final[Any] = {
    "font.size": 7.0,
    "axes.titlesize": 8.0,
    "axes.labelsize": 7.0,
    "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5,
    "legend.fontsize": 6.0,
    "axes.linewidth": 0.6,
    "lines.linewidth": 1.1,
    "hatch.linewidth": 0.5,
    "svg.fonttype": "none",  # text stays text, in whatever script
    "svg.hashsalt": "gm_ompl",  # equal plans give equal files
    "pdf.fonttype": 42,
    "figure.constrained_layout.use": True,
}


@contextmanager
def styled() -> Iterator[None]:
    """Apply the project's style to figures made inside.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    try:
        import matplotlib
    except ImportError as error:
        raise MissingExtraError("matplotlib", "plot") from error
    with matplotlib.rc_context(_STYLE), warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")
        yield


def new_figure(width: float, height: float) -> Any:
    """Return an empty figure of this size [inch]; inside ``styled`` alone."""
    from matplotlib.figure import Figure

    return Figure(figsize=(width, height))


def check_suffix(path: Path) -> None:
    """Refuse a file whose suffix names no format.

    Raises:
        InputError: it is none of ``SUFFIXES``.
    """
    if path not in STDOUT and path.suffix.lower() not in SUFFIXES:
        raise InputError(f"-o {path}: the name must end in {', '.join(SUFFIXES)}; - is stdout")


def save(figure: Any, path: Path) -> None:
    """Write ``figure``; the file's suffix names the format.

    Raises:
        InputError: the file cannot be written.
    """
    check_suffix(path)
    # In memory first: matplotlib loses its way where a file fails it.
    content = BytesIO()
    save_to(content, figure, path.suffix.lower().lstrip(".") or "svg")
    write_bytes(path, content.getvalue())


def save_to(content: BytesIO, figure: Any, kind: str) -> None:
    """Write ``figure`` as "png", "svg" or "pdf"; equal figures give equal bytes."""
    dates = {"png": {}, "svg": {"Date": None}, "pdf": {"CreationDate": None}}
    figure.savefig(content, format=kind, dpi=300, metadata=dates[kind])


def title(text: str, most: int = 60) -> str:
    """Return ``text`` on one line, shortened; to be drawn with ``parse_math=False``."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= most else line[: most - 1] + "\u2026"
