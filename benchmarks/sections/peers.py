"""Work and precision beside others: the front on a cable with Myokit, and the whole run with an explicit wall."""

from __future__ import annotations

from functools import partial
from typing import Any

from peristalsis.inputs.config import Configuration
from peristalsis.many.cable import cable_wave_speed

from ..clock import Spent, Timing, once
from ..runs import track_error, tracked
from ..section import Bench, Figure, Findings, Line, Plot, Section, Table

MASS = {"wall.surface_density": "26.14 g/cm^2"}
EXPLICIT = {**MASS, "solver.integrator": "explicit", "step.conduction": "0.125 ms", "grid.n_z": 2000}
IMPLICIT = {**MASS, "wall.inertia": True, "grid.n_z": 2000, "step.wall": "2 ms", "step.conduction": "0.25 ms"}
LIMIT = {**IMPLICIT, "grid.n_z_wall": 1600, "step.wall": "1 ms"}

CORRECTED, PLAIN, MYOKIT = "peristalsis, fronts corrected", "peristalsis, plain operator", "Myokit, Rush–Larsen"
CABLES = ((250, 2.0), (350, 1.0), (500, 1.0), (700, 1.0), (1000, 0.5), (2000, 0.25))
"""Cells of 10 cm, and steps of conduction [ms], each about as good as the other."""
THEIR_CABLES = ((500, 0.25), (700, 0.25), (1000, 0.125), (1400, 0.125), (2000, 0.0625))
NEAR = 1.0
"""Error of the front's speed at which programs are compared [%]."""
BEGUN, LONG = 0.4, 2.8
"""Seconds of cable: what is the same for both is taken off, and the rest is the cost of a second."""


def run(bench: Bench) -> Findings:
    """Both comparisons; Myokit's where it is installed."""
    notes: list[str] = []
    cables, fastest = _cables(bench, notes)
    whole = _whole(bench)
    figures = [
        Figure(f"{name}: quickest within {NEAR:g} % of the front's speed", cpu, "s of cpu a simulated second", note=at)
        for name, (cpu, at) in fastest.items()
    ]
    if CORRECTED in fastest and MYOKIT in fastest:
        ratio = fastest[MYOKIT][0] / fastest[CORRECTED][0]
        figures.append(Figure("Myokit over peristalsis, at that error", ratio, "times"))
    front = Plot(
        "front",
        "The front on an undeformed cable of 10 cm",
        "processor time a simulated second (s)",
        "error of the front's speed (%)",
        tuple(_line(name, [(row[3], row[5]) for row in cables if row[0] == name]) for name in _names(cables)),
    )
    explicit = Plot(
        "explicit_wall",
        "The whole baseline with the printed mass of the wall: explicit and implicit",
        "solver, processor time (s)",
        "rms error of the pellet's track (mm)",
        tuple(_line(name, [(row[2], row[3]) for row in whole if row[0] == name]) for name in _names(whole)),
    )
    tables = (
        Table(
            "One layer, 10 cm, undeformed. The limit is that of 4000 cells with steps of 0.125 ms.",
            ("program", "cells", "step (ms)", "cpu a simulated second (s)", "speed (cm/s)", "error (%)"),
            tuple(cables),
        ),
        Table(
            "2000 cells in both, so what differs is the wall and its steps. The limit: 1600 elements, steps of 1 ms.",
            ("wall", "elements", "solver, cpu (s)", "rms of the track (mm)", "steps"),
            tuple(whole),
        ),
    )
    return Findings(tuple(figures), tables, tuple(notes), plots=(front, explicit))


def _names(rows: list[tuple[Any, ...]]) -> list[str]:
    return list(dict.fromkeys(str(row[0]) for row in rows))


def _line(name: str, points: list[tuple[float, float]]) -> Line:
    ordered = sorted(points)
    return Line(name, tuple(cpu for cpu, _ in ordered), tuple(error for _, error in ordered))


def _cables(bench: Bench, notes: list[str]) -> tuple[list[tuple[Any, ...]], dict[str, tuple[float, str]]]:
    """Rows of the table, and by program the least time within NEAR with the cells and step that took it."""
    from ..myokit_cable import missing

    limit = bench.piece("peers, limit of the front", lambda: _ours(4000, 0.125, "none", 1)["speed"])
    repeats = bench.repeats(1, 5)
    rows: list[tuple[Any, ...]] = []

    def add(name: str, cells: int, step: float, found: dict[str, Any]) -> None:
        error = 100.0 * abs(found["speed"] / limit - 1.0)
        rows.append((name, cells, step, found["cpu"], found["speed"], error))

    chosen = CABLES if bench.full else CABLES[2:4]
    for name, law in ((CORRECTED, "measured"), (PLAIN, "none")):
        for cells, step in chosen:
            piece = f"peers, {name}, {cells} cells"
            add(name, cells, step, bench.piece(piece, partial(_ours, cells, step, law, repeats)))
    absent = missing()
    if absent is not None:
        notes.append(f"Myokit was not measured: {absent}")
    else:
        for cells, step in THEIR_CABLES if bench.full else THEIR_CABLES[:1]:
            piece = f"peers, Myokit, {cells} cells"
            add(MYOKIT, cells, step, bench.piece(piece, partial(_theirs, cells, step, repeats)))
    near: dict[str, tuple[float, str]] = {}
    for name, cells, step, cpu, _, error in rows:
        if error <= NEAR and (name not in near or cpu < near[name][0]):
            near[name] = (cpu, f"{cells} cells, steps of {step:g} ms")
    return rows, near


def _ours(cells: int, step: float, correction: str, repeats: int) -> dict[str, Any]:
    configuration = Configuration().with_changes(
        {
            "grid.n_z": cells,
            "step.conduction": f"{step!r} ms",
            "step.wall": f"{max(2.0, 4.0 * step)!r} ms",
            "tissue.front_correction": correction,
        }
    )
    speed = cable_wave_speed(configuration, duration=LONG)
    short = [once(lambda: cable_wave_speed(configuration, duration=BEGUN)).cpu for _ in range(repeats)]
    long = [once(lambda: cable_wave_speed(configuration, duration=LONG)).cpu for _ in range(repeats)]
    return {"speed": speed, "cpu": _a_second(short, long)}


def _theirs(cells: int, step: float, repeats: int) -> dict[str, Any]:
    import myokit

    from ..myokit_cable import Cable, their_speed

    cable = Cable(cells, step, exact=True)
    simulation = cable.theirs()

    def stretch(seconds: float) -> None:
        simulation.reset()
        simulation.run(1e3 * seconds, log=myokit.LOG_NONE)

    short = [once(lambda: stretch(BEGUN)).cpu for _ in range(repeats)]
    long = [once(lambda: stretch(LONG)).cpu for _ in range(repeats)]
    return {"speed": their_speed(cable, simulation), "cpu": _a_second(short, long)}


def _a_second(short: list[float], long: list[float]) -> float:
    less, more = (Timing.of([Spent(one, one) for one in spent]).cpu for spent in (short, long))
    return (more - less) / (LONG - BEGUN)


def _whole(bench: Bench) -> list[tuple[Any, ...]]:
    limit = bench.piece("peers, limit with mass", lambda: tracked(LIMIT))
    rows = []
    for name, changes, shells in (
        ("explicit", EXPLICIT, (100, 200, 400) if bench.full else (100,)),
        ("implicit", IMPLICIT, (100, 200, 400, 800) if bench.full else (100,)),
    ):
        for elements in shells:
            one = {**changes, "grid.n_z_wall": elements}
            found = bench.piece(f"peers, {name} wall, {elements} elements", partial(tracked, one))
            rows.append((name, elements, found["cpu"], 10.0 * track_error(found, limit), found["steps"]))
    return rows


SECTION = Section(
    name="peers",
    title="Beside others",
    about=(
        "Myokit's one-dimensional simulation of the same cell (an independent simulator that compiles its models to "
        "C), and the explicit wall that the paper describes, with errors against processor time in one run. The wall "
        "has its printed mass of 26.14 g/cm² here, with which an explicit step costs a thousandth of what it costs "
        "with the mass that is read."
    ),
    run=run,
    place=55,
)
