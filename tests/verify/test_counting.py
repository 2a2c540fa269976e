"""The machinery of the long counts."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.verify import counting
from tests.verify.counting import Result


@pytest.fixture(autouse=True)
def _registry(monkeypatch: pytest.MonkeyPatch) -> None:
    """Counts registered here leave no trace."""
    monkeypatch.setattr(counting, "REGISTRY", {})


def test_a_second_call_does_only_what_is_missing(tmp_path: Path) -> None:
    """Instances with a result are not done again; a line cut short by a crash is."""
    calls: list[int] = []

    @counting.count(instances=4)
    def squares(instance: int) -> Result:
        """Squares are not negative."""
        calls.append(instance)
        return Result(holds=instance**2 >= 0, worst=instance / 4)

    store = counting.Store(tmp_path / "squares.jsonl", "abc")
    counting.run(counting.REGISTRY["squares"], store, processes=1, limit=2)
    with store.path.open("a") as file:
        file.write('{"instance": 2, "co')
    records = counting.run(counting.REGISTRY["squares"], store, processes=1)
    assert calls == [0, 1, 2, 3]
    assert list(records) == [0, 1, 2, 3]
    assert store.read() == records
    assert "| squares | Squares are not negative. | 4 | 4 | 0 | 0 | 0.75 |" in counting.table(
        {"squares": records}
    )


def test_results_of_other_sources_do_not_count(tmp_path: Path) -> None:
    """After a change of the sources every instance is done anew."""

    @counting.count(instances=1)
    def one(instance: int) -> Result:
        """Nothing."""
        return Result(holds=instance == 0)

    path = tmp_path / "one.jsonl"
    counting.run(counting.REGISTRY["one"], counting.Store(path, "old"), processes=1)
    assert counting.Store(path, "new").read() == {}


def test_an_exception_is_a_failure_and_a_marginal_instance_is_neither(tmp_path: Path) -> None:
    """A crash counts as a failure with its traceback; a marginal instance is counted apart."""

    @counting.count(instances=3)
    def shaky(instance: int) -> Result:
        """Holds for 0 alone."""
        if instance == 1:
            raise ValueError("one")
        return Result(holds=True, marginal=instance == 2)

    store = counting.Store(tmp_path / "shaky.jsonl", "abc")
    records = counting.run(counting.REGISTRY["shaky"], store, processes=1)
    bad = counting.failures(records)
    assert len(bad) == 1
    assert "ValueError: one" in bad[0]
    assert "| 3 | 1 | 1 | 1 |" in counting.table({"shaky": records})


def test_only_reached_sources_count(tmp_path: Path) -> None:
    """A count's hash changes with what it imports, at any depth, and with nothing else."""
    package = tmp_path / "gm_ompl"
    package.mkdir()
    for name, text in (("a", "from gm_ompl import b"), ("b", "x = 1"), ("c", "y = 1")):
        (package / f"{name}.py").write_text(text)
    file = tmp_path / "count_it.py"
    file.write_text("def f():\n    from gm_ompl.a import b\n")
    before = counting.source_hash(file, tmp_path)
    (package / "c.py").write_text("y = 2")
    assert counting.source_hash(file, tmp_path) == before
    (package / "b.py").write_text("x = 2")
    assert counting.source_hash(file, tmp_path) != before


def test_rows_stay_until_they_are_done_again(tmp_path: Path) -> None:
    """A count without results keeps its row of the earlier page; one with results gets a new."""

    @counting.count(instances=2)
    def halves(instance: int) -> counting.Result:
        """Halves are small."""
        return counting.Result(holds=True, worst=instance / 2)

    @counting.count(instances=2)
    def thirds(instance: int) -> counting.Result:
        """Thirds are smaller."""
        return counting.Result(holds=True, worst=instance / 3)

    def result(name: str) -> dict[int, counting.Record]:
        store = counting.Store(tmp_path / f"{name}.jsonl", "abc")
        return counting.run(counting.REGISTRY[name], store, processes=1)

    first = counting.table({"halves": result("halves")})
    second = counting.table({"thirds": result("thirds")}, "# Page\n\n" + first)
    assert next(line for line in first.splitlines() if "halves" in line) in second
    assert "| thirds | Thirds are smaller. | 2 | 2 | 0 | 0 | 0.333 |" in second
    assert "| abc |" in second
