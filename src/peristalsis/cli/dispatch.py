"""From the words of a command line to an exit code: the one place where errors become messages."""

from __future__ import annotations

import copy
import importlib
import os
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import ConfigurationError, InterruptedRun, PeristalsisError, WriteError
from .job import Job
from .signals import sigterm_as_interrupt
from .streams import Screen, forgiving_streams

TRACEBACK = "PERISTALSIS_TRACEBACK"
"""Set this variable of the environment to see where an unforeseen error came from."""

PLUGIN = "--plugin"
BESIDE = {"verify": "verification", "benchmarks": "benchmarks"}
"""Words that were commands once to the programs of the repository that do it now."""


@dataclass(frozen=True)
class Program:
    """A command line: its name in messages, and the module with its typer `app` and its `EXAMPLES` by command."""

    name: str
    module: str


PERISTALSIS = Program("peristalsis", "peristalsis.cli.commands")


def dispatch(words: Sequence[str], program: Program = PERISTALSIS) -> int:
    """Carry out a command line; what goes wrong is one line on stderr, and one JSON object with --json."""
    with forgiving_streams() as streams:
        screen = Screen(json="--json" in words)
        with sigterm_as_interrupt():
            code = _carry_out(words, screen, program)
        lost = streams.lost()
        if lost is None:
            return code
        screen.line(f"error: standard output could not be written: {lost}")
        return code or WriteError.exit_code


def _without_plugins(words: Sequence[str]) -> list[str]:
    """The words of a command without `--plugin FILE`, wherever it stands; the files are registered."""
    kept: list[str] = []
    waiting = iter(words)
    for word in waiting:
        if word == "--":
            return [*kept, word, *waiting]
        if word != PLUGIN and not word.startswith(f"{PLUGIN}="):
            kept.append(word)
            continue
        file = word.partition("=")[2] if "=" in word else next(waiting, "")
        if not file:
            raise ConfigurationError(f"{PLUGIN} needs a file; give the path of one, such as {PLUGIN} my_cell.py")
        importlib.import_module("peristalsis.plugins").load(file)
    return kept


def _carry_out(words: Sequence[str], screen: Screen, program: Program) -> int:
    try:
        if program is PERISTALSIS:
            words = _without_plugins(words)
        job = _parse(words, program)
        if isinstance(job, int):  # a help text was shown
            return job
        screen.scenario = job.scenario
        if not _has_working_folder():  # said before anything is computed that could not be written
            raise ConfigurationError("the working folder is gone: it was moved or deleted; go to another one with cd")
        return job.work(screen)
    except PeristalsisError as error:
        return screen.fail(error)
    except KeyboardInterrupt:
        return screen.fail(InterruptedRun(screen.if_interrupted))
    except MemoryError:
        return screen.fail(
            PeristalsisError(
                "not enough memory; use fewer cells, points or workers, a longer output.interval or a shorter recording"
            )
        )
    except Exception as error:
        if os.environ.get(TRACEBACK):
            raise
        cause = f"{type(error).__name__}: {error}"
        return screen.fail(
            PeristalsisError(f"unforeseen {cause} (please report it; {TRACEBACK}=1 shows where it came from)")
        )


def _has_working_folder() -> bool:
    try:
        return bool(os.getcwd())
    except FileNotFoundError:
        return False


def _parse(words: Sequence[str], program: Program) -> Job | int:
    import typer
    from typer.main import get_command

    commands = importlib.import_module(program.module)
    # Some versions of typer carry their own click, so the class of all usage errors is reached through typer.
    usage_error: type[Exception] = typer.BadParameter.__bases__[0]
    if words and words[0] in BESIDE and program.module.startswith(__package__ or ""):
        raise ConfigurationError(
            f"{words[0]} is no command of {program.name}; from the folder of its repository, where that program is, "
            f"call python -m {BESIDE[words[0]]}"
        )
    try:
        group = get_command(_needed(commands.app, words) if program is PERISTALSIS else commands.app)
        _refuse_repeated(words, group)
        parsed: Job | int | None = group.main(
            args=list(words) or list(commands.WITHOUT_WORDS), prog_name=program.name, standalone_mode=False
        )
    except typer.Abort:
        raise KeyboardInterrupt from None
    except usage_error as error:
        command = next((f" {word}" for word in words[:1] if word in commands.EXAMPLES), "")
        where = getattr(getattr(error, "ctx", None), "command_path", f"{program.name}{command}")
        said = getattr(error, "format_message", error.__str__)().rstrip(". ")
        raise ConfigurationError(f"{said}; see {where} --help") from None
    return 0 if parsed is None else parsed


def _needed(app: Any, words: Sequence[str]) -> Any:
    """A typer app as far as these words need it: reading the options of every command takes longer than most of them.

    The command that is named, alone; for a list of all commands each without its options, which it does not show.
    """
    named = [one for one in app.registered_commands if words and one.name == words[0]]
    outline = list(words) in ([], ["--help"])
    if not named and not outline:
        return app
    found = copy.copy(app)
    if named:
        found.registered_commands, found.registered_groups = named, []
    else:
        found.registered_commands = [_outlined(one) for one in app.registered_commands]
    return found


def _outlined(command: Any) -> Any:
    """A command with its description alone."""

    def described() -> None:
        """Stand for the command."""

    described.__doc__ = command.callback.__doc__
    found = copy.copy(command)
    found.callback = described
    return found


def _refuse_repeated(words: Sequence[str], group: Any) -> None:
    """An option given twice is a mistake, not a choice of the last, but for those that take several values."""
    several: set[str] = set()
    for word in (None, *words):
        group = group if word is None else getattr(group, "commands", {}).get(word, group)
        several |= {name for one in group.params if getattr(one, "multiple", False) for name in one.opts}
    options = Counter(word.partition("=")[0] for word in words if word.startswith("--") and word != "--")
    for option, count in options.items():
        if count > 1 and option not in several:
            raise ConfigurationError(f"{option} is given {count} times; keep one")
