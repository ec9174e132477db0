"""The configurations of the bench: drawn from the ranges of plan.toml, the same for every machine and order."""

from __future__ import annotations

import tomllib
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

PLAN = Path(__file__).with_name("plan.toml")
QUICK = {"grid.n_z": 400, "grid.n_z_wall": 320, "run.duration": "1.5 s"}
"""Changes of the quick plan, where its group does not say otherwise."""
QUICK_SHARE = 7
"""One configuration in so many belongs to the quick plan."""


@dataclass(frozen=True)
class Case:
    """One configuration: its number, group, scenario, reading, and changed parameters by name."""

    number: int
    group: str
    scenario: str
    reading: str
    changes: Mapping[str, Any]

    def command(self) -> str:
        """The line that runs it."""
        words = " ".join(f'--set "{key}={text(value)}"' for key, value in self.changes.items())
        return f"peristalsis run {self.scenario} --reading {self.reading} {words}"


def text(value: Any) -> str:
    """A value as the command line takes it."""
    return str(value).lower() if isinstance(value, bool) else str(value)


def read(quick: bool = False, file: Path = PLAN) -> list[Case]:
    """Every case, groups interleaved so that any beginning of the list covers all of them."""
    plan = tomllib.loads(file.read_text("utf-8"))
    groups = [_drawn(group, plan) for group in plan["group"]]
    ranked = [(k / len(cases), place, case) for place, cases in enumerate(groups) for k, case in enumerate(cases)]
    ordered = [case for _, _, case in sorted(ranked, key=lambda one: one[:2])]
    numbered = [Case(n, c.group, c.scenario, c.reading, c.changes) for n, c in enumerate(ordered)]
    if not quick:
        return numbered
    few = [case for case in numbered if case.number % QUICK_SHARE == 0]
    return [Case(c.number, c.group, c.scenario, c.reading, {**c.changes, **_quick(c)}) for c in few]


def _quick(case: Case) -> dict[str, Any]:
    return {key: value for key, value in QUICK.items() if case.group not in ("surface", "numbers")}


def _drawn(group: Mapping[str, Any], plan: Mapping[str, Any]) -> list[Case]:
    ranges, choices, runs = group.get("ranges", {}), group.get("choices", {}), int(group["runs"])
    seed = plan["seed"] + zlib.crc32(group["name"].encode())
    rng = np.random.default_rng(seed)
    shares = qmc.LatinHypercube(max(len(ranges), 1), rng=rng).random(runs)
    cases = []
    for k in range(runs):
        changes: dict[str, Any] = {"run.duration": plan["duration"], **group.get("fixed", {})}
        for share, (key, limits) in zip(shares[k], ranges.items(), strict=False):
            changes[key] = _value(float(share), *limits)
        for key, options in choices.items():
            changes[key] = options[int(rng.integers(len(options)))]
        scenarios, readings = group["scenarios"], plan["readings"]
        cases.append(Case(0, group["name"], scenarios[k % len(scenarios)], readings[k % len(readings)], changes))
    return cases


def _value(share: float, low: float, high: float, unit: str, scale: str = "linear") -> Any:
    value = low * (high / low) ** share if scale == "log" else low + share * (high - low)
    if unit == "integer":
        return round(value)
    value = float(f"{value:.4g}")
    return f"{value!r} {unit}" if unit else value
