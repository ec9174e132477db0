"""What a user sees unasked: results and figures in a notebook, remarks of a run, figures that are left out."""

from __future__ import annotations

import logging
from pathlib import Path

import pytest

import peristalsis as ps
from peristalsis import runner
from peristalsis.plots import Plots

TINY = {"grid.n_z": 60, "grid.n_z_wall": 40, "run.duration": "20 ms", "output.interval": "10 ms"}


@pytest.fixture(scope="module")
def run() -> ps.Result:
    return ps.run("baseline", TINY)


def test_a_result_is_a_few_lines(run: ps.Result) -> None:
    lines = repr(run).splitlines()
    assert len(lines) < 16
    assert "baseline" in lines[0]
    assert any("status: in transit" in line for line in lines)
    assert any("grid.n_z = 60" in line for line in lines), "what limits it"


def test_a_result_shows_itself_in_a_notebook(run: ps.Result) -> None:
    """Status, numbers, remarks and a small picture, without any text taken for markup."""
    page = run._repr_html_()
    assert "<td>in transit</td>" in page
    assert 'src="data:image/png;base64,iVBOR' in page
    assert "grid.n_z = 60" in page
    assert len(page) < 100_000


def test_figures_show_themselves_in_a_notebook(run: ps.Result) -> None:
    """What IPython asks an object for, without a backend that knows figures."""
    figure = run.plot.diameter_map()
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_remarks_are_said_once(caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(runner, "_SAID", set())
    with caplog.at_level(logging.WARNING, "peristalsis"):
        result = ps.run("baseline", {**TINY, "run.duration": "4 ms"})
        ps.run("baseline", {**TINY, "run.duration": "4 ms"})
    assert result.remarks
    assert [record.getMessage() for record in caplog.records] == [f"baseline: {text}" for text in result.remarks]


@pytest.mark.parametrize(
    "changes",
    [
        {"output.probes": []},
        {"output.fields": []},
        {"pellet.enabled": False},
        {"run.duration": "2 ms"},
        {"output.probes": [], "output.fields": [], "pellet.enabled": False, "run.duration": "2 ms"},
    ],
    ids=["no probes", "no fields", "no pellet", "one step", "nothing"],
)
def test_figures_that_cannot_be_drawn_are_left_out_with_a_sentence(
    changes: dict[str, object], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The others are drawn all the same."""
    monkeypatch.setattr("peristalsis.plots.style.write", lambda canvas, path, title, caption: path.write_bytes(b""))
    plots = ps.run("baseline", {**TINY, **changes}).plot
    files = plots.save(tmp_path)
    assert {file.stem for file in files} | set(plots.skipped) == set(Plots.names())
    assert not {file.stem for file in files} & set(plots.skipped)
    assert {"diameter_map"} <= {file.stem for file in files}
    assert all(";" in why for why in plots.skipped.values()), "a cause and a fix"
