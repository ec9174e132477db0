"""What is said where the system refuses to write: its reason, and the fix for that reason."""

from __future__ import annotations

import errno
import os
from pathlib import Path

import pytest

import peristalsis as ps
from peristalsis.errors import WriteError, could_not
from peristalsis.scoring.report import write_table
from peristalsis.scoring.source import Table


@pytest.mark.parametrize(
    ("code", "fix"),
    [
        (errno.ENOSPC, "free some space or choose another place"),
        (errno.ENOTDIR, "a file stands where a folder has to be; choose another place"),
        (errno.EISDIR, "a folder stands where a file has to be; choose another place"),
        (errno.EACCES, "you may not write there; choose another place"),
        (errno.EROFS, "nothing can be written there; choose another place"),
        (errno.EIO, "; choose another place"),
    ],
)
def test_the_fix_is_that_of_the_cause(code: int, fix: str) -> None:
    said = str(could_not("write 'x'", OSError(code, os.strerror(code)), "another place"))
    assert said.startswith(f"could not write 'x': {os.strerror(code)}; ")
    assert said.endswith(fix)
    assert ("space" in said) == (code == errno.ENOSPC)  # the message of no other cause speaks of room


def test_a_reason_without_a_number_is_kept() -> None:
    assert str(could_not("write 'x'", OSError("odd"), "another")) == "could not write 'x': odd; choose another"


def test_a_file_in_the_way_is_not_called_a_full_disk(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("here already")
    with pytest.raises(WriteError, match="a file stands where a folder has to be; choose another folder with --out"):
        write_table(Table("t", "", "", ("a",), ()), blocked)


def test_a_simulation_says_where_it_is() -> None:
    simulation = ps.Simulation(ps.configuration("baseline", changes={"grid.n_z": 50, "grid.n_z_wall": 40}))
    assert repr(simulation).startswith("<Simulation of baseline at 0 s, pellet at 1.")
    resting = ps.configuration("resting", changes={"grid.n_z": 50, "grid.n_z_wall": 40})
    assert repr(ps.Simulation(resting)).endswith("no pellet>")
