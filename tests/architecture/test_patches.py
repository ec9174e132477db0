"""Errors that `evidence` puts into copies of the package still find the text that they change."""

import sys
from pathlib import Path

import pytest

import peristalsis

sys.path.insert(0, str(Path(__file__).parents[2] / "evidence"))
import misprints

PACKAGE = Path(peristalsis.__file__).parent
PATCHES = [(one.where, patch) for one in misprints.MISPRINTS for patch in one.patches]


@pytest.mark.parametrize(("where", "patch"), PATCHES, ids=[f"{where} {k}" for k, (where, _) in enumerate(PATCHES)])
def test_a_misprint_can_be_put_back(where: str, patch: misprints.Patch) -> None:
    text = (PACKAGE / patch.file).read_text(encoding="utf-8")
    assert text.count(patch.old) == patch.times, f"{where}: {patch.file}: {patch.old!r}"


def test_there_are_patches() -> None:
    assert len(PATCHES) > 15
