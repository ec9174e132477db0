"""What a source brings to be scored: parameter sets, claims, experiments, and what its report shows, all as data."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from ..many.sweep import Measure
from .claim import Claim, Explanation, Untestable
from .experiment import Experiment
from .measure import measure
from .metrics import METRICS, Metric
from .outcome import Condition, Outcome
from .searches import Search, Sensitivity
from .space import Space

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

    from .calibration import Calibration

COARSE: Mapping[str, Any] = {"grid.n_z": 400, "grid.n_z_wall": 200, "step.wall": "4 ms"}
"""Grids for a quick look: transits are off by some ten per cent, and verdicts with them."""

COLUMNS: Mapping[str, str] = MappingProxyType(
    {
        "transit_s": "transit (s)",
        "travel_cm": "travel (cm)",
        "mean_velocity_cm_s": "mean velocity (cm/s)",
        "irregularity": "irregularity",
        "stops": "stops",
        "reversals": "reversals",
        "libration_cm": "libration (cm)",
        "mixing": "mixing",
        "max_axial_force_mN": "largest axial force (mN)",
        "pulses": "pulses",
        "simulated_s": "simulated (s)",
    }
)
"""Metric to the heading of its column in the table of runs."""


@dataclass(frozen=True, slots=True)
class ParameterSet:
    """Numbers under which claims are scored: a reading, and changes to it that lie under every experiment."""

    name: str
    reading: str = "tight"
    changes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Variant:
    """One changed choice: its name, how tables call it, the changes, and whether thresholds are searched under it."""

    name: str
    title: str
    changes: Mapping[str, Any]
    searches: bool = False


@dataclass(frozen=True, slots=True)
class Picture:
    """One figure of a report: its number in the source ("" if it is ours), the runs it needs, and how it is drawn.

    searched: it shows searches, and is left out where there are none.
    """

    name: str
    number: str
    title: str
    caption: str
    runs: tuple[str, ...]
    draw: Callable[[Sequence[Outcome]], Canvas]
    searched: bool = False

    def drawable(self, outcomes: Sequence[Outcome]) -> bool:
        """Whether any outcome has something that it shows."""
        if self.searched:
            return any(outcome.thresholds for outcome in outcomes)
        return not self.runs or any(name in outcome.records for outcome in outcomes for name in self.runs)


@dataclass(frozen=True, slots=True)
class Table:
    """One table: name of its file, title, a line of explanation, columns, rows; folded: closed on the page at first."""

    name: str
    title: str
    note: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    folded: bool = False

    def csv(self) -> str:
        """The table as CSV text."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(self.columns)
        writer.writerows(self.rows)
        return text.getvalue()


@dataclass(frozen=True)
class Source:
    """One source: what it claims, under which numbers, the runs that decide, and the words and pictures of its report.

    sets: parameter sets, the default first; word: how tables call one. prefix: before the number of a claim. columns:
    of the table of runs, metric to heading. tables: further ones of the report. words: table to its title and the line
    above it. about: a paragraph at the top of the page, in which {version} is that of the package. coarse: changes for
    a quick look. space: what a search for a parameter set may move, if there is one; calibration: how its constants are
    calibrated, read when it is asked for. Kept runs hold what `measure` made of them, so each source has a folder of
    its own.
    """

    name: str
    title: str
    heading: str
    about: str
    claims: tuple[Claim, ...]
    runs: Mapping[str, Experiment]
    sets: tuple[ParameterSet, ...] = (ParameterSet("tight"),)
    searches: Mapping[str, Search] = field(default_factory=dict)
    sensitivities: Mapping[str, Sensitivity] = field(default_factory=dict)
    variants: Mapping[str, Variant] = field(default_factory=dict)
    untestable: tuple[Untestable, ...] = ()
    explanations: tuple[Explanation, ...] = ()
    pictures: tuple[Picture, ...] = ()
    tables: tuple[Callable[[Sequence[Outcome]], Table], ...] = ()
    words: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    columns: Mapping[str, str] = field(default_factory=lambda: COLUMNS)
    measure: Measure = measure
    metrics: Mapping[str, Metric] = field(default_factory=lambda: METRICS)
    coarse: Mapping[str, Any] = field(default_factory=lambda: COARSE)
    word: str = "reading"
    prefix: str = ""
    space: Space | None = None
    calibration: Callable[[], Calibration] | None = None

    def label(self, claim: int) -> str:
        """Number of a claim as the report prints it."""
        return f"{self.prefix}{claim}"

    def runs_of(self, claims: Sequence[int]) -> tuple[str, ...]:
        """The named runs that claims need, by their numbers."""
        needed = {run for claim in self.claims if claim.number in claims for run in claim.runs()}
        return tuple(name for name in self.runs if name in needed)

    def conditions(
        self, sets: Sequence[str], variants: Sequence[str] = (), coarse: bool = False
    ) -> tuple[tuple[Condition, bool], ...]:
        """Conditions of the named parameter sets, then of each variant over them; with each, whether it is searched."""
        grids = self.coarse if coarse else {}
        chosen = [one for name in sets for one in self.sets if one.name == name]
        found = [(Condition(one.reading, {**one.changes, **grids}, one.name), True) for one in chosen]
        for variant in (self.variants[name] for name in variants):
            for one in chosen:
                changes = {**one.changes, **grids, **variant.changes}
                found.append((Condition(one.reading, changes, f"{one.name}, {variant.title}"), variant.searches))
        return tuple(found)
