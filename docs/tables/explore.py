"""How long a turned knob takes to be seen, and a moving picture of the page.

``python -m docs.tables.explore [PAGE]`` writes the table into ``docs/results/explore.md``;
with ``--of``
and names it prints that of other scenarios; ``--picture FILE.gif`` draws the picture. All of them
drive headless Chromium.
"""

from __future__ import annotations

import io
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Final

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

from docs.tables.pages import growing, write_page
from gm_ompl.study.report import table

SCENARIOS: Final = ("paper/slide", "paper/push", "paper/tumble", "paper/regrasp", "tasks/flip-cube")
MOVES: Final = 50
FLAGS: Final = ("--no-sandbox", "--enable-unsafe-swiftshader")
BROWSERS: Final = ("chromium", "chromium-browser", "google-chrome")

TURN: Final = """([k, part]) => new Promise((done) => {
  const range = document.querySelectorAll(".knob input[type=range]")[k];
  const before = gmExplore.answers, start = performance.now();
  range.value = part;
  range.dispatchEvent(new Event("input", { bubbles: true }));
  const look = (frames) => {
    const refused = document.body.dataset.state === "refused";
    if (refused || (gmExplore.answers > before && gmOmpl.frames > frames))
      done([(performance.now() - start) / 1000,
        ...(refused ? [false, 0] : [gmExplore.answer.solved, gmExplore.answer.cpu_s])]);
    else requestAnimationFrame(() => look(gmExplore.answers > before ? frames : gmOmpl.frames));
  };
  look(gmOmpl.frames);
})"""
"""Turns a slider; tells the seconds until the first answer to it is drawn, whether that is a plan,
and the CPU time of the run that found it."""


@contextmanager
def page_of(scenario: str, size: tuple[int, int] = (1280, 900)) -> Iterator[Any]:
    """Give the page of ``gm-ompl explore``, its first plan shown."""
    command = [sys.executable, "-P", "-m", "gm_ompl", "explore", scenario]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        try:
            assert running.stdout is not None
            address = re.findall(r"http://\S+", running.stdout.readline())[0]
            path = next(found for name in BROWSERS if (found := shutil.which(name)))
            with sync_playwright() as driver:
                browser = driver.chromium.launch(executable_path=path, args=list(FLAGS))
                tab = browser.new_page(viewport={"width": size[0], "height": size[1]})
                tab.goto(address)
                settled(tab)
                yield tab
                browser.close()
        finally:
            running.send_signal(signal.SIGINT)


def settled(tab: Any) -> None:
    """Wait until the page has no question open."""
    while tab.evaluate("document.body.dataset.state") not in ("done", "refused"):
        tab.wait_for_timeout(50)


def delays(scenario: str, moves: int) -> list[tuple[float, bool, float]]:
    """Return what ``TURN`` tells of each turn of a random slider."""
    rng = np.random.default_rng(0)
    found: list[tuple[float, bool, float]] = []
    with page_of(scenario) as tab:
        count = tab.locator(".knob").count()
        while len(found) < moves:
            k, part = int(rng.integers(count)), int(rng.integers(300, 700))
            seconds, solved, cpu = tab.evaluate(TURN, [k, part])
            found.append((seconds, solved, cpu))
            if len(found) % 5 == 0:  # else everything is soon far from where it began
                tab.click("#reset")
                settled(tab)
    return found


HEAD: Final = (
    "scenario", "median [s]", "9 of 10 within [s]", "slowest [s]", "CPU of the run [s]", "plans",
)  # fmt: skip


def _rows(scenarios: Sequence[str]) -> Iterator[list[object]]:
    for scenario in scenarios:
        found = delays(scenario, MOVES)
        seconds, solved, cpu = (np.array(column) for column in zip(*found, strict=True))
        cells = (np.median(seconds), np.quantile(seconds, 0.9), seconds.max(), np.median(cpu))
        yield [scenario, *(f"{value:.2f}" for value in cells), f"{solved.sum()} of {MOVES}"]


def picture(file: Path) -> None:
    """Draw a knob being turned, an obstacle dragged and the plan played."""
    frames: list[Image.Image] = []

    def snap(tab: Any, times: int = 1) -> None:
        image = Image.open(io.BytesIO(tab.screenshot())).convert("RGB").resize((960, 600))
        frames.extend([image.quantize(96)] * times)

    with page_of("paper/regrasp", (1280, 800)) as tab:
        snap(tab, 6)
        for _ in range(5):
            tab.locator("#handles button", has_text="wall_beside").press("ArrowRight")
        settled(tab)
        snap(tab, 6)
        for part in (450, 400, 350):
            tab.locator(".knob", has_text="f_max").locator("input[type=range]").fill(str(part))
            tab.wait_for_timeout(300)
            snap(tab)
        settled(tab)
        snap(tab, 4)
        for share in np.linspace(0.0, 1.0, 24).tolist():
            tab.evaluate("(u) => gmOmpl.seek(u * gmOmpl.duration)", share)
            tab.wait_for_timeout(80)
            snap(tab)
        snap(tab, 6)
    frames[0].save(file, save_all=True, append_images=frames[1:], duration=180, loop=0)


def main() -> None:
    """Draw the picture, print the table or write it."""
    option, rest = sys.argv[1] if len(sys.argv) > 1 else "", sys.argv[2:]
    if option == "--picture":
        picture(Path(rest[0]))
    elif option == "--of":
        sys.stdout.write(table(HEAD, list(_rows(rest))))
    else:
        write_page("explore", {"delays": growing(HEAD, _rows(SCENARIOS))})


if __name__ == "__main__":
    main()
