"""The sampled configurations: case k is the same for every count of cases and of workers."""

from __future__ import annotations

import hashlib
import json
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from peristalsis import configuration

RANGES = Path(__file__).with_name("ranges.toml")
READINGS = ("tight", "stretched", "printed")
SEED = 20260
COUNT = 440
QUICK_COUNT = 60

COMMON = {"output.interval": "20 ms", "output.fields": "[stretch_longitudinal]"}
"""What every case has: it stores little."""
QUICK = {"grid.n_z": "400", "grid.n_z_wall": "200"}
"""Grids of the everyday plan: a quarter of the cost, and a remark of the run where they are too coarse."""


@dataclass(frozen=True)
class Case:
    """One configuration: what it starts from, and what is changed. `variant` names how it differs from case `index`."""

    index: int
    group: str
    scenario: str
    reading: str
    changes: Mapping[str, str]
    common: Mapping[str, str] = field(default_factory=dict)
    variant: str = ""

    def all_changes(self) -> dict[str, str]:
        """Everything that is laid over the scenario; what the group varies wins."""
        return {**self.common, **self.changes}

    def key(self) -> str:
        """Digest of the case; equal cases have one, whatever their index."""
        content = [self.scenario, self.reading, sorted(self.all_changes().items())]
        return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:16]

    def varied(self, name: str, changes: Mapping[str, str]) -> Case:
        """The same with further changes."""
        return replace(self, changes={**self.changes, **changes}, variant=name)


@cache
def ranges() -> dict[str, Any]:
    """The tables of ranges.toml."""
    return tomllib.loads(RANGES.read_text(encoding="utf-8"))


def groups() -> tuple[str, ...]:
    """Names of the groups, in the order of the file."""
    return tuple(ranges()["groups"])


def cases(count: int = COUNT, seed: int = SEED, quick: bool = False, only: tuple[str, ...] = ()) -> list[Case]:
    """The first `count` cases of the plan, groups in turn; `only` keeps those of some groups, indices unchanged."""
    turns = _turns(count)
    sizes = {name: turns.count(name) for name in groups()}
    made = {name: _of_group(name, size, seed, quick) for name, size in sizes.items()}
    plan = [replace(next(made[name]), index=index) for index, name in enumerate(turns)]
    return [case for case in plan if not only or case.group in only]


def _turns(count: int) -> list[str]:
    """The group of every case: each as often as its share, evenly spread; the first k are the same for any count."""
    shares = {name: float(table.get("share", 1.0)) for name, table in ranges()["groups"].items()}
    order = list(shares)
    moments = [
        ((k + 0.5) / share, order.index(name), name)
        for name, share in shares.items()
        for k in range(1 + int(np.ceil(count * share)))
    ]
    return [name for _, _, name in sorted(moments)[:count]]


def _of_group(name: str, size: int, seed: int, quick: bool) -> Iterator[Case]:
    """Cases of one group from a shifted Sobol sequence: each of them depends on its number alone."""
    from scipy.stats import qmc  # takes a second, which processes that only run cases need not wait

    table = ranges()["groups"][name]
    vary: dict[str, dict[str, Any]] = table.get("vary", {})
    texts: list[dict[str, Any]] = table.get("texts", [])
    numbers: dict[str, dict[str, Any]] = table.get("numbers", {})
    bases = tuple(table.get("bases", ("baseline", "periodic", "reflex_only", "no_stimulation", "pendular")))
    dimensions = 2 + len(vary) + len(texts) + len(numbers)
    shift = np.random.default_rng([seed, *name.encode()]).random(dimensions)
    powers = int(np.ceil(np.log2(max(size, 2))))
    points = (qmc.Sobol(dimensions, scramble=False).random_base2(powers)[:size] + shift) % 1.0
    for row in points:
        numbers_left = iter(row.tolist())
        reading = _one_of(READINGS, next(numbers_left))
        base = ranges()["bases"][_one_of(bases, next(numbers_left))]
        common = {"run.duration": base["duration"], **COMMON}
        if quick and not table.get("fixed_grid", False):
            common |= QUICK
        changes = {str(key): str(value) for key, value in table.get("always", {}).items()}
        for key, about in vary.items():
            changes[key] = _value(key, about, next(numbers_left), base["scenario"], reading)
        chosen = {item["key"]: _one_of(item["choices"], next(numbers_left)) for item in texts}
        filling = {key: _value(key, about, next(numbers_left), "", "") for key, about in numbers.items()}
        for key, text in chosen.items():
            for mark, number in filling.items():
                text = text.replace("{" + mark + "}", number)
            changes[key] = text
        yield Case(0, name, base["scenario"], reading, changes, common)


def _one_of(choices: tuple[str, ...] | list[str], u: float) -> str:
    return str(choices[min(int(u * len(choices)), len(choices) - 1)])


def _value(key: str, about: Mapping[str, Any], u: float, scenario: str, reading: str) -> str:
    """A number of [0, 1) as text of the parameter."""
    if "choices" in about:
        return _one_of(about["choices"], u)
    if "times" in about:
        base = float(_base_values(scenario, reading)[key])
        low, high = (base * factor for factor in about["times"])
    else:
        low, high = float(about["low"]), float(about["high"])
    value = low * (high / low) ** u if about.get("scale") == "log" else low + (high - low) * u
    number = str(round(value)) if about.get("whole") else f"{value:.5g}"
    unit = about.get("unit", "")
    return f"{number} {unit}" if unit else number


@cache
def _base_values(scenario: str, reading: str) -> Mapping[str, Any]:
    return configuration(scenario, reading=reading).flat()
