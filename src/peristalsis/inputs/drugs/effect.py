"""What doses make of the conductances of a cell, (110) to (112)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations

from ...errors import ConfigurationError
from .specification import Dose

CALCIUM = ("slow_calcium", "fast_calcium")
READ_AS = ("L-type", "T-type")
"""Channels of Plant's cell and channels of muscle: which is which the shipped libraries read in two ways."""


def factor(doses: Iterable[Dose]) -> float:
    """Factor on the conductance of one target: agents compete for it, (110).

    1 + sum of (maximum - 1) x / (1 + sum of x), where x = (c / IC50)^slope of each; Hill's curve for one agent.
    """
    listed = tuple(doses)
    bound = 1.0 + sum(dose.reach for dose in listed)
    return 1.0 + sum((dose.maximum - 1.0) * dose.reach for dose in listed) / bound


def factors(doses: Sequence[Dose], cell: str, channels: Sequence[str]) -> list[float]:
    """Factor on each channel of a cell model; targets that are the same channel act independently, (111)."""
    found = []
    for channel in channels:
        by_target: dict[str, list[Dose]] = {}
        for dose in doses:
            if f"{cell}.{channel}" in dose.channels:
                by_target.setdefault(dose.target, []).append(dose)
        whole = 1.0
        for listed in by_target.values():
            whole *= factor(listed)
        found.append(whole)
    return found


def check(doses: Sequence[Dose], cells: Sequence[str]) -> None:
    """Raise ConfigurationError for a dose whose target none of the cell models of a run has."""
    for dose in doses:
        if not any(acts_on(dose, cell) for cell in cells):
            named = ", ".join(sorted(set(cells)))
            raise ConfigurationError(
                f"drugs: {dose.agent} acts on {dose.target}, which no cell of this run has ({named}); leave it out, or "
                "state the channel on which it is to act in a library file ([targets], --drugs FILE)"
            )


def without_target(doses: Sequence[Dose], cells: Mapping[str, str]) -> list[str]:
    """A sentence for each dose and layer whose cell model lacks the target. cells: layer to cell model."""
    return [
        f"{dose.agent} does nothing to the {layer} cells: {cell} has no {dose.target}"
        for dose in doses
        for layer, cell in cells.items()
        if not acts_on(dose, cell)
    ]


def acts_on(dose: Dose, cell: str) -> bool:
    """Whether a cell model has the target of a dose."""
    return any(channel.partition(".")[0] == cell for channel in dose.channels)


def doubtful(doses: Sequence[Dose], cells: Sequence[str]) -> list[str]:
    """A sentence for each calcium channel of Plant's cell on which doses act: which one is the L-type is a reading."""
    if "plant" not in cells:
        return []
    found = []
    for channel, left in zip(CALCIUM, factors(doses, "plant", CALCIUM), strict=True):
        acting = [dose for dose in doses if f"plant.{channel}" in dose.channels and dose.target in READ_AS]
        if acting:
            target = acting[0].target
            shipped = (channel, target) in (("slow_calcium", "L-type"), ("fast_calcium", "T-type"))
            found.append(
                f"{' and '.join(dose.agent for dose in acting)}: {left:.3g} of the {channel.replace('_', ' ')} "
                f"conductance is left, because this channel is taken to be the {target} channel; that is a reading, "
                f"and results differ widely under the other one ({'with' if shipped else 'without'} --drugs "
                "l_type_is_fast): give both"
            )
    return found


def mixed(doses: Sequence[Dose]) -> str | None:
    """What to say of numbers from different preparations beside one another; None if they are from one."""
    tissues = {f"{dose.agent} on {dose.target}": dose.tissue for dose in doses}
    if all(one == two for one, two in combinations(tissues.values(), 2)):
        return None
    listed = ", ".join(f"{name} in {tissue}" for name, tissue in tissues.items())
    return (
        f"numbers from different preparations stand side by side ({listed}); the order of agents by potency differs "
        "from tissue to tissue: compare within one, or take the comparison with reserve"
    )
