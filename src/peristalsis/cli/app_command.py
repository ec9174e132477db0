"""`peristalsis app`: the page in the browser."""

from __future__ import annotations

from contextlib import suppress
from typing import Annotated

import typer

from ..errors import ConfigurationError
from .job import Job
from .streams import Screen

EXAMPLES = ("peristalsis app", "peristalsis app --port 0 --no-browser")


def app_(
    port: Annotated[int, typer.Option("--port", metavar="N", help="Port; 0 takes any that is free.")] = 8765,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Open no browser; the address is printed.")] = False,
    runs: Annotated[int, typer.Option("--runs", metavar="N", help="Runs that compute at a time, 1 to 16.")] = 2,
    wait: Annotated[
        float, typer.Option("--wait", metavar="S", help="Seconds after which the runs of a closed page end.")
    ] = 30.0,
    host: Annotated[
        str,
        typer.Option("--host", metavar="ADDRESS", help="Address to listen on; any other than this machine is a risk."),
    ] = "127.0.0.1",
) -> Job:
    """Open the app in the browser: a wave squeezes a pellet while it is computed, and sliders move on the way.

    Needs the extra `app`. It listens on this machine alone, and the address that it prints holds a key, without
    which nobody can open the page. Ctrl-C ends the server and its runs.
    """
    return Job(lambda screen: _serve(port, not no_browser, runs, wait, host, screen))


def _serve(port: int, browser: bool, runs: int, wait: float, host: str, screen: Screen) -> int:
    if not 0 <= port <= 65535:
        raise ConfigurationError(f"--port={port}: give a number from 1 to 65535, or 0 for any that is free")
    if not 1 <= runs <= 16:
        raise ConfigurationError(f"--runs={runs}: give a number from 1 to 16; each run takes a core")
    if not 0.0 <= wait <= 3600.0:
        raise ConfigurationError(f"--wait={wait:g}: give seconds from 0 to 3600")
    try:
        from ..app.server import LOOPBACK, Options, serve
    except ModuleNotFoundError as error:
        raise ConfigurationError(
            f"the app needs {error.name}, which is not here; install it with pip install 'peristalsis[app]'"
        ) from None
    if not host.strip():
        raise ConfigurationError("--host is empty; give an address of this machine, or leave it out")
    if host != LOOPBACK:
        screen.line(f"warning: listening on {host}: others in its network can try to reach this page, unencrypted")

    def opened(address: str) -> None:
        screen.say(f"peristalsis app: {address}")
        screen.say("Ctrl-C ends it")
        if browser:
            import webbrowser

            webbrowser.open(address)

    with suppress(KeyboardInterrupt):  # the way to end it, and nothing is lost
        serve(Options(host, port, runs, wait), opened)
    return 0
