"""Paths as users write them: "~" is their home, and what a file names lies beside that file."""

from __future__ import annotations

from collections.abc import Mapping
from os import PathLike
from pathlib import Path
from typing import Any

from peristalsis.errors import ConfigurationError, shown


def located(given: str | PathLike[str], beside: Path | None = None) -> Path:
    """The path that a user means. beside: the folder from which a relative one goes out; the working folder if none.

    Raises ConfigurationError for an empty text, and where "~" or "~name" has no home.
    """
    if not str(given).strip():
        raise ConfigurationError(f"{shown(str(given))}: an empty path; name a file or a folder, '.' for this one")
    path = Path(given)
    if path.parts and path.parts[0].startswith("~"):
        try:
            path = path.expanduser()
        except RuntimeError:
            raise ConfigurationError(
                f"{shown(str(given))}: {path.parts[0]} has no home folder here; write the path out, or as ./{path}"
            ) from None
    return path if beside is None or path.is_absolute() else beside / path


def beside_file(tables: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """The tables of a file in `folder` with what they name, tables of protocols and files of maps, found beside it."""
    return {key: _beside(key, value, folder) for key, value in tables.items()}


def _beside(key: str, value: Any, folder: Path) -> Any:
    if key == "protocols" and isinstance(value, str):
        head, word, file = value.partition(": step " if ": step table-" in value else ": table ")
        return f"{head}{word}{located(file.strip(), folder)}" if word and file.strip() else value
    if key == "stimuli" and isinstance(value, str) and value.strip().startswith("table "):
        return f"table {located(value.strip().removeprefix('table ').strip(), folder)}"
    if key == "file" and isinstance(value, str) and value:
        return str(located(value, folder))
    if isinstance(value, Mapping):
        return beside_file(value, folder)
    if isinstance(value, list):
        return [_beside(key, item, folder) for item in value]
    return value
