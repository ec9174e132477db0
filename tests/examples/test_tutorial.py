"""The tutorial is code: its blocks run in order, in one namespace, and its claims in `assert` hold."""

import re
from pathlib import Path

import pytest

TUTORIAL = Path(__file__).resolve().parents[2] / "docs" / "tutorial.md"


def test_tutorial_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A reader who copies every block gets no error, and the files that the text names."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    text = TUTORIAL.read_text(encoding="utf-8")
    namespace: dict[str, object] = {"__name__": "tutorial"}
    blocks = list(re.finditer(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
    assert len(blocks) >= 6
    for block in blocks:
        above = text[: block.start(1)].count("\n")  # so that a traceback shows the line of the page
        exec(compile("\n" * above + block.group(1), str(TUTORIAL), "exec"), namespace)
    assert (tmp_path / "out" / "thin" / "result.nc").is_file()
    assert list((tmp_path / "figures").glob("*.png"))
