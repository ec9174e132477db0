"""The command line. `main` loads nothing heavy: a command imports what it needs when it is carried out."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .dispatch import Program

INTERRUPTED = 130


def main(arguments: Sequence[str] | None = None, program: Program | None = None) -> int:
    """Carry out a command line (that of the process unless given) and return its exit code; never raises.

    program: whose command line it is; that of the package unless given.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        from .dispatch import dispatch

        return dispatch(words) if program is None else dispatch(words, program)
    except KeyboardInterrupt:  # between two guarded places, such as the import above
        return INTERRUPTED
