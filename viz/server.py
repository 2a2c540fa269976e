"""Shows a page in the browser: a server for this machine alone."""

from __future__ import annotations

import http.server
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Final

from gm_ompl.errors import InputError

HOST: Final = "127.0.0.1"  # the loopback interface: no other machine can connect


class _Server(http.server.ThreadingHTTPServer):
    daemon_threads = True  # a browser's open connection must not delay the end

    def __init__(self, port: int, make_page: Callable[[], str]) -> None:
        super().__init__((HOST, port), _Handler)
        self.make_page = make_page
        self.names = {f"{name}:{self.server_port}" for name in (HOST, "localhost")}

    def handle_error(self, request: object, client_address: object) -> None:
        """Stay silent where a browser hung up; anything else is a bug and is shown."""
        if not isinstance(sys.exception(), ConnectionError):
            super().handle_error(request, client_address)  # type: ignore[arg-type]


class _Handler(http.server.BaseHTTPRequestHandler):
    server: _Server

    def do_GET(self) -> None:
        """Answer with the page; with nothing else."""
        if self.headers.get("Host") not in self.server.names:  # a foreign name that leads here
            self.send_error(HTTPStatus.FORBIDDEN)
        elif self.path.split("?")[0] != "/":
            self.send_error(HTTPStatus.NOT_FOUND)
        else:
            body = self.server.make_page().encode("utf-8")
            self.send_response(HTTPStatus.OK)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(body)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002 (the library's name)
        """Say nothing: the terminal shows the address alone."""


@contextmanager
def serving(make_page: Callable[[], str], port: int = 0) -> Iterator[_Server]:
    """Open the server; ``serve_forever`` then answers until it is interrupted.

    Args:
        make_page: called for every visit.
        port: where to listen; 0 takes any free one.

    Raises:
        InputError: the port is taken or forbidden.
    """
    try:
        server = _Server(port, make_page)
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"--port {port}: {reason}; 0 takes any free port") from error
    try:
        yield server
    finally:
        server.server_close()


def address(server: http.server.HTTPServer) -> str:
    """Return the page's address."""
    return f"http://{HOST}:{server.server_port}/"
