"""Every output of a run, once: name, dimensions, unit, long name. Files, tables and figures take them from here."""

from __future__ import annotations

from typing import NamedTuple


class Output(NamedTuple):
    """One variable of a result: its dimensions, its unit as written in files, and what it is."""

    name: str
    dimensions: tuple[str, ...]
    unit: str
    long_name: str


WALL = ("time", "z", "theta")
CELLS = ("time", "z_cell", "theta_cell")
STEP = ("time_step",)
PROBE = ("time_step", "probe")

COORDINATES = (
    Output("time", ("time",), "s", "time of a stored field"),
    Output("time_step", ("time_step",), "s", "time of a wall step"),
    Output("z", ("z",), "cm", "wall node, distance from the oral end in the undeformed tube"),
    Output("z_cell", ("z_cell",), "cm", "conduction cell, distance from the oral end in the undeformed tube"),
    Output("theta", ("theta",), "rad", "angle around the undeformed tube"),
    Output("theta_cell", ("theta_cell",), "rad", "angle of the conduction cells around the undeformed tube"),
    Output("probe", ("probe",), "cm", "probe, distance from the oral end in the undeformed tube"),
)

FIELDS = (
    Output("radius", WALL, "cm", "radius of the wall"),
    Output("angle", WALL, "rad", "angle of the wall point"),
    Output("axial_position", WALL, "cm", "axial position of the wall point"),
    Output("stretch_longitudinal", WALL, "1", "longitudinal stretch"),
    Output("stretch_circumferential", WALL, "1", "circumferential stretch"),
    Output("tension_longitudinal", WALL, "mN/cm", "total longitudinal tension"),
    Output("tension_circumferential", WALL, "mN/cm", "total circumferential tension"),
    Output("active_tension_longitudinal", WALL, "mN/cm", "active tension of the longitudinal muscle"),
    Output("active_tension_circumferential", WALL, "mN/cm", "active tension of the circular muscle"),
    Output("passive_tension_longitudinal", WALL, "mN/cm", "passive longitudinal tension"),
    Output("passive_tension_circumferential", WALL, "mN/cm", "passive circumferential tension"),
    Output("contact_pressure", WALL, "kPa", "contact pressure between wall and pellet"),
    Output("potential_longitudinal", CELLS, "mV", "membrane potential of the longitudinal muscle"),
    Output("potential_circular", CELLS, "mV", "membrane potential of the circular muscle"),
    Output("calcium_longitudinal", CELLS, "1", "intracellular calcium of the longitudinal muscle"),
    Output("calcium_circular", CELLS, "1", "intracellular calcium of the circular muscle"),
)

ACTIVATION = (
    Output("activation_longitudinal", ("z_cell", "theta_cell"), "s", "first activation of the longitudinal muscle"),
    Output("activation_circular", ("z_cell", "theta_cell"), "s", "first activation of the circular muscle"),
)

SCALARS = (
    Output("pellet_position", STEP, "cm", "position of the pellet's centre"),
    Output("pellet_velocity", STEP, "cm/s", "velocity of the pellet"),
    Output("axial_force", STEP, "mN", "axial force of the wall on the pellet"),
    Output("normal_force", STEP, "mN", "sum of the contact forces on the pellet"),
    Output("viscous_force", STEP, "mN", "viscous friction on the pellet"),
    Output("dry_force", STEP, "mN", "dry friction on the pellet"),
    Output("oral_reaction", STEP, "mN", "axial force of the tube at the oral end"),
    Output("anal_reaction", STEP, "mN", "axial force of the tube at the anal end"),
    Output("lumen_pressure", STEP, "kPa", "lumen pressure"),
    Output("max_contact_pressure", STEP, "kPa", "largest contact pressure on the pellet"),
    Output("contact_start", STEP, "cm", "oral edge of the contact"),
    Output("contact_end", STEP, "cm", "anal edge of the contact"),
    Output("min_diameter", STEP, "cm", "smallest inner diameter of the tube"),
    Output("slack_share", STEP, "1", "share of the wall that carries no tension in one direction"),
    Output("smallest_gap", STEP, "cm", "smallest gap between wall and pellet; negative where they overlap"),
    Output("newton_iterations", STEP, "1", "Newton iterations of the step"),
    Output("work_active", STEP, "mN*cm", "work done by the muscle since t = 0"),
    Output("work_gas", STEP, "mN*cm", "work done by the lumen's content since t = 0"),
    Output("energy_wall", STEP, "mN*cm", "work stored in the passive wall since t = 0"),
    Output("loss_wall", STEP, "mN*cm", "work lost in the viscous wall since t = 0"),
    Output("loss_pellet", STEP, "mN*cm", "work lost in friction of the pellet since t = 0"),
    Output("power_residual", STEP, "mN*cm", "what the balance of work leaves over since t = 0"),
    Output("momentum_residual", STEP, "mN", "what the balance of axial momentum leaves over"),
)

PROBES = tuple(
    Output(f"{name}_{layer}_probe", PROBE, unit, f"{text} of the {layer} muscle at the probes")
    for layer in ("longitudinal", "circular")
    for name, unit, text in (
        ("potential", "mV", "membrane potential"),
        ("h", "1", "inactivation gate h"),
        ("n", "1", "potassium gate n"),
        ("x", "1", "slow calcium gate x"),
        ("calcium", "1", "intracellular calcium"),
    )
)

EVENTS = (
    Output("event_time", ("event",), "s", "time of an event"),
    Output("event_place", ("event",), "cm", "place of an event, distance from the oral end"),
    Output("event_kind", ("event",), "", "kind of an event"),
    Output("event_words", ("event",), "", "what happened"),
)

CERTAIN = "certain"
"""Where a summary holds what `--certain` found; no number of the run itself, so no fingerprint sees it."""

OUTPUTS = {output.name: output for output in (*COORDINATES, *FIELDS, *ACTIVATION, *SCALARS, *PROBES, *EVENTS)}
