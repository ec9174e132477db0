"""Every error the package raises on purpose.

An error is one line: the value, why it is refused, and what to do instead.  Each class carries the exit code
of the command line and the status word stored with a run, so no other module keeps a second table of them.
"""

from __future__ import annotations

import difflib
import errno
from collections.abc import Iterable
from typing import ClassVar

_LONGEST_NAME = 80


class PeristalsisError(Exception):
    """Base of all errors of this package; ``str(error)`` is always a single line."""

    exit_code: ClassVar[int] = 1
    status: ClassVar[str] = "failed"

    def __init__(self, message: str) -> None:
        super().__init__(" ".join(message.split()))


class ConfigurationError(PeristalsisError):
    """The input is wrong: nothing was computed."""

    exit_code = 2
    status = "invalid"


class UnknownKeyError(ConfigurationError):
    """No parameter has this name."""


class ReadingNotFound(ConfigurationError):
    """No reading of the paper has this name."""


class ScenarioNotFound(ConfigurationError):
    """No scenario has this name."""


class DamagedResult(ConfigurationError):
    """A stored run does not agree with its own hashes."""

    status = "damaged"


class DivergenceError(PeristalsisError):
    """A solver failed; the history up to the last good step is kept."""

    exit_code = 3
    status = "diverged"


class StoppedRun(PeristalsisError):
    """A run that has come to its end was asked to go on."""


class WriteError(PeristalsisError):
    """A result could not be written."""

    exit_code = 4
    status = "write_failed"


class InterruptedRun(PeristalsisError):
    """The user, or a limit set by the user, stopped the run."""

    exit_code = 130
    status = "interrupted"


def could_not(action: str, error: OSError, other: str = "another folder with --out") -> WriteError:
    """The error of something that the system refused to write: what it said, and the fix for that cause.

    action: what was tried, such as "write 'out/x'"; other: what to choose instead.
    """
    fixes = {
        errno.ENOSPC: f"free some space or choose {other}",
        errno.EDQUOT: f"free some space or choose {other}",
        errno.EFBIG: f"free some space or choose {other}",
        errno.ENOTDIR: f"a file stands where a folder has to be; choose {other}",
        errno.EEXIST: f"a file stands where a folder has to be; choose {other}",
        errno.EISDIR: f"a folder stands where a file has to be; choose {other}",
        errno.EACCES: f"you may not write there; choose {other}",
        errno.EPERM: f"you may not write there; choose {other}",
        errno.EROFS: f"nothing can be written there; choose {other}",
    }
    return WriteError(
        f"could not {action}: {error.strerror or error}; {fixes.get(error.errno or 0, f'choose {other}')}"
    )


def nearest(name: str, candidates: Iterable[str]) -> str | None:
    """The candidate nearest to `name`, or None; the last part of a dotted candidate may match alone."""
    wanted = name[:_LONGEST_NAME].strip().lower()
    known = list(candidates)
    by_spelling: dict[str, str] = {}
    for candidate in known:
        by_spelling.setdefault(candidate.lower(), candidate)
    # The last parts come second, so that a full name wins over a shared ending.
    for candidate in known:
        by_spelling.setdefault(candidate.rpartition(".")[2].lower(), candidate)
    found = difflib.get_close_matches(wanted, by_spelling, n=1, cutoff=0.6)
    return by_spelling[found[0]] if found else None


def suggestion(name: str, candidates: Iterable[str]) -> str:
    """The fix of an unknown name: the nearest one, or the list when nothing is near."""
    known = list(candidates)
    near = nearest(name, known)
    if near is not None:
        return f"did you mean {near}?"
    listed = ", ".join(known[:12])
    return f"choose one of {listed}" + (", ..." if len(known) > 12 else "")


def shown(value: object, limit: int = 60) -> str:
    """A short, printable, one-line form of any value, for use in a message."""
    try:
        text = ascii(value[: 2 * limit] if isinstance(value, str) else value)
    except (ValueError, RecursionError):  # an int of thousands of digits, or a structure nested too deep
        return f"a value of type {type(value).__name__} too large to show"
    return text if len(text) <= limit else f"{text[: limit - 3]}..."
