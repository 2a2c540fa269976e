"""``gm-ompl explore``."""

from __future__ import annotations

import asyncio
import sys

import gm_ompl
from gm_ompl.app.commands import Exit, require_positive
from gm_ompl.app.output import note, say, show_warnings
from gm_ompl.app.verbs import ExploreVerb
from gm_ompl.errors import InputError

SERVER = "gm_ompl.app.exploring_server"


def explore_command(request: ExploreVerb) -> Exit:
    """Serve the page until interrupted.

    Raises:
        InputError: the scenario or an option is wrong, or starlette and uvicorn are missing.
    """
    require_positive(time_limit=request.time_limit, memory_limit=request.memory_limit)
    try:
        from gm_ompl.exploring.site import HOST, ExploreSite, listening, new_token, serve
    except ImportError as error:
        wanted = "explore needs starlette and uvicorn: pip install 'gm-ompl[explore]'"
        raise InputError(f"{wanted} ({error})") from error
    from gm_ompl.app.exploring_page import site_files
    from gm_ompl.exploring.pool import Pool
    from gm_ompl.exploring.race import Allowance

    overrides = request.overrides or []
    scenario = gm_ompl.load(request.scenario, overrides)
    show_warnings(scenario)
    site = ExploreSite(
        site_files(scenario, request.scenario, overrides),
        Pool(SERVER, {"scenario": request.scenario, "overrides": overrides}),
        Allowance(request.time_limit, request.memory_limit),
        new_token(),
    )
    with listening(request.port) as at:

        def started() -> None:
            address = f"http://{HOST}:{at.getsockname()[1]}/{site.token}/"
            say(f"{scenario.name} is at {address} (Ctrl-C ends)")
            sys.stdout.flush()

        asyncio.run(serve(site, at, started))
    note("")  # the terminal shows ^C on the line
    return Exit.OK
