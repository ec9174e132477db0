"""Commands that compute nothing: what there is, what a configuration holds, where its numbers come from."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from ..errors import ConfigurationError, UnknownKeyError, shown, suggestion
from ..inputs.drugs import NOT_ADVICE
from ..paths import located
from .inputs import Input
from .streams import Screen, spelled

if TYPE_CHECKING:
    from ..inputs.config import Configuration, Entry


def show(given: Input, section: str | None, toml: bool, screen: Screen) -> int:
    """Every parameter with its value, unit, tag and source, or the file that says the same."""
    configuration = given.configuration()
    if toml:
        if section is not None:
            raise ConfigurationError(f"SECTION = {shown(section)}: --toml writes the whole file; leave one of them out")
        screen.say(configuration.to_toml().rstrip("\n"))
        screen.answer({"toml": configuration.to_toml()})
        return 0
    entries = [entry for entry in _entries(configuration) if section is None or _within(entry.key, section)]
    if section is not None and not entries:
        sections = dict.fromkeys(entry.key.partition(".")[0] for entry in _entries(configuration))
        keys = [entry.key for entry in _entries(configuration)]
        raise UnknownKeyError(f"SECTION = {shown(section)}: no such section; {suggestion(section, [*sections, *keys])}")
    texts = configuration.texts()
    screen.say(f"scenario {configuration.scenario}, reading {configuration.reading}")
    screen.table(
        ("parameter", "value", "tag", "printed in the paper", "source"),
        ((entry.key, _as_text(texts[entry.key]), entry.tag, entry.printed, _origin(entry)) for entry in entries),
    )
    if configuration.regions and section is None:
        screen.table(("region and what it multiplies",), ((region.words(),) for region in configuration.regions))
    if configuration.drugs and section is None:
        screen.table((f"drugs ({NOT_ADVICE})",), ((dose.words(),) for dose in configuration.drugs))
    screen.answer(
        {
            "scenario": configuration.scenario,
            "reading": configuration.reading,
            "drugs": [dose.table() for dose in configuration.drugs],
            "regions": [region.table() for region in configuration.regions],
            "parameters": {entry.key: asdict(entry) | {"text": texts[entry.key]} for entry in entries},
        }
    )
    return 0


def schema(screen: Screen) -> int:
    """The JSON Schema of a configuration file."""
    from ..inputs.config import json_schema

    screen.say(json.dumps(json_schema(), indent=2))
    screen.answer(json_schema())
    return 0


def validate(file: str, screen: Screen) -> int:
    """Whether a file is a valid configuration; what is wrong with it is the error."""
    from .. import scenarios
    from ..inputs.consistency import recording_of

    configuration = Input(None, file=file).configuration()
    screen.scenario = configuration.scenario
    changed = [entry.key for entry in _entries(configuration) if entry.tag == "set by user"]
    if configuration.regions != scenarios.unchanged(configuration).regions:
        changed.append("regions")
    changed += [name for name in ("protocols", "stimuli", "drugs") if getattr(configuration, name)]
    screen.say(
        f"{spelled(file)} is valid: scenario {configuration.scenario}, reading {configuration.reading}, "
        f"{len(changed)} parameters changed" + (f" ({', '.join(changed)})" if changed else "")
    )
    recording = recording_of(configuration)
    screen.say(recording.words())
    screen.answer(
        {
            "scenario": configuration.scenario,
            "reading": configuration.reading,
            "status": "valid",
            "changed": changed,
            "stored_bytes": round(recording.size),
            "digest": configuration.digest(),
        }
    )
    return 0


def cite(given: Input, screen: Screen) -> int:
    """What to cite for a run: the sources of its numbers, and the numbers that have no source."""
    from .. import scenarios
    from ..inputs.parameters import PREPARATIONS, READINGS, SOURCES

    configuration = _stored(given) or given.configuration()
    screen.scenario = configuration.scenario
    entries = list(_entries(configuration))
    user = {"set by user", "set by scenario"}
    cited = {
        source.citation: [entry.key for entry in entries if entry.tag not in user and _is_of(entry, source.short)]
        for source in SOURCES.values()
    }
    name = scenarios.get(configuration.scenario).preparation
    if name:
        own = PREPARATIONS[name]
        cited[f"{own.title}: {own.citation}; {own.fitted_on}"] = [
            entry.key for entry in entries if entry.tag not in user and _is_of(entry, own.short)
        ]
    reading = READINGS[configuration.reading]
    cited[f"reading '{reading.name}': {reading.why}"] = [
        entry.key for entry in entries if entry.tag not in user and _is_of(entry, f"reading '{reading.name}'")
    ]
    for tag in ("set by scenario", "set by user"):
        cited[tag] = [entry.key for entry in entries if entry.tag == tag]
    for dose in configuration.drugs:
        cited.setdefault(f"{dose.source} ({dose.tag}, {dose.tissue})", []).append(f"{dose.agent} on {dose.target}")
    used = {source: keys for source, keys in cited.items() if keys}
    screen.say(f"scenario {configuration.scenario}, reading {configuration.reading}")
    screen.table(
        ("numbers", "source", "parameters"),
        ((str(len(keys)), source, _few(keys)) for source, keys in used.items()),
    )
    screen.say("each number with its place in the source: peristalsis show " + configuration.scenario)
    screen.answer({"scenario": configuration.scenario, "reading": configuration.reading, "sources": used})
    return 0


def version(screen: Screen) -> int:
    """Versions of this package and of what its numbers depend on."""
    from ..storing.environment import versions

    found: Mapping[str, str] = versions()
    screen.say(", ".join(f"{name} {number}" for name, number in found.items()))
    screen.answer({**found, "platform": platform.platform()})
    return 0


def _stored(given: Input) -> Configuration | None:
    """The configuration in a folder of a stored run, if NAME is one and no scenario has this name."""
    from .. import scenarios
    from ..inputs.config import Configuration
    from ..storing.store import CONFIGURATION_FILE

    if given.name is None or given.name in scenarios.names() or not located(given.name).is_dir():
        return None
    if given.reading is not None or given.settings or given.file is not None or given.drugs:
        raise ConfigurationError(f"NAME = {shown(given.name)}: a stored run cannot be changed; leave out the options")
    return Configuration.from_record(located(given.name) / CONFIGURATION_FILE)


def _entries(configuration: Configuration) -> Iterable[Entry]:
    from .. import scenarios

    given = scenarios.given_by(configuration.scenario)
    return list(configuration.items(scenarios.unchanged(configuration), given))


def _within(key: str, section: str) -> bool:
    return key == section or key.startswith(f"{section}.")


def _as_text(value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return f"[{', '.join(map(_as_text, value))}]" if isinstance(value, list) else str(value)


def _origin(entry: Entry) -> str:
    return f"shipped: {entry.shipped} {entry.unit}".rstrip() if entry.tag.startswith("set by") else entry.source


def _is_of(entry: Entry, short: str) -> bool:
    return entry.source.startswith(f"{short}:")


def _few(keys: list[str]) -> str:
    return ", ".join(keys[:6]) + (", ..." if len(keys) > 6 else "")
