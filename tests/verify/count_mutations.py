"""Files changed at random, given to every verb that reads them."""

from __future__ import annotations

import tempfile
from pathlib import Path

from tests.app.mutations import mutated
from tests.app.verbs import trouble
from tests.verify.counting import Result, count


@count(instances=500)
def mutations(instance: int) -> Result:
    """Every verb that reads a mutated file ends with 0, 2, 3, 4 or 5, and no library warns."""
    mutant = mutated(instance)
    with tempfile.TemporaryDirectory() as folder:
        found = trouble(mutant, Path(folder), instance)
    return Result(not found, note="\n".join(found), outcome=mutant.kind)
