"""The command: who may ask, what may be asked, and how it ends."""

from __future__ import annotations

import http.client
import json
import signal
import time
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from gm_ompl.app.main import app
from gm_ompl.exploring.site import LONGEST
from tests.exploring.conftest import Explored, explored

JSON = "application/json"


def ask(running: Explored, path: str, body: Any = None, **headers: str) -> tuple[int, str]:
    connection = http.client.HTTPConnection("127.0.0.1", running.port, timeout=60)
    method = "GET" if body is None else "POST"
    text = body if isinstance(body, bytes | None) else json.dumps(body).encode()
    connection.request(method, path, text, {k.replace("_", "-"): v for k, v in headers.items()})
    response = connection.getresponse()
    found = response.status, response.read().decode()
    connection.close()
    return found


def planned(running: Explored, body: Any, **headers: str) -> tuple[int, str]:
    return ask(running, running.path + "plan", body, **{"Content_Type": JSON, **headers})


def test_only_the_address_leads_to_the_page(running: Explored) -> None:
    """Without the token there is nothing; a foreign name that leads here is refused."""
    assert len(running.path) > 20
    assert ask(running, running.path)[0] == 200
    for path in ("/", "/plan", "/x" + running.path[2:], running.path + "../etc/passwd"):
        assert ask(running, path)[0] == 404, path
    for path in (running.path, running.path + "page.js"):
        assert ask(running, path, Host="evil.example")[0] == 400, path
    question = {"settings": [], "planner": "auto"}
    assert planned(running, question, Host=f"evil.example:{running.port}")[0] == 400


@pytest.mark.skipif(not Path("/proc/net/tcp").is_file(), reason="reads /proc")
def test_it_listens_on_loopback_alone(running: Explored) -> None:
    """The port is open on 127.0.0.1 and on no other address."""
    rows = [line.split()[1] for line in Path("/proc/net/tcp").read_text().splitlines()[1:]]
    six = Path("/proc/net/tcp6")
    rows += [line.split()[1] for line in six.read_text().splitlines()[1:]] if six.is_file() else []
    suffix = f":{running.port:04X}"
    assert {row.removesuffix(suffix) for row in rows if row.endswith(suffix)} == {"0100007F"}


def test_questions_are_looked_at_before_anything_is_started(running: Explored) -> None:
    """What is no question, too large or of another kind is refused with a status of its own."""
    good = {"settings": [], "planner": "auto"}
    assert planned(running, good, Content_Type="text/plain")[0] == 415
    assert planned(running, b"{")[0] == 400
    assert planned(running, b"[" * 100_000)[0] == 400
    assert planned(running, [])[0] == 400
    assert planned(running, good | {"planner": "<b>"})[0] == 400
    assert planned(running, good | {"planner": ["auto"]})[0] == 400
    assert planned(running, good | {"settings": "fingers.radius=1"})[0] == 400
    assert planned(running, good | {"settings": [1]})[0] == 400
    assert planned(running, good | {"settings": ["a=1"] * 201})[0] == 400
    assert planned(running, good | {"settings": ["a=" + "1" * LONGEST]})[0] == 413


def test_instants_are_looked_at(running: Explored) -> None:
    """An instant is lists of numbers; one that does not fit the scenario is refused in words."""
    wrong: list[Any] = [None, [], {}, {"q": [0]}, {"pose": "x"}, {"pose": [0] * 7}, {"q": [[0]]}]
    for instant in wrong:
        body = {"settings": [], "instant": instant}
        assert ask(running, running.path + "map", body, Content_Type=JSON)[0] == 400, instant
    body = {"settings": [], "instant": {"q": [2], "direction": None}}
    status, text = ask(running, running.path + "map", body, Content_Type=JSON)
    assert (status, json.loads(text)["of"]) == (200, "map")


def test_answers_are_lines(running: Explored) -> None:
    """Settings are answered by lines of JSON, of which the last is final; also bad ones."""
    status, text = planned(running, {"settings": ["object.mass=0.5"], "planner": "HybridRRT"})
    answers = [json.loads(line) for line in text.splitlines()]
    assert status == 200 and [a["final"] for a in answers] == [True]
    assert answers[0]["solved"]
    status, text = planned(running, {"settings": ["object.mass=NaN", "x"], "planner": "auto"})
    assert status == 200
    told = json.loads(text)
    assert (told["kind"], told["of"], told["final"]) == ("refused", "scenario", True)
    assert any("object.mass" in line for line in told["lines"])


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="reads /proc")
def test_it_ends_on_interrupt_and_leaves_nothing(hostile: Path) -> None:
    """Ctrl-C in the middle of a search ends the command with 0, and all its processes; no files."""
    before = sorted(hostile.parent.iterdir())
    running = explored(hostile)
    connection = http.client.HTTPConnection("127.0.0.1", running.port, timeout=60)
    question = json.dumps({"settings": ["lattice.segments=3000"], "planner": "dijkstra"})
    connection.request("POST", running.path + "plan", question, {"Content-Type": JSON})
    deadline = time.monotonic() + 60
    while len(descendants(running.process.pid)) < 2 and time.monotonic() < deadline:
        time.sleep(0.05)
    children = descendants(running.process.pid)
    assert len(children) >= 2, "a server, and a run"
    running.process.send_signal(signal.SIGINT)
    _, errors = running.process.communicate(timeout=30)
    connection.close()
    assert (running.process.returncode, errors.strip()) == (0, "")
    deadline = time.monotonic() + 10  # what is killed takes its time to be gone
    while (left := [p for p in children if Path(f"/proc/{p}").exists()]) and (
        time.monotonic() < deadline
    ):
        time.sleep(0.05)
    assert left == []
    assert sorted(hostile.parent.iterdir()) == before


def descendants(pid: int) -> list[int]:
    """Return the processes that a process has started, and they."""
    parents = {}
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                stat = (entry / "stat").read_text()
            except OSError:
                continue
            parents[int(entry.name)] = int(stat.rpartition(")")[2].split()[1])
    found, waiting = [], [pid]
    while waiting:
        above = waiting.pop()
        below = [child for child, parent in parents.items() if parent == above]
        found += below
        waiting += below
    return found


def test_bad_input_is_told_at_once() -> None:
    """No such scenario, a wrong value, a taken port or a limit of 0 end with 2 and say what."""
    for arguments, told in (
        (["paper/slied"], "paper/slide"),
        (["paper/slide", "--set", "object.mass=-1"], "object.mass"),
        (["paper/slide", "--time-limit", "0"], "--time-limit"),
        (["paper/slide", "--memory-limit", "nan"], "--memory-limit"),
    ):
        result = CliRunner().invoke(app, ["explore", *arguments])
        assert result.exit_code == 2, arguments
        assert told in result.stderr


def test_a_taken_port_is_bad_input(running: Explored) -> None:
    """``--port`` of another program ends with 2 and names the remedy."""
    result = CliRunner().invoke(app, ["explore", "paper/slide", "--port", str(running.port)])
    assert result.exit_code == 2
    assert "any free port" in result.stderr
