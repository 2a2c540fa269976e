"""Files that users name: the one place where their kind, size and encoding are looked at.

A folder, a device, a pipe, a huge or a binary file is refused in a sentence before it can block
or fill the memory, whichever verb was to read it; so is one of the project's own files of another
kind, with what to do with it.
"""

from __future__ import annotations

import os
import re
import stat
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from gm_ompl.errors import InputError

USES = {
    "plan": "`gm-ompl check`, view, plot, export and execute take it; to plan its scenario again, "
    'save what stands under its key "scenario" as a file',
    "scenario": "`gm-ompl plan FILE -o PLAN.json` makes a plan of it",
    "trace": "`gm-ompl plot PLAN.json --show search --trace FILE` draws it",
}
"""The project's own kinds of file, and what each is for."""

CLAIM = re.compile(r"""\A[\s{]*(?:#[^\n]*\s*)*["']?format["']?\s*:\s*["']?gm-ompl-(\w+)/""")
"""How such a file begins."""


@dataclass(frozen=True)
class Kind:
    """What a file is expected to be.

    Attributes:
        name: the word for it: "plan", "scenario", ...
        syntax: what it is written in.
        most: its greatest size [bytes].
        error: makes the exception of a message.
        hint: what to add to the message where there is no such file.
    """

    name: str
    syntax: str
    most: int
    error: Callable[[str], InputError] = InputError
    hint: Callable[[Path], str] = lambda _: ""


STDIN = Path("-")
"""As a file: what comes in at the standard input, read to its end."""


def read_text(path: Path, kind: Kind) -> str:
    """Return the text of ``path``, a byte order mark left out.

    Raises:
        InputError: as ``kind.error`` makes it: no file that can be read, too large, not UTF-8, or
            one of the project's other kinds of file.
    """
    label = one_line(str(path))
    content = _content(path, kind)
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise kind.error(f"{label}: is text in UTF-16, or no text; save it as UTF-8")
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise kind.error(
            f"{label}: byte {error.start} is not UTF-8 text; a {kind.name} is {kind.syntax}"
        ) from None
    claimed = CLAIM.match(text[:4096])
    refuse_other(label, f"gm-ompl-{claimed[1]}/" if claimed else None, kind)
    return text


def refuse_other(label: str, claim: object, kind: Kind) -> None:
    """Refuse a file whose key ``format`` has the value ``claim``, if that is of another kind.

    Raises:
        InputError: as ``kind.error`` makes it.
    """
    have = re.match(r"gm-ompl-(\w+)/", claim) if isinstance(claim, str) else None
    if have is not None and have[1] in USES and have[1] != kind.name:
        raise kind.error(f"{label}: is a {have[1]}, not a {kind.name}; {USES[have[1]]}")


def check_ordinary(path: Path, kind: Kind) -> None:
    """Refuse what a library could not read in the end, before it tries.

    Raises:
        InputError: as ``kind.error`` makes it: missing, not an ordinary file, or too large.
    """
    label = one_line(str(path))
    try:
        status = path.stat()
    except FileNotFoundError:
        raise kind.error(f"{label}: no such file{kind.hint(path)}") from None
    except (OSError, ValueError) as error:
        raise kind.error(f"{label}: cannot be read: {_reason(error)}") from None
    if not stat.S_ISREG(status.st_mode):
        what = "a folder" if stat.S_ISDIR(status.st_mode) else "not an ordinary file"
        raise kind.error(f"{label}: is {what}; a {kind.name} is a file in {kind.syntax}")
    if status.st_size > kind.most:
        raise kind.error(f"{label}: {status.st_size} bytes; {_limit(kind)}")


def _content(path: Path, kind: Kind) -> bytes:
    if path == STDIN:
        content = sys.stdin.buffer.read(kind.most + 1) if sys.stdin is not None else b""
        if len(content) > kind.most:
            raise kind.error(f"{path}: {_limit(kind)}")
        return content
    check_ordinary(path, kind)
    try:
        with open(os.open(path, os.O_RDONLY | os.O_NONBLOCK), "rb") as stream:
            # Some files (in /proc) do not know their size, others grow.
            content = stream.read(kind.most + 1)
    except OSError as error:
        raise kind.error(f"{one_line(str(path))}: cannot be read: {_reason(error)}") from None
    if len(content) > kind.most:
        raise kind.error(f"{one_line(str(path))}: {_limit(kind)}")
    return content


def _limit(kind: Kind) -> str:
    size = f"{kind.most / 2**20:g} MiB" if kind.most >= 2**20 else f"{kind.most} bytes"
    return f"a {kind.name} has at most {size}"


def _reason(error: OSError | ValueError) -> str:
    return getattr(error, "strerror", None) or str(error)


def one_line(text: str) -> str:
    """Return ``text`` with line breaks and other control characters written as escapes."""
    return "".join(c if c.isprintable() else repr(c)[1:-1] for c in text)


def is_text(text: str) -> bool:
    """Whether ``text`` can be written as UTF-8: a file can spell half of a surrogate pair."""
    return text.isascii() or not any("\ud800" <= c <= "\udfff" for c in text)
