"""What agents and interventions do: docs/evidence/drugs.md and its pictures, from some two hundred runs.

Dose and response of eleven agents (five of them under both readings of the calcium channels), two agents together, the
advice of the paper (lubricant with bulk former, no calcium agents in constipation) under each of its readings. Finished
runs are kept in out/evidence_drugs, so a second call only writes. A research model, not medical advice.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping

from common import FOLDER, ROOT, save_text, table

from peristalsis import scenarios
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.config import Configuration
from peristalsis.inputs.drugs import amount, changes_by, from_line, library, mixed
from peristalsis.inputs.parameters import READINGS
from peristalsis.many.dose_response import DoseResponse, dose_response
from peristalsis.many.passage import passage
from peristalsis.many.rows import Row, Step
from peristalsis.many.sweep import sweep

OUT = ROOT / "out" / "evidence_drugs"
AGENTS: Mapping[str, tuple[str, str]] = {
    "nifedipine": ("0.08 nM", "8 uM"),
    "nitrendipine": ("0.03 nM", "3 uM"),
    "verapamil": ("1.4 nM", "140 uM"),
    "diltiazem": ("1 nM", "100 uM"),
    "otilonium": ("50 nM", "200 uM"),
    "pinaverium": ("4 nM", "400 uM"),
    "Bay K 8644": ("0.2 nM", "2 uM"),
    "nickel": ("2.5 uM", "250 mM"),
    "mibefradil": ("5 nM", "500 uM"),
    "4-aminopyridine": ("1.4 uM", "140 mM"),
    "iberiotoxin": ("0.01 nM", "10 nM"),
}
BOTH = ("nifedipine", "nitrendipine", "verapamil", "diltiazem", "otilonium")
"""Agents that are run under the other reading of the calcium channels as well."""
CHANNELS: Mapping[str, str | None] = {"L-type is slow (as shipped)": None, "L-type is fast": "l_type_is_fast"}
STATES: Mapping[str, float] = {"healthy": 1.0, "weak muscle": 0.6}
"""Factor on the active force of both layers: the second stands for slow transit."""
TREATMENTS: Mapping[str, tuple[tuple[str, ...], str | None]] = {
    "none": ((), None),
    "lubricant": (("lubricant 0.5",), None),
    "mineral oil": (("mineral oil 0.5",), None),
    "bulk former": (("bulk former 1.1",), None),
    "lubricant and bulk former": (("lubricant 0.5", "bulk former 1.1"), None),
    "mineral oil and bulk former": (("mineral oil 0.5", "bulk former 1.1"), None),
    "nifedipine 8.1 nM, L-type is slow": (("nifedipine 8.1 nM",), None),
    "nifedipine 8.1 nM, L-type is fast": (("nifedipine 8.1 nM",), "l_type_is_fast"),
    "Bay K 8644 17 nM, L-type is slow": (("Bay K 8644 17 nM",), None),
    "Bay K 8644 17 nM, L-type is fast": (("Bay K 8644 17 nM",), "l_type_is_fast"),
}


def say(step: Step) -> None:
    """Progress on stderr."""
    print(f"{step.done}/{step.count} {step.row.point.name}: {step.row.status}", file=sys.stderr, flush=True)


def responses() -> dict[tuple[str, str], DoseResponse]:
    """Dose and response by agent and reading of the channels."""
    return {
        (agent, channels): dose_response(agent, low, high, library_file=file, out=OUT, progress=say)
        for channels, file in CHANNELS.items()
        for agent, (low, high) in AGENTS.items()
        if file is None or agent in BOTH
    }


def band(limits: tuple[float, float] | None) -> str:
    """Both ends of a band of concentrations."""
    return "–" if limits is None else f"{amount(limits[0])} to {amount(limits[1])}"


def response_rows(found: Mapping[tuple[str, str], DoseResponse]) -> list[list[object]]:
    """A row for each agent and reading: EC50 of the speed with its bands, slope, what is left, half speed."""
    rows: list[list[object]] = []
    for (agent, channels), one in found.items():
        curve, half = one.curves["speed"], one.half_concentration("speed")
        left = "–" if curve.bottom is None else f"{100.0 * curve.bottom:.3g} %"
        slope = "–" if curve.slope is None or curve.slope_band is None else (
            f"{curve.slope:.2f} ({curve.slope_band[0]:.2f} to {curve.slope_band[1]:.2f})"
        )  # fmt: skip
        ended = sum(row.summary.get("transit_s") is None for row in one.rows)
        rows.append(
            [
                agent,
                channels,
                "–" if curve.half is None else amount(curve.half),
                band(curve.half_band),
                band(one.whole_band("speed")) if one.uncertainty else "no range known",
                slope,
                left,
                "not reached" if half is None else amount(half),
                f"{ended} of {len(one.rows)}",
                "–" if curve.error is None else f"{100.0 * curve.error:.2g} %",
                curve.reason or "–",
            ]
        )
    return rows


def together() -> list[list[object]]:
    """Two agents alone and together, at one target and at two."""
    pairs = (("nifedipine 8.1 nM", "verapamil 140 nM"), ("nifedipine 8.1 nM", "iberiotoxin 0.3 nM"))
    rows: list[list[object]] = []
    base = scenarios.configuration("baseline")
    for one, two in pairs:
        for file in CHANNELS.values():
            runs = {
                "none": base,
                **{
                    name: base.with_changes(changes_by(lines, base, file))
                    for name, lines in (("first", [one]), ("second", [two]), ("both", [one, two]))
                },
            }
            done = sweep(runs, OUT / "runs", passage, progress=say)
            speed = {name: row.summary["mean_velocity_cm_s"] for name, row in done.items()}
            shares = {name: value / speed["none"] for name, value in speed.items()}
            doses = from_line(one, library(file)) + from_line(two, library(file))
            rows.append(
                [
                    f"{one}, {two}",
                    "fast" if file else "slow",
                    *(f"{100.0 * shares[name]:.1f} %" for name in ("first", "second", "both")),
                    f"{100.0 * shares['first'] * shares['second']:.1f} %",
                    "yes" if mixed(doses) else "no",
                ]
            )
    return rows


def advice() -> tuple[list[list[object]], dict[tuple[str, str, str], Row]]:
    """Transit under each treatment, state and reading of the paper."""
    runs: dict[str, Configuration] = {}
    names: dict[str, tuple[str, str, str]] = {}
    refused: dict[tuple[str, str, str], str] = {}
    for reading in READINGS:
        for state, share in STATES.items():
            base = scenarios.configuration("baseline", reading=reading)
            if share != 1.0:
                base = base.with_changes(
                    {f"{layer}.active": share * getattr(base, layer).active for layer in ("longitudinal", "circular")}
                )
            for treatment, (lines, file) in TREATMENTS.items():
                where, name = (reading, state, treatment), f"{reading}, {state}, {treatment}"
                try:
                    runs[name] = base.with_changes(changes_by(lines, base, file))
                    names[name] = where
                except ConfigurationError as error:
                    refused[where] = str(error)
    done = sweep(runs, OUT / "runs", passage, progress=say)
    found = {names[name]: row for name, row in done.items()}
    rows: list[list[object]] = []
    for treatment in TREATMENTS:
        cells: list[object] = [treatment]
        for reading in READINGS:
            for state in STATES:
                where = (reading, state, treatment)
                cells.append(_outcome(found[where]) if where in found else "refused")
        rows.append(cells)
    return rows, found


def _outcome(row: Row) -> str:
    transit = row.summary.get("transit_s")
    if transit is not None:
        return f"{transit:.2f} s"
    travel = row.summary.get("travel_cm")
    return row.status.replace("_", " ") + ("" if travel is None else f" ({travel:.1f} cm)")


def draw(found: Mapping[tuple[str, str], DoseResponse]) -> None:
    """Speed against concentration over the IC50, every agent, one panel a reading of the channels."""
    import numpy as np
    from matplotlib.figure import Figure

    from peristalsis.plots import style

    with style.applied():
        figure = Figure(figsize=(11.0, 4.2), dpi=130, layout="constrained")
        for axes, channels in zip(figure.subplots(1, 2, sharey=True), CHANNELS, strict=True):
            for number, ((agent, own), one) in enumerate(found.items()):
                if own == channels:
                    first = one.doses[0]
                    x = np.array(one.concentrations) / first.ic50
                    marker, line = "osD^v<>*PXd"[number % 11], ("-", "--", ":")[number % 3]
                    axes.plot(
                        x, one.share("speed"), marker, linestyle=line, markersize=4, label=f"{agent}, {first.target}"
                    )
            axes.set_xscale("log")
            axes.set(xlabel="concentration / IC50 of the first target", title=channels)
            axes.grid(alpha=0.25)
            axes.legend(loc="lower left", fontsize=7)
        figure.axes[0].set_ylabel("mean speed / that of the control")
        figure.savefig(FOLDER / "drugs.png")
    found["nifedipine", "L-type is fast"].figure().savefig(FOLDER / "nifedipine.png")


def main() -> None:
    """Run everything and write the page."""
    found = responses()
    draw(found)
    head = ["agent", "channels", "EC50 of the speed", "95 % band", "with the range of the IC50", "slope", "speed left"]
    head += ["half of the control's speed", "not expelled in 10 s", "residual", "remark"]
    rows, _ = advice()
    columns = ["treatment", *(f"{reading}, {state}" for reading in READINGS for state in STATES)]
    save_text(
        "drugs.md",
        "# Agents and interventions\n\n"
        "Written by `python evidence/drugs.py`; a research model, not medical advice. Baseline, reading `tight` "
        "unless\nsaid otherwise; numbers of agents and their sources: `peristalsis list drugs`. What it means is in\n"
        "[drugs.md](../drugs.md).\n\n## Dose and response\n\n"
        + table(head, response_rows(found))
        + "\nThe EC50 is the concentration of half of an agent's own largest effect, which may be small: the next to "
        "last\ncolumns say whether half of the control's speed is reached at all. The speed is mean travel over the "
        "time until\nthe pellet is out, or over 10 s.\n\n![speed against concentration](drugs.png)\n\n"
        "![nifedipine where the L-type channel is the fast one](nifedipine.png)\n\n## Two agents together\n\n"
        "Speed as a share of that without either; the last but one column is the product of both alone.\n\n"
        + table(
            ["agents", "L-type channel", "first alone", "second alone", "both", "product", "preparations mixed"],
            together(),
        )
        + "\n## The paper's advice\n\n"
        "Transit, or how far the pellet came in 10 s. `weak muscle`: the active force of both layers times 0.6.\n\n"
        + table(columns, rows),
    )


if __name__ == "__main__":
    main()
