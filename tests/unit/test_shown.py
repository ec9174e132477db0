"""What a user sees unasked: results and figures in a notebook, remarks of a run, figures that are left out."""

from __future__ import annotations

import logging
from dataclasses import replace
from pathlib import Path

import pytest

import peristalsis as ps
from peristalsis.cli.streams import RunProgress, Screen
from peristalsis.names import FIELDS, OUTPUTS
from peristalsis.plots import Plots, scene
from peristalsis.running import runner

TINY = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 60,
    "grid.n_z_wall": 40,
    "run.duration": "20 ms",
    "output.interval": "10 ms",
}


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


def test_where_nothing_touches_the_wall_is_light(run: ps.Result) -> None:
    """Most of the wall bears no contact pressure: a scene of it must not be a black tube."""
    from matplotlib import colormaps

    view = scene._view(run, "contact_pressure")
    low, high = view.limits
    assert low == 0.0 < high
    red, green, blue, _ = colormaps[scene.COLOURS["contact_pressure"]](0.0)
    assert min(red, green, blue) > 0.7
    assert set(scene.COLOURS) <= {output.name for output in FIELDS}


def test_stretch_is_coloured_about_the_undeformed_length(run: ps.Result) -> None:
    low, high = scene._view(run, "stretch_circumferential").limits
    assert low + high == pytest.approx(2.0)


def test_film_has_the_rate_that_was_asked_for(run: ps.Result, tmp_path: Path) -> None:
    """Pictures a second, in the file; the last one stays."""
    from PIL import Image

    with Image.open(run.plot.film(tmp_path / "film.gif", frames=3, rate=10)) as film:
        shown = []
        for frame in range(film.n_frames):
            film.seek(frame)
            shown.append(film.info["duration"])
    assert shown == [100, 100, 1500]


@pytest.mark.parametrize(("frames", "rate"), [(0, 20), (3, 0), (3, 101), (2001, 20)])
def test_film_that_cannot_be_is_refused(run: ps.Result, tmp_path: Path, frames: int, rate: int) -> None:
    with pytest.raises(ps.PeristalsisError, match="give 1 to 2000 frames, and a rate of 1 to 100"):
        run.plot.film(tmp_path / "film.gif", frames, rate)


def test_progress_of_a_run_that_ends_early_is_full(capsys: pytest.CaptureFixture[str]) -> None:
    """The pellet leaves at 2.4 of 10 s: the last line says 100 % and why, not 24 %."""
    with RunProgress(Screen(json=False), 10.0, pellet=True) as progress:
        progress.start()
        progress.see(2.4, 9.1)
        progress.done("expelled", 2.4)
        progress.done("expelled", 2.4)
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(" %")[0].strip() for line in lines[1:]] == ["20", "100"]
    assert lines[-1].endswith("t = 2.4 s: expelled")


def test_old_results_are_told_what_their_figures_lack(run: ps.Result) -> None:
    """Fields are a matter of output.fields; what is always kept, of the version that made the result."""
    lacking = replace(run, arrays={name: run.arrays[name] for name in run.arrays if name not in LATER})
    for name in ("currents", "force_budget"):
        with pytest.raises(ps.PeristalsisError, match=r"did not record it yet; run its config\.toml again"):
            getattr(lacking.plot, name)()
    lacking = replace(run, arrays={name: run.arrays[name] for name in run.arrays if name != "contact_pressure"})
    with pytest.raises(ps.PeristalsisError, match=r"repeat it with output\.fields"):
        lacking.plot.manometry()


LATER = {name for name in OUTPUTS if name.startswith("conductance_") or name == "dry_friction_limit"}
"""Outputs that results of earlier versions do not hold."""
