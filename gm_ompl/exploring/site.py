"""One page, its scripts, and answers to its questions: the door to starlette and uvicorn.

It can be reached from this machine alone, under an address that holds a random token; a foreign
name that leads here is refused. What a page asks it asks in one request, which is given up where
the question has become another: its runs are killed at once.
"""

from __future__ import annotations

import asyncio
import json
import secrets
import signal
import socket
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from http import HTTPStatus
from typing import Any, Final

import uvicorn
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.middleware.trustedhost import TrustedHostMiddleware
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from starlette.routing import Route

from gm_ompl.errors import InputError
from gm_ompl.exploring.planners import names
from gm_ompl.exploring.pool import GoneError, Pool
from gm_ompl.exploring.race import Allowance, answers, mapped
from gm_ompl.forks import Json

HOST: Final = "127.0.0.1"  # the loopback interface: no other machine can connect
LONGEST: Final = 2**20  # bytes of a question; settings are a few thousand
MOST_SETTINGS: Final = 200
MOST_QUESTIONS: Final = 8  # under way at once: each is a process or two

HEADERS: Final = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": (
        "default-src 'none'; script-src 'self'; style-src 'unsafe-inline'; connect-src 'self'; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
    ),
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",  # the address holds the token
    "X-Content-Type-Options": "nosniff",
}


@dataclass(frozen=True, eq=False)
class ExploreSite:
    """What is served: texts by their names, "" is the page, and who answers."""

    files: dict[str, str]
    pool: Pool
    allowance: Allowance
    token: str

    def application(self) -> Starlette:
        """Return the site as an ASGI application."""
        routes = [
            Route(f"/{self.token}/", self._file),
            Route(f"/{self.token}/plan", self._plan, methods=["POST"]),
            Route(f"/{self.token}/map", self._map, methods=["POST"]),
            Route(f"/{self.token}/{{name}}", self._file),
        ]
        hosts = Middleware(TrustedHostMiddleware, allowed_hosts=[HOST, "localhost"])
        return Starlette(routes=routes, middleware=[hosts])

    async def _file(self, request: Request) -> Response:
        name = request.path_params.get("name", "")
        if name not in self.files:
            raise HTTPException(HTTPStatus.NOT_FOUND)
        kind = "text/javascript" if name else "text/html"
        return Response(self.files[name], media_type=kind, headers=HEADERS)

    async def _plan(self, request: Request) -> Response:
        question = await _question(request)
        settings, planner = _settings(question), question.get("planner")
        if planner not in names():
            raise HTTPException(HTTPStatus.BAD_REQUEST, "planner: no such planner")
        return self._streamed(answers(self.pool.run, settings, planner, self.allowance))

    async def _map(self, request: Request) -> Response:
        question = await _question(request)
        settings, instant = _settings(question), _instant(question)
        return self._streamed(mapped(self.pool.run, settings, instant, self.allowance))

    def _streamed(self, told: AsyncIterator[Json]) -> Response:
        """Return a response of lines; where the question is given up, so are the runs."""
        if self.pool.busy >= 2 * MOST_QUESTIONS:
            text = "too many searches are under way at once; close a page, or try again"
            raise HTTPException(HTTPStatus.SERVICE_UNAVAILABLE, text)
        kind = "application/x-ndjson"
        return StreamingResponse(self._lines(told), media_type=kind, headers=HEADERS)

    async def _lines(self, told: AsyncIterator[Json]) -> AsyncIterator[str]:
        """Yield the answers, one a line."""
        try:
            async for answer in told:
                yield json.dumps(answer) + "\n"
        except GoneError as error:
            lost = {"kind": "refused", "of": "server", "lines": [str(error)], "final": True}
            yield json.dumps(lost) + "\n"


async def _question(request: Request) -> Json:
    """Return the question, one JSON object of a reasonable size."""
    if request.headers.get("content-type") != "application/json":
        raise HTTPException(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "must be application/json")
    body = bytearray()
    async for part in request.stream():
        body += part
        if len(body) > LONGEST:
            text = f"the settings are longer than {LONGEST} bytes"
            raise HTTPException(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, text)
    try:
        found = json.loads(body)
    except (ValueError, RecursionError):
        found = None
    if not isinstance(found, dict):
        raise HTTPException(HTTPStatus.BAD_REQUEST, "must be one JSON object")
    return found


def _settings(question: Json) -> list[str]:
    """Return what is changed in the scenario, as ``--set`` takes it."""
    found: Any = question.get("settings")
    listed = isinstance(found, list) and all(isinstance(word, str) for word in found)
    if not listed or len(found) > MOST_SETTINGS:
        text = f"settings: must be a list of at most {MOST_SETTINGS} texts KEY=VALUE"
        raise HTTPException(HTTPStatus.BAD_REQUEST, text)
    return list(found)


def _instant(question: Json) -> Json:
    """Return an instant: coordinates and a direction or None, or a pose (7 numbers)."""
    found = question.get("instant")
    given = found if isinstance(found, dict) else {}
    rows = [row for row in given.values() if row is not None]
    listed = all(
        isinstance(row, list) and len(row) <= 7 and all(type(n) in (int, float) for n in row)
        for row in rows
    )
    pose = given.get("pose")
    turned = pose is None or (listed and len(pose) == 7 and any(pose[3:]))
    if not (listed and turned and rows and set(given) in ({"q", "direction"}, {"pose"})):
        text = "instant: must be {q, direction} or {pose}, lists of numbers"
        raise HTTPException(HTTPStatus.BAD_REQUEST, text)
    return given


def new_token() -> str:
    """Return what nobody guesses."""
    return secrets.token_urlsafe(18)


@contextmanager
def listening(port: int) -> Iterator[socket.socket]:
    """Open the socket that the site is served at.

    Args:
        port: where to listen; 0 takes any free one.

    Raises:
        InputError: the port is taken or forbidden.
    """
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as found:
        found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            found.bind((HOST, port))
        except OSError as error:
            reason = error.strerror or str(error)
            raise InputError(f"--port {port}: {reason}; 0 takes any free port") from error
        yield found


class _Server(uvicorn.Server):
    """Leaves signals to the event loop's handlers."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


async def serve(site: ExploreSite, at: socket.socket, started: Callable[[], None]) -> None:
    """Serve until interrupted; then nothing is left running.

    Args:
        site: what is served.
        at: the socket.
        started: called once the site can be reached.
    """
    server = _Server(
        uvicorn.Config(
            site.application(), loop="asyncio", http="h11", ws="none", lifespan="off",
            log_config=None, access_log=False, server_header=False, proxy_headers=False,
        )
    )  # fmt: skip

    def stop() -> None:
        site.pool.end()  # ends the answers, which the server would wait for
        server.should_exit = True

    loop = asyncio.get_running_loop()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, stop)
    at.listen()
    try:
        await site.pool.start()
        started()
        await server.serve(sockets=[at])
    finally:
        await site.pool.close()
