"""What the pages show works: every block that is not marked runs as it stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from docs.tables import words
from tests.docs.running import DOCS, Block, blocks, pages, run_page

LANGUAGES = {"python", "text", "sh", "yaml", "json", "toml"}
PARTS = ("reference/scenario.md", "reference/plan.md", "how-to/many-machines.md")
"""Pages whose untitled YAML and JSON other tests load, or that show other programs' settings."""


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.stem)
def test_every_block_runs(page: Path, tmp_path: Path) -> None:
    """Commands end as they should, and Python prints what is shown."""
    run_page(page, tmp_path)


def test_nothing_is_left_out_unseen() -> None:
    """Every block is in a language that is run, loaded or compared; marks are known."""
    for page in pages():
        name = page.relative_to(DOCS).as_posix() if page.is_relative_to(DOCS) else page.name
        text = page.read_text(encoding="utf-8")
        found = list(blocks(page))
        assert len(found) == text.count("\n```") / 2, name
        for block in found:
            assert block.language in LANGUAGES, (name, block.language)
            kind = block.mark.split(":")[0]
            assert kind in ("", "in verify", "elsewhere", "exit code") or kind.startswith("end")
            whole = block.language not in ("yaml", "json", "toml") or block.title
            assert whole or name in PARTS, (name, block.code)


def test_marks_say_what_runs() -> None:
    """What takes long is left to verify, what is elsewhere to nobody."""
    assert Block("sh", "", "", "").runs(long=False)
    assert not Block("sh", "", "in verify", "").runs(long=False)
    assert Block("sh", "", "in verify", "").runs(long=True)
    assert not Block("sh", "", "elsewhere: installs", "").runs(long=True)
    assert Block("sh", "", "exit code: 3", "").exit_code == 3


def test_a_page_that_is_wrong_is_found(tmp_path: Path) -> None:
    """A command that fails, a wrong exit code, another output: each is an error."""
    for k, text in enumerate((
        "```sh\ngm-ompl plan no/such\n```\n",
        "<!-- exit code: 3 -->\n```sh\ngm-ompl list\n```\n",
        "```python\nprint(1)\n```\n\n```text\n2\n```\n",
    )):  # fmt: skip
        page = tmp_path / f"{k}.md"
        page.write_text(text)
        with pytest.raises(AssertionError):
            run_page(page, tmp_path)


def test_prose_is_short() -> None:
    """All pages together have at most 15,000 words; tables, code and generated text aside."""
    assert sum(words.pages().values()) <= words.MOST
