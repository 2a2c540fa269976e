"""What mkdocs asks of us while it builds the site: generated reference, formulas without scripts.

``python -m mkdocs build`` loads this file (mkdocs.yml, ``hooks``).
"""

from __future__ import annotations

import html
import re
from collections.abc import Callable
from typing import Any, Final

from latex2mathml.converter import convert

from docs.tables import reference

GENERATED: Final[dict[str, Callable[[], str]]] = {
    "commands": reference.commands,
    "scenario keys": reference.scenario_keys,
    "plan keys": reference.plan_keys,
    "planners": reference.planners,
}
"""What stands for ``<!-- generated: NAME -->`` on a page."""

MARK: Final = re.compile(r"<!-- generated: ([a-z ]+) -->")
FORMULA: Final = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.DOTALL)

SCROLLS: Final = '<div class="wide" tabindex="0">'
"""Around what may be wider than a phone; it can be reached by keys."""


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Fill in what is generated."""
    return MARK.sub(lambda mark: GENERATED[mark[1]](), markdown)


def on_page_content(content: str, **_: Any) -> str:
    """Turn formulas into MathML, which browsers draw by themselves; let tables scroll."""
    content = FORMULA.sub(lambda found: _formula(found[3], found[2] == "["), content)
    content = content.replace("<table>", f'{SCROLLS}<table class="plain">')
    return content.replace("</table>", "</table></div>")


def on_post_page(output: str, **_: Any) -> str:
    """Name what the theme leaves without a name."""
    return output.replace('role="dialog"', 'role="dialog" aria-label="Search"')


def _formula(text: str, block: bool) -> str:
    mathml: str = convert(html.unescape(text), display="block" if block else "inline")
    mathml = mathml.replace('mathvariant="bold"', 'class="bold"')
    return f"{SCROLLS}{mathml}</div>" if block else mathml
