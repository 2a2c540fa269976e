"""``python -m tests.verify [NAME ...]``: do the long counts and write their page."""

from __future__ import annotations

import argparse
import importlib
import sys
from functools import cache
from pathlib import Path

from tests.verify import counting

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "build" / "verify"
TABLE = ROOT / "docs" / "results" / "verification.md"
HEADER = """# Verification

<!-- this page is written by a program -->

Claims tried on many instances by `make verify`, which writes this page and goes on where it was
stopped. An instance is a seed: `python -m tests.verify NAME` does one count alone. The last column
has a hash of the sources that the count reached when it was done; rows of counts that were not
done again since stand as they were. A count done in part says of how many instances.

"""


def main() -> int:
    """Do the counts that are asked for; exit code 1 where a claim fails."""
    register()
    parser = argparse.ArgumentParser(prog="python -m tests.verify", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help=", ".join(counting.REGISTRY))
    parser.add_argument("-j", "--processes", type=int, default=2)
    parser.add_argument("--limit", type=int, help="only the first instances; leaves the page alone")
    options = parser.parse_args()
    unknown = [name for name in options.names if name not in counting.REGISTRY]
    if unknown:
        parser.error(
            f"no such count: {', '.join(unknown)}; there are: {', '.join(counting.REGISTRY)}"
        )
    # Before the first one runs: sources may be edited while they do.
    stores = {name: store_of(name) for name in options.names or sorted(counting.REGISTRY)}
    failed = 0
    for name, store in stores.items():
        records = counting.run(
            counting.REGISTRY[name], store, processes=options.processes, limit=options.limit
        )
        bad = counting.failures(records)
        failed += len(bad)
        sys.stdout.write(f"{name}: {len(records) - len(bad)} of {len(records)} do not fail\n")
        sys.stdout.writelines(f"  {line}\n" for line in bad)
    if options.limit is None:
        write_page()
    return 1 if failed else 0


def register() -> None:
    """Register all counts."""
    for path in sorted(Path(__file__).parent.glob("count_*.py")):
        importlib.import_module(f"tests.verify.{path.stem}")


def store_of(name: str) -> counting.Store:
    """Return the results of a count under the present sources."""
    return counting.Store(RESULTS / f"{name}.jsonl", _code(counting.REGISTRY[name].file))


@cache
def _code(file: Path) -> str:
    """Return the hash of what a file of counts reaches, as it was when first asked: a second."""
    return counting.source_hash(file, ROOT)


def write_page() -> None:
    """Write the table; counts that the present sources have no results for keep their rows."""
    results = {name: records for name in counting.REGISTRY if (records := store_of(name).read())}
    TABLE.write_text(HEADER + counting.table(results, TABLE.read_text()))


if __name__ == "__main__":
    sys.exit(main())
