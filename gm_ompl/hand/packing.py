"""A hand's file with everything that it needs, as text: a plan keeps it and lies anywhere."""

from __future__ import annotations

import base64
import hashlib
import os
import re
import tempfile
import zlib
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Final
from xml.etree import ElementTree

from gm_ompl.errors import HandError
from gm_ompl.hand.files import MAX_BYTES, found_mesh, parsed_file

FOLDERS: Final = {
    "mesh": "meshdir", "hfield": "meshdir", "skin": "meshdir", "texture": "texturedir",
}  # fmt: skip
"""An MJCF's elements that name files, and what of its compiler says where they are."""


def packed(path: Path, packages: Mapping[str, Path]) -> dict[str, str]:
    """Return a hand's files by plain names, the URDF or MJCF first: compressed, in base64.

    Args:
        path: a URDF or an MJCF.
        packages: folders by the names that ``package://`` paths begin with.

    Raises:
        HandError: it is not there, is neither, or names a file that is not there.
    """
    root, taken = parsed_file(path), dict[Path, str]()
    main = _plain(path.name)

    def name(found: Path) -> str:
        return taken.setdefault(found, f"{len(taken)}-{_plain(found.name)}")

    if root.tag == "robot":
        for mesh in root.iter("mesh"):
            mesh.set("filename", name(found_mesh(path, mesh.get("filename", ""), packages)))
    elif root.tag == "mujoco":
        _include(root, path.parent)
        _rename(root, path, name)
    text = ElementTree.tostring(root, encoding="utf-8")
    return {main: _written(text), **{n: _written(_read(p)) for p, n in taken.items()}}


def _plain(name: str) -> str:
    """Return a file's name with letters, digits, dots, dashes and underscores alone."""
    return re.sub(r"[^\w.-]", "_", name, flags=re.ASCII).lstrip(".") or "hand"


def _read(path: Path) -> bytes:
    try:
        return path.read_bytes()
    except OSError as error:
        raise HandError(("file",), f"{path}: {error.strerror}") from None


def _written(content: bytes) -> str:
    return base64.b64encode(zlib.compress(content, 9)).decode("ascii")


def _include(parent: ElementTree.Element, folder: Path) -> None:
    """Put what an MJCF includes where it includes it."""
    for place, child in reversed(list(enumerate(parent))):
        if child.tag == "include":
            other = parsed_file(folder / child.get("file", ""))
            _include(other, folder)
            parent[place : place + 1] = list(other)
        else:
            _include(child, folder)


def _rename(root: ElementTree.Element, path: Path, name: Callable[[Path], str]) -> None:
    """Give the files that an MJCF names plain names, in its own folder."""
    said: dict[str, str] = {}
    for compiler in root.iter("compiler"):
        for key in ("assetdir", "meshdir", "texturedir"):
            if key in compiler.attrib:
                said[key] = compiler.attrib.pop(key)
    for element in root.iter():
        if element.tag == "model" and "file" in element.attrib:
            raise HandError(("file",), f"{path}: <model file=...>: put it in by <include>")
        folder = said.get(FOLDERS.get(element.tag, ""), said.get("assetdir", ""))
        for key in [key for key in element.attrib if key.startswith("file")]:
            found = path.parent / folder / element.attrib[key]
            if element.tag in FOLDERS and found.is_file():
                element.attrib.setdefault("name", found.stem)  # as MuJoCo names it
                element.set(key, name(found.absolute()))


def unpacked(files: Mapping[str, str]) -> Path:
    """Return a folder with the files that ``packed`` returned.

    Raises:
        HandError: one of them is damaged.
    """
    digest = hashlib.sha256(repr(sorted(files.items())).encode()).hexdigest()[:32]
    contents = {name: _content(name, text) for name, text in files.items()}
    try:
        home = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
        return _in_folder(home / "gm_ompl" / "hands", digest, contents)
    except (OSError, RuntimeError):  # the user may have no home
        return _in_folder(Path(tempfile.mkdtemp(prefix="gm_ompl-")), digest, contents)


def _in_folder(home: Path, digest: str, contents: Mapping[str, bytes]) -> Path:
    """Write files into a folder of their own, whole or not at all."""
    home.mkdir(parents=True, exist_ok=True)
    folder = home / digest
    if not folder.is_dir():
        part = Path(tempfile.mkdtemp(dir=home))
        for name, content in contents.items():
            (part / name).write_bytes(content)
        with suppress(OSError):  # another process was first
            part.rename(folder)
    return folder


def _content(name: str, text: str) -> bytes:
    reader = zlib.decompressobj()
    try:
        content = reader.decompress(base64.b64decode(text, validate=True), MAX_BYTES)
    except (ValueError, zlib.error):
        content = b""
    if not reader.eof or name != _plain(name):
        raise HandError(("files", name), "damaged; give hand.file and hand.packages instead")
    return content
