"""A scenario with hostile names, explored: one command for all tests."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from tests.browsers import Visit

NAME = "<script>document.title='hacked'</script><img src=x onerror=alert(1)> @@SCORE@@ ${y}"
OBSTACLE = "<img src onerror>\"'</button>"
SCENARIO = f"""
format: gm-ompl-scenario/1
name: {NAME!r}
description: "<script>alert(2)</script> \\u202e тест"
object: {{shape: {{box: [5, 10, 5]}}, mass: 1}}
friction: {{environment: 0.5, finger: 0.7}}
fingers:
  count: 2
  radius: 1
  max_normal_force: [10, 8]
  placements: {{grid: [2, 2], faces: all}}
environment:
  floor: true
  obstacles:
    zebra: {{box: {{min: [-40, -40, 0], max: [-30, -30, 3]}}}}
    "<img src onerror>\\"'</button>": {{box: {{min: [-3, 7, 0], max: [3, 9, 3]}}}}
motion:
  start: {{position: [0, 0, rest]}}
  path: [{{slide: {{by: [10, 0, 0]}}}}]
lattice: {{segments: 3}}
mechanics: {{z_min: 0.5}}
expect: {{status: solved, regrasps: 0}}
"""


@dataclass
class Explored:
    """A running command."""

    process: subprocess.Popen[str]
    address: str
    scenario: Path

    @property
    def port(self) -> int:
        return int(self.address.split(":")[2].split("/")[0])

    @property
    def path(self) -> str:
        return "/" + self.address.split("/", 3)[3]


def explored(scenario: Path) -> Explored:
    """Start the command."""
    process = subprocess.Popen(
        [sys.executable, "-P", "-m", "gm_ompl", "explore", str(scenario)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    assert process.stdout is not None
    line = process.stdout.readline()
    found = re.search(r"http://127\.0\.0\.1:\S+", line)
    assert found, (line, process.stderr.read() if process.stderr else "")
    return Explored(process, found[0], scenario)


@pytest.fixture(scope="session")
def hostile(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("explored") / "hostile.yaml"
    path.write_text(SCENARIO, encoding="utf-8")
    return path


@pytest.fixture(scope="session")
def running(hostile: Path) -> Iterator[Explored]:
    """The command, until the tests are over."""
    found = explored(hostile)
    yield found
    found.process.send_signal(signal.SIGINT)
    found.process.communicate(timeout=60)


@pytest.fixture(scope="module")
def visit(browser: Any, running: Explored) -> Iterator[Callable[..., Visit]]:
    """Return a function that opens the page in a window of its own and waits for its first plan."""
    contexts = []

    def open_page(width: int = 1280, height: int = 900, more: str = "") -> Visit:
        context = browser.new_context(viewport={"width": width, "height": height})
        contexts.append(context)
        seen = Visit(context.new_page())
        seen.listen(running.address)
        seen.tab.goto(running.address + more)
        seen.wait("window.gmExplore !== undefined")
        settled(seen)
        return seen

    yield open_page
    for context in contexts:
        context.close()


@pytest.fixture(scope="module")
def window(visit: Callable[..., Visit]) -> Visit:
    """One window for several tests."""
    return visit()


@pytest.fixture
def seen(window: Visit) -> Visit:
    """The window, as it is when it is opened."""
    window.tab.goto(window.tab.url.split("#")[0] + "#")
    if window.tab.evaluate("document.querySelector('#changed li') !== null"):
        window.tab.click("#reset")
    settled(window)
    return window


def settled(seen: Visit) -> Any:
    """Wait until the page has no question open; return its last answer."""
    seen.wait("['done', 'refused'].includes(document.body.dataset.state)")
    return seen.tab.evaluate("gmExplore.answer")
