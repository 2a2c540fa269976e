"""``Scenario``: a validated scenario, where it came from, and its resolved form."""

from __future__ import annotations

import copy
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any

import numpy as np
from pydantic import TypeAdapter, ValidationError

from gm_ompl.arguments import plain
from gm_ompl.errors import ScenarioError, ScenarioWarning
from gm_ompl.pictures import notebook_html
from gm_ompl.problem import Problem
from gm_ompl.scenario.build import build
from gm_ompl.scenario.checks import findings
from gm_ompl.scenario.document import Document
from gm_ompl.scenario.fields import per_finger
from gm_ompl.scenario.messages import validation_problems, value_problem
from gm_ompl.scenario.model import FORMAT, ScenarioModel
from gm_ompl.scenario.overrides import Changes, apply_overrides
from gm_ompl.scenario.shapes import with_meshes

MAX_SHOWN = 40
"""Mistakes reported at once."""


@dataclass(frozen=True, eq=False)
class Scenario:
    """A scenario whose every value has been checked.

    Attributes:
        model: the values.
        document: where each of them stands.
        problem: what the planners see.
        warnings: where the object floats or touches nothing: perhaps not what was meant.
    """

    model: ScenarioModel
    document: Document
    problem: Problem
    warnings: tuple[ScenarioWarning, ...] = ()

    @classmethod
    def from_document(cls, document: Document, overrides: Changes = ()) -> Scenario:
        """Return the scenario in ``document`` with ``overrides`` applied.

        Raises:
            ScenarioError: one line per mistake.
        """
        problems = apply_overrides(document, overrides)
        model, mistakes = _validate(document)
        problems += mistakes
        if problems or model is None:
            problems = list(dict.fromkeys(problems))
            if len(problems) > MAX_SHOWN:
                more = f"{document.label}: and {len(problems) - MAX_SHOWN} more mistakes"
                problems[MAX_SHOWN:] = [more]
            raise ScenarioError(problems)
        built = build(with_meshes(model, document), document)
        return cls(built.model, document, built.problem, built.warnings)

    @classmethod
    def from_mapping(cls, tree: Mapping[str, Any], overrides: Changes = ()) -> Scenario:
        """Return the scenario that a mapping with the file's keys describes.

        Numbers and arrays may be numpy's, lists tuples; angles are text with their unit, as in a
        file. ``format`` and ``name`` may be left out. Mesh files are looked for from the folder at
        hand.

        Raises:
            ScenarioError: one line per mistake.
        """
        document = Document("scenario", folder=FilePath())
        problems: list[str] = []
        try:
            found = plain(tree, lambda path, text: problems.append(document.line(path, text)))
        except RecursionError:
            raise ScenarioError("scenario: nested too deeply for a scenario") from None
        if problems:
            raise ScenarioError(problems)
        assert isinstance(found, dict)
        document.tree = {"format": FORMAT, "name": "unnamed", **found}
        return cls.from_document(document, overrides)

    def with_(self, changes: Changes) -> Scenario:
        """Return this scenario with some values replaced; nothing else of it changes.

        Args:
            changes: values by dotted key, list items by number, as in
                ``{"fingers.max_normal_force": 5, "motion.start.position.2": "rest"}``; or, as
                ``--set`` takes them, one "KEY=VALUE" or a list of such.

        Raises:
            ScenarioError: one line per mistake.
        """
        old = self.document
        tree, places = copy.deepcopy(old.tree), dict(old.places)
        return self.from_document(Document(old.label, tree, places, [], old.folder), changes)

    @classmethod
    def from_resolved(cls, tree: Mapping[str, Any], label: str = "scenario") -> Scenario:
        """Return the scenario that ``resolved`` wrote, for example from a plan file.

        Raises:
            ScenarioError: one line per mistake.
        """
        if not isinstance(tree, Mapping):
            raise ScenarioError(f"{label}: expected a mapping of keys (format:, name:, ...)")
        return cls.from_document(Document(label, dict(tree)))

    @property
    def name(self) -> str:
        """The scenario's name."""
        return self.model.name

    def facts(self) -> Iterator[tuple[str, str]]:
        """Yield what it is about, in words: object, hand, motion."""
        problem, motion = self.problem, self.model.motion
        size = " x ".join(f"{side:.4g}" for side in np.ptp(problem.body.vertices, axis=0))
        yield "object", f"{size}, mass {problem.mass:g}"
        count, places = problem.fingers.count, len(problem.fingers.placements.face)
        yield "fingers", f"{count}, on {places} placements"
        yield "obstacles", ", ".join(self.model.environment.obstacles) or "none"
        kind = "free" if motion.free else "planar" if motion.planar else "along a path"
        yield "motion", kind

    def __repr__(self) -> str:
        """Return a line: its name and what it is about."""
        about = "; ".join(f"{name} {text}" for name, text in self.facts())
        return f"<Scenario {self.name}: {about}>"

    def _repr_html_(self) -> str:
        return notebook_html(self)

    def resolved(self) -> dict[str, Any]:
        """Return the whole scenario with the file's keys: defaults and per-finger values filled in.

        Only plain lists, mappings, numbers and text; saved as YAML or JSON and loaded again it
        gives the identical problem. Angles are written in rad.
        """
        model = self.model
        tree: dict[str, Any] = model.model_dump(mode="json", exclude_none=True)
        n = model.fingers.count
        for section, key in (
            ("fingers", "radius"),
            ("fingers", "max_normal_force"),
            ("fingers", "soft"),
            ("friction", "finger"),
        ):
            tree[section][key] = list(per_finger(getattr(getattr(model, section), key), n))
        tree["fingers"]["clearance"] = self.problem.fingers.clearance.tolist()
        for key in ("start", "goal"):
            if isinstance(tree["fingers"][key], str):
                tree["fingers"][key] = ["any"] * n
        if model.motion.path is not None and not isinstance(model.lattice.segments, tuple):
            tree["lattice"]["segments"] = [model.lattice.segments] * len(model.motion.path)
        return tree


def _validate(document: Document) -> tuple[ScenarioModel | None, list[str]]:
    """Return the model, or None, and every mistake in the tree."""
    tree = document.tree
    assert isinstance(tree, dict)
    problems: list[str] = []
    model: ScenarioModel | None
    try:
        model = partial = ScenarioModel.model_validate(tree)
        valid = set(ScenarioModel.model_fields)
    except ValidationError as error:
        problems = validation_problems(document, error)
        model, valid = None, set(ScenarioModel.model_fields)
        valid -= {str(detail["loc"][0]) for detail in error.errors()}
        partial = _sections(tree, valid)
    for path, value, wanted in findings(partial, valid):
        if value is ...:
            problems.append(document.line(path, wanted))
        else:
            problems.append(value_problem(document, path, value, wanted))
    return model, problems


def _sections(tree: Mapping[str, Any], valid: set[str]) -> ScenarioModel:
    """Return a model of only the sections that are right, for the checks across keys."""
    values = {
        key: TypeAdapter(field.rebuild_annotation()).validate_python(tree[key])
        for key, field in ScenarioModel.model_fields.items()
        if key in valid and key in tree
    }
    return ScenarioModel.model_construct(**values)
