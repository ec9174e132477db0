"""What friction, load and reflex ask of the rest of a configuration."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..errors import ConfigurationError

if TYPE_CHECKING:
    from .config import Configuration

LARGEST_SLACK = 0.4
"""Share of the tube by which its ends may be held nearer: the folds of a wall pack at a stretch of 0.2."""
PULLED_BY = {"pellet.load_weight": ("weight",), "pellet.load_stiffness": ("weight", "spring")}
"""Which loads read a parameter that a protocol may change."""
MOST_DISCHARGES = 100
"""Discharges of one receptor whose answers are under way at one time."""


def check_pellet_and_reflex(config: Configuration) -> None:
    """Refuse what no scheme carries out. Raises ConfigurationError naming key, value, cause and remedy."""
    scheme = ""
    if config.grid.n_theta > 1:
        scheme = f"grid.n_theta = {config.grid.n_theta}"
    if config.solver.integrator == "explicit":
        scheme = "solver.integrator = explicit"
    for key, value, neutral in _of_one_column(config):
        if scheme and value != neutral:
            raise ConfigurationError(
                f"{key} = {value}: it is there for one column, stepped implicitly, and {scheme}; use {neutral}, or "
                "grid.n_theta = 1 and solver.integrator = implicit"
            )
    wall = config.wall
    if wall.slack_length > LARGEST_SLACK * wall.length:
        raise ConfigurationError(
            f"wall.slack_length = {wall.slack_length:g} cm: the ends would be held at {wall.span:g} cm of a tube of "
            f"{wall.length:g} cm, which then folds; use at most {LARGEST_SLACK * wall.length:.3g} cm"
        )
    needed = 2.0 * config.pellet.radius + config.pellet.start_gap
    if wall.slack_length > 0.0 and config.pellet.enabled and needed >= wall.span:
        raise ConfigurationError(
            f"wall.slack_length = {wall.slack_length:g} cm: the ends are held at {wall.span:g} cm, and the pellet and "
            f"its gap take {needed:.6g} cm; use less slack, a longer tube or a smaller pellet"
        )
    for protocol in config.time_courses():
        kinds = PULLED_BY.get(protocol.parameter)
        if kinds is not None and config.pellet.load not in kinds:
            raise ConfigurationError(
                f"protocols: {protocol.parameter} changes and pellet.load = {config.pellet.load} does not read it; set "
                f"pellet.load = {kinds[0]}"
            )
    reflex = config.reflex
    if reflex.kind != "graded":
        return
    lasts = max(reflex.excitation_duration, reflex.inhibition_duration)
    late = max(reflex.delay, reflex.longitudinal_delay)
    if late + lasts > MOST_DISCHARGES * reflex.refractory:
        raise ConfigurationError(
            f"reflex.refractory = {reflex.refractory:g} s: the answer to a discharge is over after {late + lasts:g} s, "
            f"and reflex.kind = graded keeps at most {MOST_DISCHARGES} of a receptor under way; use at least "
            f"{(late + lasts) / MOST_DISCHARGES:.3g} s, or shorten delays and durations"
        )


def _of_one_column(config: Configuration) -> tuple[tuple[str, object, object], ...]:
    """Key, value, and the value that asks for nothing."""
    pellet = config.pellet
    return (
        ("pellet.viscous_friction_coefficient", pellet.viscous_friction_coefficient, 0.0),
        ("pellet.fast_friction_share", pellet.fast_friction_share, 1.0),
        ("pellet.load", pellet.load, "none"),
        ("reflex.kind", config.reflex.kind, "all_or_none"),
    )
