"""The manifest of a stored run: what belongs to it, with size and hash. It is written last, so it means "whole".

The file is canonical JSON that carries a hash of itself, so that every changed byte is noticed, white space included.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

FILE = "manifest.json"
FORMAT, SCHEMA = "peristalsis result", 1
LARGEST = 1_000_000
"""Bytes of a manifest that are read."""

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_.-]{0,99}")
_HASH = re.compile(r"[0-9a-f]{64}")
_STATUS = re.compile(r"[a-z_]{1,40}")


@dataclass(frozen=True, slots=True)
class Entry:
    """Size in bytes and SHA-256 of one file."""

    size: int
    sha256: str

    @classmethod
    def of(cls, content: bytes) -> Entry:
        """The entry of a file with this content."""
        return cls(len(content), hashlib.sha256(content).hexdigest())


@dataclass(frozen=True, slots=True)
class Manifest:
    """Status and files of a stored run; `about`: configuration, code, versions and machine, for people and scripts."""

    status: str
    files: Mapping[str, Entry]
    about: Mapping[str, Any] = field(default_factory=dict)

    def encode(self) -> bytes:
        """The content of manifest.json."""
        content = {
            "format": FORMAT,
            "schema": SCHEMA,
            "status": self.status,
            "files": {name: {"size": entry.size, "sha256": entry.sha256} for name, entry in self.files.items()},
            "about": self.about,
        }
        return _canonical({**content, "sha256": _hash(content)})


def decode(text: bytes) -> Manifest:
    """The manifest in the content of manifest.json. Raises ValueError with the reason if it is not one."""
    try:
        content = json.loads(text)
        if not isinstance(content, dict) or _canonical(content) != text:
            raise ValueError("it was changed, or is not a manifest")
        stated = content.pop("sha256", None)
        if stated != _hash(content):
            raise ValueError("it was changed: its own hash does not agree")
    except RecursionError:
        raise ValueError("it is nested too deeply") from None
    if content.get("format") != FORMAT or content.get("schema") != SCHEMA:
        raise ValueError(f"it is of {content.get('format')!r}, schema {content.get('schema')!r}; known is {SCHEMA}")
    status, files, about = content.get("status"), content.get("files"), content.get("about")
    if not isinstance(status, str) or not _STATUS.fullmatch(status):
        raise ValueError("it has no status")
    if not isinstance(files, dict) or not isinstance(about, dict):
        raise ValueError("it names no files")
    return Manifest(status, {name: _entry(name, entry) for name, entry in files.items()}, about)


def _entry(name: str, entry: Any) -> Entry:
    if not _NAME.fullmatch(name) or name == FILE:
        raise ValueError("it names a file outside of its folder")
    size = entry.get("size") if isinstance(entry, dict) else None
    sha256 = entry.get("sha256") if isinstance(entry, dict) else None
    if type(size) is not int or size < 0 or not isinstance(sha256, str) or not _HASH.fullmatch(sha256):
        raise ValueError(f"its entry of {name} has no size and hash")
    return Entry(size, sha256)


def _canonical(content: Any) -> bytes:
    return (json.dumps(content, sort_keys=True, indent=1, ensure_ascii=True, allow_nan=False) + "\n").encode("ascii")


def _hash(content: Any) -> str:
    return hashlib.sha256(_canonical(content)).hexdigest()
