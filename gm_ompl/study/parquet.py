"""A comparison's runs as a Parquet file: the only import of pyarrow."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path
from types import ModuleType, NoneType
from typing import Any, get_args, get_type_hints

from gm_ompl.errors import MissingExtraError
from gm_ompl.study.store import RunRecord
from gm_ompl.writing import whole


def write_parquet(records: Sequence[RunRecord], path: Path) -> None:
    """Write the runs, a row each, the columns being those of ``RunRecord``.

    Parameters are JSON text; the history is a list of (time_s, cost, lower_bound). A column has the
    same type whatever the runs hold.

    Raises:
        MissingExtraError: pyarrow is not installed.
    """
    arrow, parquet = _pyarrow()
    schema = arrow.schema([(name, _type(arrow, name, hint)) for name, hint in _hints().items()])
    rows = [{name: _value(name, getattr(run, name)) for name in schema.names} for run in records]
    with whole(path) as part:
        parquet.write_table(arrow.Table.from_pylist(rows, schema=schema), part)


def _pyarrow() -> tuple[ModuleType, ModuleType]:
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise MissingExtraError("pyarrow", "parquet") from None
    return pyarrow, pyarrow.parquet


def _hints() -> dict[str, Any]:
    hints = get_type_hints(RunRecord)
    return {field.name: hints[field.name] for field in fields(RunRecord)}


def _type(arrow: ModuleType, name: str, hint: Any) -> Any:
    """Return the column type of a field: of ``X`` and of ``X | None`` the same."""
    if name == "history":
        parts = ("time_s", "cost", "lower_bound")
        return arrow.list_(arrow.struct([(part, arrow.float64()) for part in parts]))
    kinds = {float: arrow.float64(), int: arrow.int64(), bool: arrow.bool_()}
    (kind,) = [part for part in get_args(hint) or (hint,) if part is not NoneType][:1]
    return kinds.get(kind, arrow.string())


def _value(name: str, value: Any) -> Any:
    if name == "parameters":
        return json.dumps(value)
    if name == "history":
        return [dict(zip(("time_s", "cost", "lower_bound"), entry, strict=True)) for entry in value]
    return value
