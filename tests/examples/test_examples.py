"""Every script in `examples` runs as it stands and prints one number, with its unit, in a sane range."""

import re
import runpy
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"

RANGES = {
    "friction_offset": (80.0, 200.0, "mN*s/cm"),
    "halving_the_muscle": (0.3, 4.0, "s"),
    "pressure_of_the_squeeze": (10.0, 30.0, "kPa"),
    "receptors_alone": (2.4, 5.0, "s"),
    "transit_time": (2.2, 2.8, "s"),
    "wave_speed": (3.0, 4.2, "cm/s"),
}
"""Least and largest number on the coarse grids, and its unit: wide enough for the grid, too narrow for a wrong unit."""


def test_every_example_has_a_range() -> None:
    """A new example must say what it expects, and a removed one must not linger here."""
    assert {file.stem for file in EXAMPLES.glob("*.py")} == set(RANGES)


@pytest.mark.parametrize("name", sorted(RANGES))
def test_example_prints_its_number(
    name: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line on standard output: number, unit, colon, meaning."""
    monkeypatch.setattr(sys, "argv", [f"{name}.py", "--quick"])
    runpy.run_path(str(EXAMPLES / f"{name}.py"), run_name="__main__")
    out, err = capsys.readouterr()
    assert "coarse" in err, "quick grids are said to be coarse"
    lines = out.splitlines()
    assert len(lines) == 1
    found = re.match(r"(-?[0-9.]+) (\S+): \S.{20,}", lines[0])
    assert found is not None, lines[0]
    low, high, unit = RANGES[name]
    assert found.group(2) == unit
    assert low < float(found.group(1)) < high
