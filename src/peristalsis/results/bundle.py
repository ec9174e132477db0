"""A stored run as a research object: one zip with its files and a description that other programs read.

The description is JSON-LD after RO-Crate 1.1 (https://w3id.org/ro/crate/1.1) and its profile Process Run Crate 0.5
(https://w3id.org/ro/wfrun/process/0.5): what was run, by which program, on which input, with which result.
"""

from __future__ import annotations

import io
import json
import os
import zipfile
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import ConfigurationError, WriteError, shown
from ..paths import located
from ..storing.disk import replace_file
from ..storing.manifest import FILE as MANIFEST_FILE
from ..storing.manifest import Entry
from ..storing.store import CONFIGURATION_FILE, RESULT_FILE, SUMMARY_FILE, read_file
from .result import UNFINISHED, check, read_summary

if TYPE_CHECKING:
    from ..storing.manifest import Manifest

DESCRIPTION = "ro-crate-metadata.json"
CRATE = "https://w3id.org/ro/crate/1.1"
PROFILE = "https://w3id.org/ro/wfrun/process/0.5"
RUN, PROGRAM, AGENT = "#run", "#peristalsis", "#agent"
UNSTATED = {
    "@id": "#licence",
    "@type": "CreativeWork",
    "name": "No licence is stated",
    "description": "Who made this bundle did not say how its files may be used; ask before you use them.",
}
"""Stands for the licence, which RO-Crate asks of every bundle, where none was given."""
FORMATS = {
    ".nc": "application/x-netcdf",
    ".json": "application/json",
    ".toml": "application/toml",
    ".csv": "text/csv",
    ".txt": "text/plain",
    ".npy": "application/octet-stream",
    ".png": "image/png",
    ".gif": "image/gif",
}
"""Media types by the ending of a file."""
ABOUT = {
    RESULT_FILE: "Every recorded variable with its unit, as NetCDF-4",
    SUMMARY_FILE: "The numbers of the run",
    CONFIGURATION_FILE: "All parameters of the run; runs again as it is",
    MANIFEST_FILE: "Sizes and SHA-256 of the files, versions and processor",
}
EARLIEST = (1980, 1, 1, 0, 0, 0)
"""The time that a zip gives its files, so that equal runs make equal zips."""


def bundle(
    folder: str | os.PathLike[str],
    target: str | os.PathLike[str],
    agent: str | None = None,
    licence: str | None = None,
) -> Path:
    """Write the files of a stored run and their description to `target`, a .zip.

    agent: who ran it, a name; licence: of the results, an address such as https://spdx.org/licenses/CC-BY-4.0. Neither
    is known from the run: without them the description names nobody, and says that no licence is stated. Raises
    ConfigurationError for another ending or licence or where there is no stored run, DamagedResult where it is not
    whole, WriteError where the zip cannot be written.
    """
    place, file = Path(located(folder)), located(target)
    if file.suffix.lower() != ".zip":
        raise ConfigurationError(f"bundle {shown(file.name)}: it is a zip; name a file ending in .zip")
    if licence is not None and not licence.startswith(("https://", "http://")):
        raise ConfigurationError(
            f"licence {shown(licence)} is no address; give one, such as https://spdx.org/licenses/CC-BY-4.0"
        )
    found = check(place)
    manifest = found.encode()
    entries = {**found.files, MANIFEST_FILE: Entry.of(manifest)}
    stored = datetime.fromtimestamp((place / MANIFEST_FILE).stat().st_mtime, UTC).replace(microsecond=0)
    about = described(found, read_summary(place, found), entries, stored, agent, licence)
    text = json.dumps(about, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    image = io.BytesIO()
    with zipfile.ZipFile(image, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(_member(DESCRIPTION), text)
        archive.writestr(_member(MANIFEST_FILE), manifest)
        for name, entry in sorted(found.files.items()):
            archive.writestr(_member(name), read_file(place, name, entry))
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        replace_file(file, image.getvalue())
    except OSError as error:
        raise WriteError(
            f"could not write {shown(str(file))}: {error.strerror or error}; choose another place"
        ) from None
    return file


def described(
    found: Manifest,
    summary: Mapping[str, Any],
    entries: Mapping[str, Entry],
    stored: datetime,
    agent: str | None = None,
    licence: str | None = None,
) -> dict[str, Any]:
    """The description of a run as JSON-LD; `stored` is when it was written."""
    scenario, versions = found.about.get("scenario", "run"), dict(found.about.get("versions", {}))
    title = f"Simulation of colonic propulsion: {scenario}"
    inputs = [name for name in entries if name == CONFIGURATION_FILE or name.startswith("table-")]
    results = [name for name in sorted(entries) if name not in (*inputs, MANIFEST_FILE)]
    action: dict[str, Any] = {
        "@id": RUN,
        "@type": "CreateAction",
        "name": f"peristalsis run {scenario}",
        "description": f"A run of the scenario {scenario}, which ended as: {found.status.replace('_', ' ')}",
        "instrument": _to(PROGRAM),
        "object": _links(sorted(inputs)),
        "result": _links(results),
        "endTime": stored.isoformat(),
        "actionStatus": f"http://schema.org/{'Failed' if found.status in UNFINISHED else 'Completed'}ActionStatus",
    }
    if found.status in UNFINISHED and summary.get("error"):
        action["error"] = str(summary["error"])
    root: dict[str, Any] = {
        "@id": "./",
        "@type": "Dataset",
        "name": title,
        "description": f"{title}. Status {found.status}; configuration, result and numbers, each with its hash.",
        "datePublished": stored.date().isoformat(),
        "identifier": str(found.about.get("fingerprint", "")) or None,
        "conformsTo": _to(PROFILE),
        "hasPart": [_to(name) for name in sorted(entries)],
        "mentions": _to(RUN),
        "license": _to(licence or UNSTATED["@id"]),
    }
    others = [UNSTATED if licence is None else {"@id": licence, "@type": "CreativeWork", "name": licence}]
    if agent is not None:
        action["agent"] = root["author"] = _to(AGENT)
        others.append({"@id": AGENT, "@type": "Person", "name": agent})
    own = str(versions.pop("peristalsis", "unknown"))
    libraries = [
        {"@id": f"#{name}", "@type": "SoftwareApplication", "name": name, "softwareVersion": str(number)}
        for name, number in sorted(versions.items())
    ]
    program = {
        "@id": PROGRAM,
        "@type": "SoftwareApplication",
        "name": "peristalsis",
        "softwareVersion": own,
        "identifier": str(found.about.get("code", "")) or None,
        "softwareRequirements": [_to(one["@id"]) for one in libraries],
    }
    head = {
        "@id": DESCRIPTION,
        "@type": "CreativeWork",
        "conformsTo": _to(CRATE),
        "about": _to("./"),
    }
    profile = {"@id": PROFILE, "@type": "CreativeWork", "name": "Process Run Crate", "version": "0.5"}
    files = [_file(name, entry) for name, entry in sorted(entries.items())]
    graph = [head, root, profile, action, program, *libraries, *others, *files]
    return {
        "@context": [f"{CRATE}/context", {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}],
        "@graph": [{key: value for key, value in one.items() if value is not None} for one in graph],
    }


def _file(name: str, entry: Entry) -> dict[str, Any]:
    return {
        "@id": name,
        "@type": "File",
        "name": name,
        "description": ABOUT.get(name),
        "encodingFormat": FORMATS.get(Path(name).suffix, "application/octet-stream"),
        "contentSize": str(entry.size),
        "sha256": entry.sha256,
    }


def _links(names: Sequence[str]) -> Any:
    """One reference by itself, several as a list: what JSON-LD readers expect."""
    return _to(names[0]) if len(names) == 1 else [_to(name) for name in names]


def _to(name: str) -> dict[str, str]:
    return {"@id": name}


def _member(name: str) -> zipfile.ZipInfo:
    one = zipfile.ZipInfo(name, EARLIEST)
    one.compress_type = zipfile.ZIP_DEFLATED
    one.external_attr = 0o644 << 16
    return one
