"""The server behind the page: its files, the catalogue, downloads, and one WebSocket for everything that happens."""

from __future__ import annotations

import socket
import tempfile
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from .._version import __version__
from ..errors import ConfigurationError, PeristalsisError
from ..inputs.parameters import READINGS
from . import agents
from . import asked as asking
from .controls import CONTROLS, GRIDS, SWITCHES, live
from .lessons import LESSONS
from .runs import Runs
from .safety import Guard, Secrets
from .talk import Talk

PORT = 8765
LOOPBACK = "127.0.0.1"
LONGEST_MESSAGE = 16_384
"""Bytes of what a page may send at once; a run with every control set is a tenth of it."""
KINDS = {"html": "text/html", "css": "text/css", "js": "text/javascript", "svg": "image/svg+xml"}


@dataclass(frozen=True)
class Options:
    """How the server runs: where it listens, runs at a time, seconds that a page which has gone is waited for."""

    host: str = LOOPBACK
    port: int = PORT
    runs: int = 2
    patience: float = 30.0


@dataclass(frozen=True)
class Server:
    """The application with its guard, its secrets and the address to open."""

    application: Guard
    known: Secrets
    runs: Runs
    address: str


def listening(options: Options) -> socket.socket:
    """A socket that listens where it is asked to. Raises ConfigurationError where it cannot."""
    family = socket.AF_INET6 if ":" in options.host else socket.AF_INET
    made = socket.socket(family, socket.SOCK_STREAM)
    made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    try:
        made.bind((options.host, options.port))
    except (OSError, OverflowError) as error:
        made.close()
        raise ConfigurationError(
            f"cannot listen on {options.host} port {options.port}: {getattr(error, 'strerror', None) or error}; "
            "another app may be running there: name another port with --port, or 0 for any that is free"
        ) from None
    return made


def server(options: Options, port: int, folder: Path) -> Server:
    """The server for a port; results of runs go to a folder that is its own."""
    known = Secrets()
    runs = Runs(folder, options.runs, options.patience)
    offered = catalogue()
    asking.defaults(None, None)  # what the first page asks for is at hand
    files: dict[str, tuple[Path, str]] = {}
    name = f"[{options.host}]" if ":" in options.host else options.host
    hosts = (f"{name}:{port}", *([f"localhost:{port}"] if options.host == LOOPBACK else []))

    async def page(request: Request) -> Response:
        text = _file("index.html").decode("utf-8")
        return Response(text.replace("{token}", known.token).replace("{version}", __version__), media_type="text/html")

    async def asset(request: Request) -> Response:
        name = request.path_params["name"]
        if name not in _assets():
            return Response("There is no such file.\n", 404, media_type="text/plain")
        return Response(_file(name), media_type=KINDS[name.rpartition(".")[2]])

    async def defaults(request: Request) -> Response:
        query = request.query_params
        return _answered(lambda: asking.defaults(query.get("scenario"), query.get("reading")))

    async def download(request: Request) -> Response:
        found = files.get(request.path_params["handle"])
        if found is None or not found[0].is_file():
            return Response("This file is no longer kept; make it again.\n", 404, media_type="text/plain")
        headers = {"content-disposition": f'attachment; filename="{found[1]}"'}
        return Response(found[0].read_bytes(), media_type="application/octet-stream", headers=headers)

    async def talk(websocket: WebSocket) -> None:
        await Talk(websocket, runs, files).serve()

    @asynccontextmanager
    async def lifespan(app: Starlette) -> AsyncIterator[None]:
        await runs.prepare()
        try:
            yield
        finally:
            runs.close()

    application = Starlette(
        routes=[
            Route("/", page),
            Route("/assets/{name}", asset),
            Route("/catalogue", lambda request: JSONResponse(offered)),
            Route("/defaults", defaults),
            Route("/files/{handle}", download),
            WebSocketRoute("/talk", talk),
        ],
        lifespan=lifespan,
    )
    return Server(Guard(application, hosts, known), known, runs, f"http://{hosts[0]}/?key={known.key}")


def catalogue() -> dict[str, Any]:
    """Everything that the page offers: scenarios, readings, grids, controls, switches, agents, lessons."""
    return {
        "scenarios": [{"name": name, "title": title} for name, title in asking.offered().items()],
        "readings": list(READINGS),
        "grids": list(GRIDS),
        "controls": [
            {
                "name": one.name,
                "label": one.label,
                "group": one.group,
                "unit": one.unit,
                "low": one.low,
                "high": one.high,
                "step": one.step,
                "live": live(one.keys),
                "help": one.help,
            }
            for one in CONTROLS
        ],
        "switches": [
            {"name": one.name, "label": one.label, "live": live((one.key,)), "help": one.help} for one in SWITCHES
        ],
        "agents": [one.plain() for one in agents.offered().values()],
        "libraries": list(agents.LIBRARIES),
        "lessons": [lesson.shown() for lesson in LESSONS],
        "version": __version__,
    }


def serve(options: Options, opened: Callable[[str], None]) -> None:
    """Serve until Ctrl-C. opened: called with the address as soon as it answers. Raises ConfigurationError."""
    import uvicorn

    own = listening(options)
    port = own.getsockname()[1]
    with tempfile.TemporaryDirectory(prefix="peristalsis-app-") as folder:
        made = server(options, port, Path(folder))

        class Announced(uvicorn.Server):
            """Tells when it has started."""

            async def startup(self, sockets: list[socket.socket] | None = None) -> None:
                await super().startup(sockets)
                if self.started:
                    opened(made.address)

        settings = uvicorn.Config(
            made.application,
            log_level="warning",
            proxy_headers=False,
            server_header=False,
            ws="websockets-sansio",
            ws_max_size=LONGEST_MESSAGE,
            timeout_graceful_shutdown=1,
        )
        Announced(settings).run(sockets=[own])


def _answered(call: Callable[[], dict[str, Any]]) -> Response:
    try:
        return JSONResponse(call())
    except PeristalsisError as error:
        return JSONResponse({"error": str(error)}, 400)


def _assets() -> frozenset[str]:
    """Names of the files that the page may load."""
    return frozenset(one.name for one in _folder().iterdir() if one.name.rpartition(".")[2] in KINDS)


def _file(name: str) -> bytes:
    return _folder().joinpath(name).read_bytes()


def _folder() -> Any:
    return resources.files(__package__ or "").joinpath("page")
