"""The model by the method of lines: sheets, wall, pellet, trigger and reflex together.

An implementation of docs/equations.md that shares no code with the package; see docs/verification/independent.md.
As a program, from the folder tests: python -m reference.method_of_lines --help.
"""

from __future__ import annotations

import argparse
import time
from dataclasses import dataclass, field

import numpy as np

from reference import mol_sheets as sheets
from reference import mol_stepper as stepper
from reference.constants import Constants, Layer, load


@dataclass(frozen=True)
class Resolution:
    """Grids and steps: wall intervals, conduction cells, wall step [s], largest conduction step [ms], stages."""

    wall: int = 400
    cells: int = 2000
    step: float = 2.0e-3
    conduction_step: float = 0.1
    stages: int = 2


@dataclass
class Track:
    """What a run leaves behind."""

    time: np.ndarray
    position: np.ndarray
    force: np.ndarray
    pressure: np.ndarray
    radius: np.ndarray  # of the last state, nodes
    axial: np.ndarray
    arrival: np.ndarray  # (2, cells): first rise through -40 mV [s]
    expelled: float | None
    seconds: float
    steps: int
    discharges: list[float] = field(default_factory=list)


class Sheet:
    """One layer: its cells (5, n) and the pulses that it gets."""

    def __init__(self, c: Constants, layer: Layer, n: int) -> None:
        self.h = c.length / n
        self.centres = (np.arange(n) + 0.5) * self.h
        self.layer = layer
        self.kinetics = sheets.kinetics_of(c, layer)
        self.cells = np.tile(sheets.rest(c, layer)[:, None], (1, n))
        self.pulses = np.zeros((0, 6))
        self.onset = np.full(n, -1e12)
        self.trigger = np.array([c.trigger_intensity, 1e3 * c.trigger_duration])
        self.arrival = np.full(n, np.nan)

    def pulse(self, first: float, last: float, begin: float, duration: float, current: float, shunt: float) -> None:
        """A pulse over the cells whose centres lie in [first, last] cm, from `begin` s for `duration` s."""
        inside = np.searchsorted(self.centres, [first, last])
        row = [inside[0], inside[1], 1e3 * begin, 1e3 * (begin + duration), current, shunt]
        self.pulses = np.vstack([self.pulses, row])

    def advance(self, begin: float, end: float, conductance: np.ndarray, largest: float) -> None:
        """From begin to end [s] with steps of at most `largest` ms."""
        steps = max(1, int(np.ceil(1e3 * (end - begin) / largest - 1e-9)))
        before = self.cells[0].copy()
        sheets.march(
            self.cells, 1e3 * begin, 1e3 * end, steps, conductance, self.h, self.pulses, self.onset, self.trigger,
            self.kinetics,
        )  # fmt: skip
        rise = np.isnan(self.arrival) & (before < -40.0) & (self.cells[0] >= -40.0)
        share = (-40.0 - before[rise]) / (self.cells[0][rise] - before[rise])
        self.arrival[rise] = begin + share * (end - begin)

    def pull(self) -> np.ndarray:
        """φ⁺ of every cell [mV], (19)."""
        return np.maximum(self.cells[0] - self.layer.threshold, 0.0)


class Averages:
    """Means of a piecewise constant field over intervals [a_i, b_i]."""

    def __init__(self, n: int, length: float, begin: np.ndarray, end: np.ndarray) -> None:
        self.edges = np.linspace(0.0, length, n + 1)
        self.begin, self.end = begin, end

    def __call__(self, values: np.ndarray) -> np.ndarray:
        whole = np.concatenate([[0.0], np.cumsum(values * np.diff(self.edges))])
        at = np.interp(self.end, self.edges, whole) - np.interp(self.begin, self.edges, whole)
        return at / (self.end - self.begin)


def parabola(layer: Layer, stretch: np.ndarray) -> np.ndarray:
    """Active tension per millivolt (5)."""
    return np.maximum(0.0, (layer.c7 * stretch + layer.c8) * stretch + layer.c9)


def run(c: Constants, r: Resolution, duration: float = 10.0) -> Track:
    """Simulate from t = 0 until the pellet is expelled or `duration` [s] has passed."""
    clock = time.perf_counter()
    setting, wall, free = stepper.start(c, r.wall)
    nodes = np.linspace(0.0, c.length, r.wall + 1)
    faces = 0.5 * (nodes[1:] + nodes[:-1])
    to_faces = Averages(r.cells, c.length, nodes[:-1], nodes[1:])
    ends = np.concatenate([[0.0], faces, [c.length]])
    to_nodes = Averages(r.cells, c.length, ends[:-1], ends[1:])
    long, circ = Sheet(c, c.longitudinal, r.cells), Sheet(c, c.circular, r.cells)
    cell_faces = np.linspace(0.0, c.length, r.cells + 1)
    long.pulse(0.0, c.pacemaker_width, 0.0, c.pacemaker_duration, c.pacemaker_intensity, 0.0)
    if c.trigger_rule == "pacemaker":
        circ.pulse(0.0, c.pacemaker_width, c.trigger_delay, c.trigger_duration, c.trigger_intensity, 0.0)
    elif c.trigger_rule != "active":
        raise ValueError(f"trigger rule {c.trigger_rule!r}: only 'active' and 'pacemaker' are written here")

    def stretch(state: stepper.WallState) -> np.ndarray:
        return np.hypot(*np.diff(state.place, axis=0).T) / setting.h

    nodes_in_step = stepper.TABLEAUX[r.stages].sum(axis=1)
    past = now = stretch(wall)
    active_now = active_past = np.zeros(r.cells)
    fired = np.full(r.cells, -np.inf)
    discharged = -np.inf
    history = [(0.0, wall.centre, wall.force, wall.pressure)]
    discharges: list[float] = []
    latest = (to_faces(long.pull()), to_nodes(circ.pull()))
    expelled = None
    count = round(duration / r.step)
    for index in range(count):
        t, later = index * r.step, (index + 1) * r.step
        middle = 1.5 * now - 0.5 * past
        samples = []
        marks = [t + share * r.step for share in nodes_in_step[:-1]] + [later]
        begin = t
        for mark in marks:
            for sheet in (long, circ):
                conductance = sheet.layer.diffusivity / np.interp(cell_faces, faces, middle)
                sheet.advance(begin, mark, conductance, r.conduction_step)
            samples.append((to_faces(long.pull()), to_nodes(circ.pull())))
            begin = mark
        shares = np.array([0.0, *nodes_in_step])
        # A step that is cut asks between the stages: linear there.
        table_l = np.vstack([latest[0], *(s[0] for s in samples)])
        table_c = np.vstack([latest[1], *(s[1] for s in samples)])
        latest = samples[-1]

        def drives(f, shares=shares, table_l=table_l, table_c=table_c):
            j = min(int(np.searchsorted(shares, f - 1e-12)), len(shares) - 1)
            if j == 0 or abs(shares[j] - f) < 1e-12:
                return table_l[j], table_c[j]
            w = (f - shares[j - 1]) / (shares[j] - shares[j - 1])
            return (1 - w) * table_l[j - 1] + w * table_l[j], (1 - w) * table_c[j - 1] + w * table_c[j]

        before = wall
        try:
            wall = stepper.advance(setting, wall, r.step, drives, r.stages)
        except stepper.Diverged as error:
            raise stepper.Diverged(f"at {t:.4f} s with the pellet at {wall.centre:.3f} cm: {error}") from None
        past, now = now, stretch(wall)

        if c.trigger_rule == "active":
            active = long.pull() * parabola(c.longitudinal, np.interp(long.centres, faces, now))
            passed = (active_now > active_past) & (active < active_now) & (active_now > c.trigger_level)
            passed &= later - fired >= c.trigger_refractory
            fired[passed] = later
            circ.onset[passed] = 1e3 * later
            active_past, active_now = active_now, active
        wide = (wall.contact > 0.0) & (wall.place[:, 0] > c.reflex_threshold * free)
        if c.reflex and wide.any() and later - discharged >= c.reflex_refractory:
            discharged = later
            discharges.append(later)
            oral, anal = nodes[wide][[0, -1]]
            begin = later + c.reflex_delay
            circ.pulse(oral - c.oral_length, oral, begin, c.excitation_duration, c.excitation, 0.0)
            circ.pulse(anal, anal + c.anal_length, begin, c.inhibition_duration, 0.0, c.inhibition)
        history.append((later, wall.centre, wall.force, wall.pressure))
        if wall.centre + c.pellet_radius >= c.length:
            share = (c.length - c.pellet_radius - before.centre) / (wall.centre - before.centre)
            expelled = t + share * r.step
            break
    columns = np.array(history).T
    return Track(
        *columns, wall.place[:, 0], wall.place[:, 1], np.vstack([long.arrival, circ.arrival]), expelled,
        time.perf_counter() - clock, len(history) - 1, discharges,
    )  # fmt: skip


def main() -> None:
    """Command line: one run, its transit and, on request, its track in a file."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--reading", default="tight")
    parser.add_argument("--consistent", action="store_true", help="tension per undeformed length (35)")
    parser.add_argument("--no-reflex", action="store_true")
    parser.add_argument("--wall", type=int, default=400, help="intervals of the wall")
    parser.add_argument("--cells", type=int, default=2000)
    parser.add_argument("--step", type=float, default=2.0, help="wall step, ms")
    parser.add_argument("--conduction-step", type=float, default=0.1, help="ms")
    parser.add_argument("--stages", type=int, default=2, choices=(1, 2, 3))
    parser.add_argument("--duration", type=float, default=10.0, help="s")
    parser.add_argument("--out", help="file for the track (.npz)")
    a = parser.parse_args()
    c = load(a.reading, published=not a.consistent, reflex=not a.no_reflex)
    track = run(c, Resolution(a.wall, a.cells, 1e-3 * a.step, a.conduction_step, a.stages), a.duration)
    print(f"transit {track.expelled} s, {track.steps} steps, {track.seconds:.1f} s on the clock")
    if a.out:
        np.savez(a.out, **{key: value for key, value in vars(track).items() if value is not None})


if __name__ == "__main__":
    main()
