"""The door to ``gm_ompl.viz`` for values that show themselves in a notebook.

Nothing is imported before a value is shown.
"""

from __future__ import annotations

import importlib
from typing import Any


def notebook_html(value: Any) -> str:
    """Return what a notebook shows of a plan or a scenario: a picture and a table."""
    html: str = importlib.import_module("gm_ompl.viz.notebook").html_of(value)
    return html


def notebook_scene(value: Any) -> Any:
    """Return a plan's scene, to be turned and played in a notebook.

    Raises:
        MissingExtraError: meshcat is not installed.
    """
    return importlib.import_module("gm_ompl.viz.notebook").scene_of(value)
