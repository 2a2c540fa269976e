"""Files written whole or not at all; devices and pipes, where nothing can be replaced, directly.

And values as JSON holds them.
"""

from __future__ import annotations

import math
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from gm_ompl.errors import InputError


@contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Yield a file to write; what it holds when the block ends well becomes that of ``path``.

    Readers see the old file or the new one. A device, a pipe or the standard output is written to,
    not replaced. Where the block fails, nothing has changed.

    Raises:
        InputError: the file cannot be written.
    """
    part: Path | None = None
    try:
        directly = is_special(path) or is_stdout(path)
        folder = None if directly else path.parent
        # The suffix stays: libraries tell the format by it.
        handle, name = tempfile.mkstemp(path.suffix, f".{path.stem[:60]}-", folder)
        os.close(handle)
        part = Path(name)
        yield part
        if directly:
            _copy(part, path)
        else:
            os.chmod(part, 0o666 & ~_umask())
            os.replace(part, path)
    except OSError as error:
        raise InputError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        if part is not None:
            part.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write ``text`` in UTF-8 to ``path``, whole or not at all.

    Raises:
        InputError: the file cannot be written.
    """
    write_bytes(path, text.encode("utf-8"))


def write_bytes(path: Path, content: bytes) -> None:
    """Write ``content`` to ``path``, whole or not at all.

    Raises:
        InputError: the file cannot be written.
    """
    with whole(path) as part:
        part.write_bytes(content)


def plain(value: Any) -> Any:
    """Return ``value`` as JSON holds it.

    Values of dataclasses become mappings, members of enumerations their names, tuples lists, and
    numbers that are not finite None.
    """
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: plain(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Enum):
        return value.name.lower()
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def is_special(path: Path) -> bool:
    """Whether ``path`` is there and neither an ordinary file nor a folder: a device, a pipe."""
    return path.exists() and not path.is_file() and not path.is_dir()


def is_stdout(path: Path) -> bool:
    """Whether what is written to ``path`` comes out where the standard output does."""
    try:
        return os.path.samestat(path.stat(), os.fstat(1))
    except OSError:
        return False


def _copy(part: Path, path: Path) -> None:
    """Write the content of ``part`` to a device or pipe; a reader that leaves has had enough."""
    with part.open("rb") as source:
        if is_stdout(path):
            sys.stdout.flush()
            shutil.copyfileobj(source, sys.stdout.buffer)
            sys.stdout.flush()
            return
        with suppress(BrokenPipeError), path.open("wb", buffering=0) as target:
            while piece := source.read(1 << 16):
                left = memoryview(piece)
                while left:
                    left = left[target.write(left) :]


def _umask() -> int:
    """Return the process's umask (the system offers no way to read it without setting it)."""
    mask = os.umask(0o022)
    os.umask(mask)
    return mask
