"""The workers of a Dask scheduler as an engine: any number of machines that share this package's version."""

from __future__ import annotations

import logging
import os
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future
from contextlib import contextmanager
from typing import Any

from .. import plugins
from ..errors import ConfigurationError, PeristalsisError, shown
from ..inputs.parts import CODE_VARIABLE
from ..storing.environment import code_version
from .pool import Engine

CONNECT = 10.0
"""Seconds in which a scheduler must answer."""
PATIENCE = 300.0
"""Seconds that are waited for a worker when there is none: those of a queue may be on their way."""
LEAST_WIDTH, WAITING = 64, 4
"""Pieces of work handed over at a time: so many, or so many for each worker."""

_alone = threading.Lock()


@contextmanager
def at_scheduler(address: str) -> Iterator[Engine]:
    """The engine of a scheduler, such as tcp://127.0.0.1:8786, while this lasts; it is left as it was found.

    Raises ConfigurationError where the extra `cluster` is missing, nothing answers, or its workers cannot be used.
    """
    try:
        from distributed import Client, KilledWorker
    except ImportError:
        raise ConfigurationError(
            "a scheduler needs Dask, which is not installed; install peristalsis with its extra `cluster`, or the "
            "package distributed"
        ) from None
    logging.getLogger("distributed").setLevel(logging.ERROR)  # what is lost is said in the rows
    try:
        client = Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError, TypeError, AssertionError) as error:
        said = " ".join(str(error).split())
        raise ConfigurationError(
            f"--scheduler {shown(address)}: no Dask scheduler answers there ({shown(said)}); start one with "
            "dask scheduler, or give the address that it says"
        ) from None
    try:
        _refuse_threads(client)
        width = max(LEAST_WIDTH, WAITING * len(_workers(client)))
        yield Engine(_Handed(client), width, (KilledWorker,), _deaths, _Look(client))
    finally:
        client.close()


def _workers(client: Any) -> dict[str, Any]:
    found: dict[str, Any] = client.scheduler_info(n_workers=-1)["workers"]
    return found


def _refuse_threads(client: Any) -> None:
    for name, worker in _workers(client).items():
        if worker["nthreads"] > 1:
            raise ConfigurationError(
                f"the worker {name} has {worker['nthreads']} threads, and a run needs a process of its own; start it "
                "with dask worker --nthreads 1 --nworkers N"
            )


def _deaths(error: BaseException) -> int:
    """How many workers a piece of work has killed: Dask allows some, and its own words name other ones each time."""
    return int(getattr(error, "allowed_failures", 0)) + 1


class _Look:
    """Raises when there has been no worker for too long."""

    def __init__(self, client: Any) -> None:
        self._client = client
        self._last = time.monotonic()

    def __call__(self) -> None:
        if _workers(self._client):
            self._last = time.monotonic()
        elif time.monotonic() - self._last > PATIENCE:
            raise PeristalsisError(
                f"the scheduler has had no worker for {PATIENCE:.0f} s; start some and call again, what was finished "
                "is kept"
            )


class _Handed(Executor):
    """Hands work to a scheduler together with what its workers must know of this process."""

    def __init__(self, client: Any) -> None:
        self._executor = client.get_executor(pure=False)
        self._know = (code_version(), os.environ.get(CODE_VARIABLE, ""))

    def submit(self, work: Callable[..., Any], /, *args: Any, **named: Any) -> Future[Any]:
        future: Future[Any] = self._executor.submit(_at_worker, *self._know, work, args, named)
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        self._executor.shutdown(wait=wait)


def _at_worker(code: str, files: str, work: Callable[..., Any], args: tuple[Any, ...], named: dict[str, Any]) -> Any:
    """Carry work out in a worker. Raises ConfigurationError where its equations are others than those asked for."""
    own = code_version()
    if own != code:
        raise ConfigurationError(
            f"a worker has the version {own} of the package and this process {code}; install the same for both"
        )
    with _alone:  # kernels with exchanged parts are bound for one run at a time
        if files:
            os.environ[CODE_VARIABLE] = files
            plugins.ready()
        return work(*args, **named)
