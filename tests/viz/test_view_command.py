from __future__ import annotations

import http.client
import os
import signal
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from gm_ompl.viz.server import address, serving
from typer.testing import CliRunner

from gm_ompl.app.main import app
from gm_ompl.planfile.model import Plan


@pytest.fixture
def server() -> Iterator[Any]:
    with serving(lambda: "<p>page</p>") as opened:
        thread = threading.Thread(target=opened.serve_forever, args=(0.05,))
        thread.start()
        yield opened
        opened.shutdown()
        thread.join()


def ask(server: Any, path: str, host: str | None = None) -> http.client.HTTPResponse:
    connection = http.client.HTTPConnection("127.0.0.1", server.server_port, timeout=10)
    connection.request("GET", path, headers={} if host is None else {"Host": host})
    response = connection.getresponse()
    response.read()
    connection.close()
    return response


def test_the_server_listens_on_loopback_alone(server: Any) -> None:
    """The socket is bound to 127.0.0.1, and the address says so."""
    assert server.socket.getsockname()[0] == "127.0.0.1"
    assert address(server) == f"http://127.0.0.1:{server.server_port}/"


def test_the_server_gives_the_page_and_nothing_else(server: Any) -> None:
    """The root is the page; other paths, and names that lead here from elsewhere, are refused."""
    assert ask(server, "/").status == 200
    assert ask(server, "/?x=1").getheader("Content-Type") == "text/html; charset=utf-8"
    assert ask(server, "/etc/passwd").status == 404
    assert ask(server, "/", host="evil.example").status == 403


@pytest.mark.skipif(not Path("/proc").is_dir(), reason="reads /proc")
def test_view_says_where_and_ends_on_interrupt(slide: Plan, tmp_path: Path) -> None:
    """The command prints its address, serves the page, ends with 0 on Ctrl-C, leaves nothing."""
    plan = tmp_path / "plan.json"
    slide.save(plan)
    command = [sys.executable, "-P", "-m", "gm_ompl", "view", str(plan)]
    process = subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    try:
        assert process.stdout is not None
        line = process.stdout.readline()
        assert "http://127.0.0.1:" in line, line
        port = int(line.split("127.0.0.1:")[1].split("/")[0])
        connection = http.client.HTTPConnection("127.0.0.1", port, timeout=30)
        connection.request("GET", "/")
        assert b"<title>paper/slide</title>" in connection.getresponse().read()
        connection.close()
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=30)
    finally:
        process.kill()
    assert (process.returncode, errors.strip()) == (0, "")
    assert session_members(process.pid) == []


def session_members(session: int) -> list[int]:
    """Return the processes that still run in the command's session."""
    found = []
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit():
            try:
                if os.getsid(int(entry.name)) == session:
                    found.append(int(entry.name))
            except ProcessLookupError:
                continue
    return found


def test_html_writes_one_file(slide: Plan, tmp_path: Path) -> None:
    """``view --html`` writes the page and serves nothing; bad input writes nothing."""
    plan, target = tmp_path / "plan.json", tmp_path / "view.html"
    slide.save(plan)
    result = CliRunner().invoke(app, ["view", str(plan), "--html", str(target)])
    assert result.exit_code == 0, result.output
    assert target.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")
    other = tmp_path / "no-such-folder" / "view.html"
    result = CliRunner().invoke(app, ["view", str(plan), "--html", str(other)])
    assert result.exit_code == 2
    assert "--html" in result.stderr
    assert sorted(p.name for p in tmp_path.iterdir()) == ["plan.json", "view.html"]


def test_a_taken_port_is_bad_input(server: Any, slide: Plan, tmp_path: Path) -> None:
    """``--port`` of another program ends with 2 and names the remedy."""
    plan = tmp_path / "plan.json"
    slide.save(plan)
    result = CliRunner().invoke(app, ["view", str(plan), "--port", str(server.server_port)])
    assert result.exit_code == 2
    assert "any free port" in result.stderr
