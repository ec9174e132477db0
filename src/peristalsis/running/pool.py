"""Independent pieces of work by an executor; what is lost with a worker is tried again and harms nothing else.

Everything here is written against `concurrent.futures.Executor`: processes of this machine (`processes`), the workers
of a Dask scheduler (`cluster`), or any other one that a caller brings.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from ..errors import PeristalsisError

RETRIES = 1
"""A piece of work that fails twice, or loses its worker twice, is a failure."""
_LOOK = 5.0
"""Seconds between two looks at whether there are workers at all."""

Task = TypeVar("Task")
Value = TypeVar("Value")


@dataclass(frozen=True)
class Failure:
    """Why a piece of work has no value, after every attempt."""

    error: str


@dataclass(frozen=True)
class Done(Generic[Value]):
    """The value of a piece of work, or why there is none."""

    key: str
    value: Value | Failure


@dataclass(frozen=True)
class Engine:
    """An executor that is open, None for this process, and how many pieces of work it is given at a time.

    hopeless: errors after which a piece is not tried again, because the executor has done so itself. deaths: how many
    workers died of a piece, by such an error. look: called now and then while all wait; raises where none is left.
    """

    executor: Executor | None = None
    width: int = 1
    hopeless: tuple[type[BaseException], ...] = ()
    deaths: Callable[[BaseException], int] = lambda error: 1
    look: Callable[[], None] = lambda: None


Workers = int | str | Engine
"""Processes of this machine (1: this one), the address of a Dask scheduler, or an engine that is open already."""


@contextmanager
def engine_of(workers: Workers, most: int | None = None) -> Iterator[Engine]:
    """The engine of these workers while this lasts; one that is open already stays open.

    most: more processes than these are not started. Raises ConfigurationError for a scheduler that cannot be used.
    """
    if isinstance(workers, Engine):
        yield workers
        return
    if isinstance(workers, str):
        from .cluster import at_scheduler

        with at_scheduler(workers) as engine:
            yield engine
        return
    count = workers if most is None else min(workers, most)
    if count <= 1:
        yield Engine()
        return
    from .processes import Processes

    executor = Processes(count)
    try:
        yield Engine(executor, count)
    except BaseException:
        executor.shutdown(cancel_futures=True)
        raise
    executor.shutdown()


def carry_out(
    tasks: Mapping[str, Task], work: Callable[[Task], Value], workers: Workers = 1, retries: int = RETRIES
) -> Iterator[Done[Value]]:
    """Do `work` to every task and yield what comes of it, in the order in which it is finished.

    A task whose worker dies, or that raises something unforeseen, is tried again up to `retries` times and is then a
    Failure. A PeristalsisError, such as a disk that is full, ends everything and is raised here.
    """
    with engine_of(workers, len(tasks)) as engine:
        if engine.executor is None:
            for key, task in tasks.items():
                yield Done(key, _attempts(work, task, retries))
        else:
            yield from _by(engine, engine.executor, tasks, work, retries)


def _attempts(work: Callable[[Task], Value], task: Task, retries: int) -> Value | Failure:
    for attempt in range(retries + 1):
        try:
            return work(task)
        except PeristalsisError:
            raise
        except Exception as error:
            if attempt == retries:
                return Failure(f"{type(error).__name__}: {error}")
    raise AssertionError("there is at least one attempt")  # pragma: no cover


def _by(
    engine: Engine, executor: Executor, tasks: Mapping[str, Task], work: Callable[[Task], Value], retries: int
) -> Iterator[Done[Value]]:
    queue = deque(tasks)
    attempts = dict.fromkeys(tasks, 0)
    under_way: dict[Future[Any], str] = {}
    try:
        while queue or under_way:
            while queue and len(under_way) < engine.width:
                key = queue.popleft()
                under_way[executor.submit(work, tasks[key])] = key
            done, _ = wait(under_way, timeout=_LOOK, return_when=FIRST_COMPLETED)
            if not done:
                engine.look()
            for future in done:
                key = under_way.pop(future)
                error = future.exception()
                if error is None:
                    yield Done(key, future.result())
                    continue
                if isinstance(error, PeristalsisError) or not isinstance(error, Exception):
                    raise error
                attempts[key] += 1
                if isinstance(error, engine.hopeless):
                    yield Done(key, Failure(f"its process died{_times(engine.deaths(error))}"))
                elif attempts[key] > retries:
                    yield Done(key, Failure(_said(error, attempts[key])))
                else:
                    queue.append(key)
    except BaseException:
        for future in under_way:
            future.cancel()
        raise


def _said(error: BaseException, attempts: int) -> str:
    if not isinstance(error, BrokenExecutor):
        return f"{type(error).__name__}: {error}"
    from .processes import death

    return f"{death(error)}{_times(attempts)}"


def _times(count: int) -> str:
    return f", {count} times" if count > 1 else ""
