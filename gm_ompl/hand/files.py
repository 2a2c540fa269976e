"""URDF and MJCF files: found, their meshes looked for, made ready for whoever parses them."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from gm_ompl.errors import HandError

MAX_BYTES = 16 * 1024 * 1024
"""Larger files are refused unread."""

PACKAGE = "package://"


class HandFile(NamedTuple):
    """A file that describes a hand.

    Attributes:
        path: where it is.
        text: a URDF's text with absolute mesh paths; None of an MJCF.
    """

    path: Path
    text: str | None


def read_hand(path: Path, packages: Mapping[str, Path]) -> HandFile:
    """Return a hand's file, made ready.

    Args:
        path: a URDF or an MJCF.
        packages: folders by the names that ``package://`` paths begin with; others are looked for
            among the installed Python distributions, whose code is not run.

    Raises:
        HandError: it is not there, is neither, or names a mesh that is not there.
    """
    root = parsed_file(path)
    if root.tag == "mujoco":
        return HandFile(path, None)
    if root.tag != "robot":
        wanted = "must be a URDF (<robot>) or an MJCF (<mujoco>)"
        raise HandError(("file",), f"{path}: its outermost element is <{root.tag}>; {wanted}")
    for mesh in root.iter("mesh"):
        mesh.set("filename", str(found_mesh(path, mesh.get("filename", ""), packages)))
    for old in root.findall("mujoco"):
        root.remove(old)
    # MuJoCo's own defaults weld fixed links, fingertips with them, and cut mesh paths.
    options = ElementTree.Element("mujoco")
    ElementTree.SubElement(options, "compiler", fusestatic="false", strippath="false")
    root.insert(0, options)
    return HandFile(path, ElementTree.tostring(root, encoding="unicode"))


def parsed_file(path: Path) -> ElementTree.Element:
    """Return the outermost element of a URDF or MJCF.

    Raises:
        HandError: it is not there, or no XML.
    """
    if not path.is_file():
        raise HandError(("file",), f"{path}: no such file; give the path of a URDF or MJCF")
    if path.stat().st_size > MAX_BYTES:
        raise HandError(("file",), f"{path}: larger than {MAX_BYTES} bytes; is it a URDF or MJCF?")
    try:
        return ElementTree.fromstring(path.read_bytes())
    except (ElementTree.ParseError, UnicodeError, ValueError) as error:
        wanted = "must be a URDF or MJCF (XACRO must be expanded first)"
        raise HandError(("file",), f"{path}: not valid XML: {error}; {wanted}") from None


def found_mesh(file: Path, name: str, packages: Mapping[str, Path]) -> Path:
    """Return the path of a mesh that a URDF names.

    Raises:
        HandError: it is not there.
    """
    found = file.parent / name.removeprefix("file://")
    if name.startswith(PACKAGE):
        package, _, rest = name.removeprefix(PACKAGE).partition("/")
        found = _package(file, package, packages) / rest
    if not found.is_file():
        raise HandError(("file",), f"{file}: the mesh {name} is not there: looked for {found}")
    return found.absolute()


def _package(file: Path, name: str, packages: Mapping[str, Path]) -> Path:
    if name in packages:
        return packages[name]
    try:
        return Path(str(importlib.metadata.distribution(name).locate_file(name)))
    except (importlib.metadata.PackageNotFoundError, ValueError):
        wanted = f"name its folder: hand.packages: {{{name}: FOLDER}}"
        raise HandError(("file",), f"{file}: no package {name!r} is installed; {wanted}") from None
