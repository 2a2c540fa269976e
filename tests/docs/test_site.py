"""The built site: no warning, no dead end, nothing from elsewhere; search, readers, phones."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urldefrag

import pytest

from tests.docs.running import DOCS, ROOT

SAMPLE = (
    "index.html", "tutorial/first-plan.html", "how-to/notebooks.html",
    "reference/command-line.html", "reference/api.html", "background/mechanics.html",
    "results/verification.html", "gallery.html",
)  # fmt: skip
"""A page of each kind."""

SERIOUS = ("serious", "critical")


class Links(HTMLParser):
    """What a page links to, and what it loads."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.loads: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = {name: value or "" for name, value in attrs}
        if tag == "a" and "href" in found:
            self.links.append(found["href"])
        if tag in ("script", "img", "iframe") and "src" in found:
            self.loads.append(found["src"])
        if tag == "link" and found.get("rel") in ("stylesheet", "icon", "preload"):
            self.loads.append(found["href"])


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The site, built as `make docs` builds it: warnings are errors."""
    folder = tmp_path_factory.mktemp("site")
    done = subprocess.run(
        [sys.executable, "-m", "mkdocs", "build", "--strict", "--site-dir", folder],
        cwd=ROOT, capture_output=True, text=True, check=False,
        env={**os.environ, "NO_MKDOCS_2_WARNING": "1"},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]
    assert "WARNING" not in done.stderr
    return folder


def read(page: Path) -> Links:
    found = Links()
    found.feed(page.read_text(encoding="utf-8"))
    return found


def linked(site: Path, page: Path) -> set[Path]:
    """Return the site's pages that a page links to."""
    local = (urldefrag(unquote(link))[0] for link in read(page).links)
    paths = {(page.parent / link).resolve() for link in local if link and ":" not in link}
    return {path for path in paths if path.suffix == ".html" and path.is_relative_to(site)}


def test_every_page_is_two_clicks_from_home(site: Path) -> None:
    """Of all pages that are built, whatever their source."""
    home = site / "index.html"
    first = linked(site, home)
    second = {page for one in first for page in linked(site, one)}
    built = {page for page in site.rglob("*.html") if page.name != "404.html"}
    assert len(built) >= len(list(DOCS.rglob("*.md")))
    assert built - {home} - first - second == set()


def test_nothing_is_loaded_from_elsewhere(site: Path) -> None:
    """Scripts, styles, fonts and pictures are the site's own."""
    for page in site.rglob("*.html"):
        assert [one for one in read(page).loads if re.match(r"(https?:)?//", one)] == []
    for sheet in site.rglob("*.css"):
        assert re.findall(r"url\((?:https?:)?//|@import", sheet.read_text()) == []


def test_everything_generated_is_there(site: Path) -> None:
    """No mark is left, formulas are MathML, and the reference holds commands, keys, functions."""
    texts = {page: page.read_text(encoding="utf-8") for page in site.rglob("*.html")}
    assert [page for page, text in texts.items() if "generated:" in text] == []
    assert "<math" in texts[site / "background" / "mechanics.html"]
    assert 'class="arithmatex"' not in "".join(texts.values())
    reference = {path.stem: texts[path] for path in (site / "reference").glob("*.html")}
    assert "--time-limit" in reference["command-line"]
    assert "mechanics.contact_tolerance" in reference["scenario"]
    assert "HybridRRTstar" in reference["planners"]
    assert 'id="gm_ompl.api.plan"' in reference["api"]


@pytest.fixture
def tab(browser: Any) -> Iterator[Any]:
    """A tab without a network, as wide as a phone."""
    context = browser.new_context(viewport={"width": 390, "height": 844}, offline=True)
    yield context.new_page()
    context.close()


def test_no_page_scrolls_sideways_on_a_phone(site: Path, tab: Any) -> None:
    """Wide tables and formulas scroll by themselves."""
    wide = []
    for page in sorted(site.rglob("*.html")):
        tab.goto(page.as_uri())
        if tab.evaluate("document.documentElement.scrollWidth > window.innerWidth"):
            wide.append(page.relative_to(site).as_posix())
    assert wide == []


def test_search_works_offline(site: Path, tab: Any) -> None:
    """A word of a page is found, from files and without a network."""
    tab.set_viewport_size({"width": 1280, "height": 900})
    tab.goto((site / "index.html").as_uri())
    field, found = tab.locator(".md-search__input"), []
    for _ in range(40):  # what is typed before the page listens is lost
        field.fill("")
        field.press_sequentially("fingertip pocket")
        tab.wait_for_timeout(1500)
        found = tab.locator(".md-search-result__link").evaluate_all("all => all.map(a => a.href)")
        if found:
            break
    assert any("background/reach.html" in link for link in found)


@pytest.mark.parametrize("page", SAMPLE)
def test_a_screen_reader_can_read_it(site: Path, tab: Any, page: str) -> None:
    """axe finds no serious violation, in light and in dark."""
    from axe_playwright_python.sync_playwright import Axe

    for scheme in ("default", "slate"):
        tab.goto((site / page).as_uri())
        tab.evaluate(f"document.body.setAttribute('data-md-color-scheme', '{scheme}')")
        tab.wait_for_timeout(300)
        found = Axe().run(tab).response["violations"]
        told = [
            f"{scheme}: {one['id']}: {node['html'][:160]}"
            for one in found if one["impact"] in SERIOUS
            for node in one["nodes"]
        ]  # fmt: skip
        assert told == []
