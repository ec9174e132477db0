"""Independent pieces of work in a few fresh processes; one that dies takes nothing along.

Each process has a pipe of its own, so it is known which piece a dead process was at: that one is tried again, the
others never notice. A process ends with the one that started it, however that ends.

Fresh processes do not read the program that started them again, so a script needs no `if __name__ == "__main__":` and
may come from anywhere, standard input too. Only where the work itself is a function of that program must they.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import threading
from collections import deque
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from multiprocessing.reduction import ForkingPickler
from pathlib import Path
from typing import Any, Generic, TypeVar

from .. import plugins
from ..errors import ConfigurationError, PeristalsisError

RETRIES = 2
PATIENCE = 5.0
"""Seconds that a process is given to leave its work in order when all are stopped."""

UNGUARDED = 86
"""Exit code of a process that found itself starting processes while it was being started."""
MAIN = "__main__"
GUARD = f'if __name__ == "{MAIN}":'

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


def carry_out(
    tasks: Mapping[str, Task], work: Callable[[Task], Value], workers: int = 1, retries: int = RETRIES
) -> Iterator[Done[Value]]:
    """Do `work` to every task and yield what comes of it, in the order in which it is finished.

    work: a function of a module, so that processes find it. workers: processes; 1 works in this one. A task whose
    process dies, or that raises something unforeseen, is tried again up to `retries` times and is then a Failure. A
    PeristalsisError, such as a disk that is full, ends everything and is raised here. Raises ConfigurationError where
    work that is a function of the program itself cannot be found by other processes.
    """
    refuse_while_starting()
    if workers <= 1 or len(tasks) <= 1:
        for key, task in tasks.items():
            yield Done(key, _attempts(work, task, retries))
        return
    yield from _in_processes(tasks, work, min(workers, len(tasks)), retries)


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


def refuse_while_starting() -> None:
    """End a process that reads a program without a guard as it is started: the one that started it says why."""
    if getattr(multiprocessing.current_process(), "_inheriting", False):
        os._exit(UNGUARDED)


def _reads_main(content: object) -> bool:
    """Whether a process must have read the program that started it to understand this."""
    return MAIN.encode("ascii") in bytes(ForkingPickler.dumps(content))


_STARTING = threading.Lock()


@contextmanager
def without_main() -> Iterator[None]:
    """While this lasts, processes that are started do not learn from which file this program came."""
    with _STARTING:
        main = vars(sys.modules[MAIN])
        kept: dict[str, Any] = {name: main[name] for name in ("__file__", "__spec__") if name in main}
        main.pop("__file__", None)
        main["__spec__"] = None
        try:
            yield
        finally:
            main.pop("__spec__", None)
            main.update(kept)


@contextmanager
def _with_main() -> Iterator[None]:
    file = getattr(sys.modules[MAIN], "__file__", None)
    if file is not None and not Path(file).is_file():
        raise ConfigurationError(
            "work of a program that comes from standard input cannot be found by other processes; save it to a file, "
            "or use one worker"
        )
    yield


class _Worker:
    """A process, its pipe, and the key of the task that it is at."""

    def __init__(self, work: Callable[[Any], Any], reads_main: bool) -> None:
        # Fresh processes: a forked one would share the state of compiled code and threads.
        context = multiprocessing.get_context("spawn")
        self.pipe, theirs = context.Pipe()
        self.process: SpawnProcess = context.Process(target=_serve, args=(theirs, work), daemon=False)
        with _with_main() if reads_main else without_main():
            self.process.start()
        theirs.close()
        self.key: str | None = None

    def start(self, key: str, task: object) -> None:
        self.key = key
        with suppress(OSError):  # it died before: seen, and tried again, where answers are taken
            self.pipe.send(task)

    def answer(self) -> tuple[bool, Any] | None:
        """(True, value) or (False, error) from a process that has answered, None from one that is dead."""
        try:
            found: tuple[bool, Any] = self.pipe.recv()
            return found
        except (EOFError, OSError):
            return None

    def death(self) -> str:
        """How the process ended, in words."""
        self.pipe.close()
        self.process.join()
        code = self.process.exitcode or 0
        if code == UNGUARDED:
            raise ConfigurationError(
                f"the program starts processes that read it again, and has no {GUARD}; put what is to be done once "
                "below such a line, or use one worker"
            )
        if code >= 0:
            return f"its process ended by itself with exit code {code}"
        name = signal.Signals(-code).name
        hint = ", for want of memory perhaps" if name == "SIGKILL" else ""
        return f"its process was ended by {name}{hint}"

    def stop(self) -> None:
        self.pipe.close()  # an idle process ends
        if self.key is not None:
            self.process.terminate()  # a run under way stops between two steps


def _in_processes(
    tasks: Mapping[str, Task], work: Callable[[Task], Value], count: int, retries: int
) -> Iterator[Done[Value]]:
    queue = deque(tasks)
    left = dict.fromkeys(tasks, retries)
    staff: list[_Worker] = []
    reads_main = _reads_main((work, next(iter(tasks.values()))))
    try:
        while queue or any(one.key is not None for one in staff):
            for one in staff:
                if one.key is None and queue:
                    key = queue.popleft()
                    one.start(key, tasks[key])
            while queue and len(staff) < count:
                one = _Worker(work, reads_main)
                staff.append(one)
                key = queue.popleft()
                one.start(key, tasks[key])
            busy = {one.pipe: one for one in staff if one.key is not None}
            for pipe in wait(list(busy)):
                one = busy[pipe]  # type: ignore[index]
                key, one.key = str(one.key), None
                answer = one.answer()
                if answer is not None and answer[0]:
                    yield Done(key, answer[1])
                    continue
                if answer is None:
                    error: object = one.death()
                    staff.remove(one)
                else:
                    error = answer[1]
                if isinstance(error, PeristalsisError):
                    raise error
                if left[key] > 0:
                    left[key] -= 1
                    queue.append(key)
                else:
                    yield Done(key, Failure(str(error)))
    finally:
        for one in staff:
            one.stop()
        for one in staff:
            one.process.join(PATIENCE)
            if one.process.is_alive():
                one.process.kill()
                one.process.join()


def _serve(pipe: Connection, work: Callable[[Any], Any]) -> None:
    """What a process does: one task after the other, until the pipe is closed."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the one who started it decides what Ctrl-C means
    threading.Thread(target=end_with_parent, daemon=True).start()
    plugins.ready()
    while True:
        try:
            task = pipe.recv()
        except EOFError:
            return
        try:
            answer: tuple[bool, object] = (True, work(task))
        except PeristalsisError as error:
            answer = (False, error)
        except Exception as error:
            answer = (False, f"{type(error).__name__}: {error}")
        try:
            pipe.send(answer)
        except OSError:
            return


def end_with_parent() -> None:
    """End this process when the one that started it has ended; for a thread of its own."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)  # at once: what a run had written stands, and its lock is free for who resumes it
