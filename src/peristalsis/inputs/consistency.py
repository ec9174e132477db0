"""What the parameters of a configuration must be together: sizes that fit, places on the tube, rules that agree.

Fields check themselves in `config`; nothing here is about one field alone.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from peristalsis import units
from peristalsis.errors import ConfigurationError, shown, suggestion
from peristalsis.inputs.choices import declared
from peristalsis.inputs.drugs import check as check_drugs
from peristalsis.inputs.parameters import PARAMETERS
from peristalsis.inputs.parts import SHIPPED, Part, parts
from peristalsis.inputs.pellet_rules import check_pellet_and_reflex
from peristalsis.inputs.recording import Recording, planned
from peristalsis.inputs.regions import check as check_regions

if TYPE_CHECKING:
    from peristalsis.inputs.config import Configuration, Wall

PARAMETERS_OF_PLANT = ("fast_calcium", "slow_calcium", "calcium_potassium", "potassium", "leak")
"""Parameters of a layer that are conductances of Plant's cell."""
FEWEST_COLUMNS = 4
LARGEST_GRID = 2_000_000  # nodes of both grids together
MOST_STEPS = 100_000_000
MOST_MICRO_STEPS = 100_000_000_000
LARGEST_OUTPUT = 2_000_000_000  # bytes kept in memory and written
LARGEST_STRETCH = 2.2  # pellet radius over tube radius; the exponential of the paper's law is astronomical beyond


def check(config: Configuration) -> None:
    """What no field can know alone. Raises ConfigurationError naming key, value, cause and remedy."""
    _check_grid(config)
    _check_steps(config)
    if config.solver.integrator == "explicit":
        _check_explicit(config)
    if config.protocols:
        _check_protocols(config)
    if config.pellet.enabled:
        _check_pellet(config)
    _check_places(config)
    _check_control(config)
    _check_parts(config)
    check_pellet_and_reflex(config)
    check_regions(config.regions, config.wall.length, config.wall.radius, config.grid.conduction_columns)


def _check_parts(config: Configuration) -> None:
    """Whether what is asked is there with the chosen parts."""
    cells = config.cells()
    check_drugs(config.drugs, [cell.name for cell in cells.values()])
    shipped = SHIPPED["cell"]
    plants = PARAMETERS_OF_PLANT
    if config.network.enabled and config.solver.integrator == "explicit":
        _refuse("network.enabled", "true", "the explicit scheme has no network", "use solver.integrator = implicit")
    if not config.network.enabled:
        for region in config.regions:
            if region.layer == "network":
                raise ConfigurationError(
                    f"regions: {region.name}: layer = network, and network.enabled = false; set it true, or leave the "
                    "region out"
                )
    for layer, cell in cells.items():
        if cell.name != shipped and config.solver.integrator == "explicit":
            _refuse(
                f"{layer}.cell", cell.name, "the explicit scheme has the cell of the paper only",
                f"use {shipped}, or solver.integrator = implicit",
            )  # fmt: skip
        if layer != "network":
            _check_activation(config, layer, cell)
        channels = {one.name for one in cell.channels} if cell.name != shipped else set(plants)
        others = {one.name for kind in parts("cell").values() for one in kind.channels} | set(plants)
        for region in config.regions:
            for quantity, _ in region.factors:
                concerned = region.layer == layer or (region.layer == "both" and layer != "network")
                if concerned and quantity in others and quantity not in channels:
                    raise ConfigurationError(
                        f"regions: {region.name}: {quantity} is no channel of {cell.name}, the cell of the {layer} "
                        f"layer; {suggestion(quantity, sorted(channels))}, or give the region to one layer"
                    )
        if cell.name != shipped and layer != "network":
            for protocol in config.time_courses():
                section, _, name = protocol.parameter.partition(".")
                if section == layer and name in plants:
                    _refuse(
                        f"protocols, {protocol.parameter}", "changes",
                        f"{layer}.cell is {cell.name}, which has no such channel",
                        f"use {layer}.{cell.name}.{cell.channels[0].name if cell.channels else '...'}",
                    )  # fmt: skip


def _check_activation(config: Configuration, layer: str, cell: Part) -> None:
    """Whether the activation of a layer can be had with its cell and the scheme."""
    part, key = config.activation_of(layer), f"{layer}.activation"
    if part.name != SHIPPED["activation"] and config.solver.integrator == "explicit":
        _refuse(
            key, part.name, "the explicit scheme has the activation of the paper only",
            f"use {SHIPPED['activation']}, or solver.integrator = implicit",
        )  # fmt: skip
    if not part.reads_calcium:
        return
    state, unit = cell.calcium
    if not state:
        able = sorted(one.name for one in parts("cell").values() if one.calcium[0])
        _refuse(
            key, part.name, f"the cell {cell.name} of the layer has no calcium",
            f"use {SHIPPED['activation']}, or one of the cells that have: {', '.join(able)}",
        )  # fmt: skip
    if not unit:
        _refuse(
            key, part.name, f"the cell {cell.name} does not say in which unit its {state} is",
            f'write CALCIUM_STATE = ("{state}", "uM"), or what it is, into {shown(str(cell.file))}',
        )  # fmt: skip
    if unit == units.DIMENSIONLESS and "calcium_unit" not in {one.name for one in part.parameters}:
        _refuse(
            key, part.name, f"calcium of the cell {cell.name} has no unit, and {part.name} does not say what 1 is",
            "declare calcium_unit [uM] among its PARAMETERS, or use another cell",
        )  # fmt: skip


def _check_protocols(config: Configuration) -> None:
    """Every value of every protocol must be allowed for its parameter, with all else as configured."""
    seen: set[str] = set()
    for protocol in config.time_courses():
        if protocol.parameter in seen:
            raise ConfigurationError(f"protocols: {protocol.parameter} has two of them; keep one")
        seen.add(protocol.parameter)
        one = declared(protocol.parameter)
        unit = one.unit if one is not None else PARAMETERS[protocol.parameter].unit
        for value in dict.fromkeys(protocol.extremes()):
            try:
                config.overlaid({"protocols": [], "stimuli": [], protocol.parameter: units.written(value, unit)})
            except ConfigurationError as error:
                raise ConfigurationError(f"protocols: {error}") from None


def _check_grid(config: Configuration) -> None:
    grid = config.grid
    columns = grid.conduction_columns
    if 1 < grid.n_theta < FEWEST_COLUMNS:
        fix = f"use 1 (axisymmetric) or at least {FEWEST_COLUMNS}"
        _refuse("grid.n_theta", str(grid.n_theta), "too few columns for a ring", fix)
    _check_wall_columns(config)
    wall = grid.wall_columns
    if columns % wall != 0 or (grid.n_theta == 1 and columns != 1):
        cause, fix = "grid.n_theta = 1 is the axisymmetric model", "use 0, or more columns of wall"
        if grid.n_theta > 1:
            key = "grid.n_theta_wall" if grid.n_theta_wall else "grid.n_theta"
            cause = f"it is not a multiple of {key} = {wall}"
            fix = f"use {wall * max(1, round(columns / wall))}, or 0 for as many as grid.n_theta"
        _refuse("grid.n_theta_conduction", str(columns), cause, fix)
    if grid.n_theta > 1 and config.pellet.friction_coefficient > 0.0:
        _refuse(
            "pellet.friction_coefficient",
            f"{config.pellet.friction_coefficient:g}",
            "friction in proportion to contact pressure is there for the axisymmetric wall only",
            "use 0, or grid.n_theta = 1",
        )
    nodes = grid.n_z * columns + grid.n_z_wall * grid.n_theta
    if nodes > LARGEST_GRID:
        _refuse("grid", f"{nodes} nodes", f"at most {LARGEST_GRID} are allowed", "use fewer columns or cells")


def _check_wall_columns(config: Configuration) -> None:
    shown, wall = config.grid.n_theta, config.grid.wall_columns
    if shown == 1 and wall != 1:
        cause = "grid.n_theta = 1 is the axisymmetric model"
        _refuse("grid.n_theta_wall", str(wall), cause, "use 0, or more columns of wall")
    if shown > 1 and wall < FEWEST_COLUMNS:
        fix = f"use 0, or at least {FEWEST_COLUMNS}"
        _refuse("grid.n_theta_wall", str(wall), "too few columns for a ring", fix)
    if shown % wall != 0:
        below = max((count for count in range(FEWEST_COLUMNS, min(wall, shown) + 1) if shown % count == 0), default=0)
        cause = f"it does not divide grid.n_theta = {shown}, the columns on which the wall is shown"
        _refuse("grid.n_theta_wall", str(wall), cause, f"use {below}")


def _check_steps(config: Configuration) -> None:
    step, run = config.step, config.run
    ratio = step.whole / step.conduction
    if abs(ratio - round(ratio)) > 1e-9 * ratio or round(ratio) < 1:
        count = max(1, round(ratio))
        _refuse(
            step.whole_key,
            f"{step.whole} ms",
            f"it is {ratio:.6g} times step.conduction = {step.conduction} ms, not a whole number of times",
            f"use, for example, {count * step.conduction:.12g} ms",
        )
    steps = run.duration / units.to_internal(step.conduction, "ms")
    if steps > MOST_STEPS:
        _refuse(
            "run.duration",
            f"{run.duration} s",
            f"it takes {steps:.3g} steps of step.conduction = {step.conduction} ms, over {MOST_STEPS:.0e}",
            "shorten the run or lengthen the step",
        )
    if step.control == "error":
        _check_step_control(config)
    size = output_size(config)
    if size > LARGEST_OUTPUT:
        _refuse(
            "output.interval",
            f"{config.output.interval} s",
            f"the stored fields would take about {size / 1e9:.3g} GB, over {LARGEST_OUTPUT / 1e9:.3g} GB",
            "store less often or fewer fields (output.fields), shorten the run or use fewer nodes",
        )
    for key, time in (("run.duration", run.duration), ("output.interval", config.output.interval)):
        if time < units.to_internal(step.whole, "ms") * (1 - 1e-9):
            _refuse(key, f"{time} s", f"it is shorter than {step.whole_key} = {step.whole} ms", "use at least one step")


def _check_step_control(config: Configuration) -> None:
    """Steps whose length follows their error are halves of halves of the longest one, and implicit."""
    step = config.step
    if config.solver.integrator == "explicit":
        _refuse(
            "step.control",
            "error",
            "the explicit scheme steps with its stability limit (solver.integrator = explicit)",
            "use step.control = fixed, or solver.integrator = implicit",
        )
    parts = step.longest / step.shortest
    if parts < 1.0 or abs(parts - 2**step.halvings) > 1e-9 * parts:
        _refuse(
            "step.shortest",
            f"{step.shortest} ms",
            f"it is not step.longest = {step.longest} ms halved, once or more often",
            f"use, for example, {step.longest / 2 ** max(1, step.halvings):.12g} ms",
        )


def _check_explicit(config: Configuration) -> None:
    step = config.step
    if config.grid.n_theta > 1:
        _refuse(
            "solver.integrator",
            "explicit",
            f"grid.n_theta = {config.grid.n_theta}, and the explicit scheme is there for the axisymmetric wall only",
            "use solver.integrator = implicit, or grid.n_theta = 1",
        )
    if step.explicit > step.conduction * (1.0 + 1e-9):
        _refuse(
            "step.explicit",
            f"{step.explicit} ms",
            f"it is longer than step.conduction = {step.conduction} ms, of which it is a part",
            "shorten it, or 0 to have it chosen",
        )
    if step.explicit > 0.0 and config.run.duration / units.to_internal(step.explicit, "ms") > MOST_MICRO_STEPS:
        _refuse(
            "step.explicit",
            f"{step.explicit} ms",
            f"run.duration = {config.run.duration} s takes over {MOST_MICRO_STEPS:.0e} such steps",
            "lengthen the step (0 takes the longest that is stable) or shorten the run",
        )


def recording_of(config: Configuration) -> Recording:
    """What a run keeps: fields at every interval, numbers and probes at every step."""
    grid, output = config.grid, config.output
    step = units.to_internal(config.step.whole, "ms")
    nodes, cells = (grid.n_z_wall + 1) * grid.n_theta, grid.n_z * grid.conduction_columns
    return planned(
        config.run.duration, output.interval, step, nodes, cells, len(output.probes), output.fields, config.cells()
    )


def output_size(config: Configuration) -> float:
    """Bytes of all recorded arrays: fields at every interval, numbers and probes at every step."""
    return recording_of(config).size


def _check_places(config: Configuration) -> None:
    length = config.wall.length
    places = [("output.probes", place) for place in config.output.probes]
    if config.pacemaker.kind != "none":
        places.append(("pacemaker.width", config.pacemaker.width))
    if config.rings.enabled:
        places += [("rings.positions", place) for place in config.rings.positions]
    for key, place in places:
        if place > length:
            _refuse(key, f"{place} cm", "it lies beyond the anal end", f"use at most wall.length = {length} cm")
    _check_pacemaker_place(config)
    for stimulus in config.stimuli:
        if stimulus.high > length * (1.0 + 1e-9):
            _refuse("stimuli", stimulus.text(), "it reaches beyond the anal end", f"end it at {length:g} cm at most")
        if stimulus.sector < 360.0 and config.grid.conduction_columns == 1:
            cause, fix = (
                "one column cannot be driven in part",
                "use 360 deg, or more columns, such as grid.n_theta = 16",
            )
            _refuse("stimuli", stimulus.text(), cause, fix)


def _check_pacemaker_place(config: Configuration) -> None:
    pacemaker = config.pacemaker
    if pacemaker.kind == "none":
        return
    room = config.wall.length - pacemaker.width
    if pacemaker.place > room:
        _refuse(
            "pacemaker.place",
            f"{pacemaker.place} cm",
            f"with pacemaker.width = {pacemaker.width} cm the driven stretch reaches beyond the anal end",
            f"use at most {room:.6g} cm",
        )
    if pacemaker.angular_width < 360.0 and config.grid.conduction_columns == 1:
        _refuse(
            "pacemaker.angular_width",
            f"{pacemaker.angular_width} deg",
            "grid.n_theta = 1 is one column, which cannot be driven in part",
            "use 360 deg, or more columns, such as grid.n_theta = 16",
        )


def _check_control(config: Configuration) -> None:
    trigger, pacemaker, rings = config.trigger, config.pacemaker, config.rings
    if trigger.delay < 0 and trigger.rule != "pacemaker":
        _refuse(
            "trigger.delay",
            f"{trigger.delay} s",
            f"under trigger.rule = {trigger.rule} the circular layer cannot come first",
            "use at least 0 s, or trigger.rule = pacemaker",
        )
    step = config.step
    if trigger.gate == "stretch" and trigger.gate_duration < units.to_internal(step.whole, "ms") * (1.0 - 1e-9):
        _refuse(
            "trigger.gate_duration",
            f"{trigger.gate_duration} s",
            "the muscle would be prepared between two steps and at none",
            f"use at least {step.whole_key} = {step.whole:g} ms",
        )
    if trigger.rule == "pacemaker" and pacemaker.kind == "cell":
        _refuse(
            "trigger.rule",
            "pacemaker",
            "it follows the pulses of the pacemaker, and pacemaker.kind = cell has none",
            "use trigger.rule = active, or pacemaker.kind = pulse or periodic",
        )
    if pacemaker.kind == "periodic" and pacemaker.period <= pacemaker.duration:
        _refuse(
            "pacemaker.period",
            f"{pacemaker.period} s",
            "the pulses overlap",
            f"use more than pacemaker.duration = {pacemaker.duration} s",
        )
    if rings.enabled and rings.period <= rings.duration:
        _refuse(
            "rings.period",
            f"{rings.period} s",
            "the pulses overlap",
            f"use more than rings.duration = {rings.duration} s",
        )
    if rings.enabled and not rings.positions:
        _refuse("rings.positions", "[]", "rings are enabled but have no place", "name one or disable them")


def _check_pellet(config: Configuration) -> None:
    pellet, wall = config.pellet, config.wall
    needed = 2 * pellet.radius + pellet.start_gap
    if pellet.shape == SHIPPED["shape"] and needed >= wall.length:  # any other shape says it when it is built
        _refuse(
            "wall.length",
            f"{wall.length} cm",
            f"the pellet and its gap take {needed:.6g} cm (2 x pellet.radius + pellet.start_gap)",
            f"use a tube longer than {needed:.6g} cm or a smaller pellet",
        )
    closed = [f"wall.{end}" for end in ("oral_end", "anal_end") if getattr(wall, end) == "closed"]
    if closed and pellet.friction_frame == "wall":
        _refuse(
            closed[0],
            "closed",
            "an end that holds the pellet is there for friction at rest only (pellet.friction_frame = wall)",
            "use open, or pellet.friction_frame = rest",
        )
    stretch = pellet.radius / wall.radius
    if wall.law == SHIPPED["law"] and stretch > LARGEST_STRETCH:  # any other law says it at the start of the run
        _refuse(
            "pellet.radius",
            f"{pellet.radius} cm",
            f"the tube cannot hold this pellet: at wall.radius = {wall.radius} cm the stretch is "
            f"{stretch:.4g} and the passive hoop tension {_hoop_tension(wall, stretch)} mN/cm",
            f"use a pellet.radius of at most {LARGEST_STRETCH * wall.radius:.4g} cm",
        )


def _hoop_tension(wall: Wall, stretch: float) -> str:
    """Passive circumferential tension at no axial strain, Eqs. (3) and (4), to two digits."""
    strain = stretch - 1.0
    try:
        exponential = 2.0 * wall.c10 * wall.c5 * strain * math.exp(wall.c5 * strain * strain)
    except OverflowError:
        return "above 1e300"
    return f"{wall.c2 * strain + exponential:.2g}"


def _refuse(key: str, value: str, cause: str, fix: str) -> None:
    raise ConfigurationError(f"{key} = {value}: {cause}; {fix}")
