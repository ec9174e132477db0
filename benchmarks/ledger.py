"""Measurements on disk, one by one: what an interrupted bench had measured is not measured again.

A measurement belongs to a stamp (`machine.stamp`): the sources, the libraries and the processor. What belongs to
another one is not used, and makes way as soon as there is a newer one of its name.
"""

from __future__ import annotations

import json
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from peristalsis.errors import ConfigurationError, WriteError, shown
from peristalsis.results.result import json_ready
from peristalsis.storing import disk

from . import machine

FILE = "measurements.json"
LARGEST = 64 * 2**20


class Ledger:
    """The measurements kept in FOLDER/measurements.json; without a folder, those of this process."""

    def __init__(self, folder: Path | None) -> None:
        self.file = None if folder is None else folder / FILE
        self.stamp = machine.stamp()
        self.entries: dict[str, dict[str, Any]] = {} if self.file is None else _read(self.file)

    def forget(self, effort: str, sections: Iterable[str]) -> None:
        """Leave out what these sections measured with this effort; on disk it stays until something is kept."""
        gone = set(sections)
        self.entries = {
            key: entry
            for key, entry in self.entries.items()
            if entry.get("section") not in gone or not key.startswith(f"{effort}: ")
        }

    def find(self, effort: str, name: str) -> Any:
        """A kept measurement of this stamp, or None."""
        entry = self.entries.get(f"{effort}: {name}")
        return None if entry is None or entry.get("stamp") != self.stamp else entry["value"]

    def keep(self, effort: str, name: str, value: Any, section: str = "") -> Any:
        """Keep a measurement of a section, and return it as it will be found. Raises WriteError."""
        plain = json_ready(value)
        self.entries[f"{effort}: {name}"] = {
            "stamp": self.stamp,
            "section": section,
            "measured": time.strftime("%Y-%m-%d %H:%M", time.gmtime()),
            "load": round(machine.load(), 2),
            "value": plain,
        }
        if self.file is not None:
            text = json.dumps(self.entries, indent=1, sort_keys=True, allow_nan=False) + "\n"
            try:
                disk.DISK.make_folder(self.file.parent)
                disk.replace_file(self.file, text.encode())
            except OSError as error:
                raise WriteError(
                    f"could not write {shown(str(self.file))}: {error.strerror or error}; choose another place with "
                    "--out"
                ) from None
        return plain

    def current(self, effort: str) -> Mapping[str, Mapping[str, Any]]:
        """All entries of this stamp and effort by name."""
        start = f"{effort}: "
        return {
            key.removeprefix(start): entry
            for key, entry in self.entries.items()
            if key.startswith(start) and entry.get("stamp") == self.stamp
        }


def _read(file: Path) -> dict[str, dict[str, Any]]:
    try:
        found = json.loads(disk.read_regular(file, LARGEST))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise ConfigurationError(
            f"{shown(str(file))} cannot be read ({error}); move it away, or choose another place with --out"
        ) from None
    if not isinstance(found, dict) or not all(isinstance(entry, dict) and "value" in entry for entry in found.values()):
        raise ConfigurationError(f"{shown(str(file))} holds no measurements; move it away, or choose another --out")
    return found
