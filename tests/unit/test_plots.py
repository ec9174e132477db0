"""Figures, film and CSV: what they show is what the run recorded, and odd runs draw too."""

from __future__ import annotations

import csv
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text

import peristalsis as ps
from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.model.model import ACTIVATION_LEVEL
from peristalsis.plots import Plots, data
from peristalsis.plots.export import export_csv
from peristalsis.plots.figures import currents, force_budget, manometry
from peristalsis.plots.film import _pictures, ffmpeg

SMALL = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 300,
    "grid.n_z_wall": 100,
    "run.duration": "0.3 s",
}


@pytest.fixture(scope="module")
def run() -> ps.Result:
    return ps.run("baseline", SMALL)


@pytest.fixture(scope="module")
def bare() -> ps.Result:
    """Nothing moves, and there is no pellet."""
    return ps.run("resting", {**SMALL, "run.duration": "0.05 s"})


@pytest.mark.parametrize("name", Plots.names())
def test_every_figure_draws(run: ps.Result, name: str) -> None:
    figure = run.plot.draw(name)
    assert figure.axes
    assert run.plot.caption(name)
    figure.draw_without_rendering()
    outline = figure.get_tightbbox()  # inches; what lies outside the page is cut off
    width, height = figure.get_size_inches()
    assert outline.x0 > -0.02
    assert outline.y0 > -0.02
    assert outline.x1 < width + 0.02
    assert outline.y1 < height + 0.02


@pytest.mark.parametrize("name", ["overview", "track", "force_budget", "currents"])
def test_legends_above_a_panel_keep_off_its_title(run: ps.Result, name: str) -> None:
    figure = run.plot.draw(name)
    figure.draw_without_rendering()
    legends = [(axes, axes.get_legend()) for axes in figure.axes if axes.get_legend() is not None]
    assert legends
    for axes, legend in legends:
        title = axes.get_title(loc="left")
        box = next(text for text in axes.texts + axes.findobj(Text) if text.get_text() == title).get_window_extent()
        assert not title or not box.overlaps(legend.get_window_extent())


@pytest.mark.parametrize("name", Plots.names())
def test_runs_without_pellet_draw_or_say_why_not(bare: ps.Result, name: str) -> None:
    if name in bare.plot.available():
        assert bare.plot.draw(name).axes
    else:
        with pytest.raises(ConfigurationError, match="this run has none"):
            bare.plot.draw(name)


def test_single_frame_draws(run: ps.Result) -> None:
    """A run that broke off at once has one stored time and one step."""
    short = {
        name: values[:1] if ps_first(name) in ("time", "time_step") else values for name, values in run.arrays.items()
    }
    first = replace(run, arrays=short, summary={**run.summary, "transit_s": None, "status": "diverged"})
    for name in first.plot.available():
        assert first.plot.draw(name).axes, name


def ps_first(name: str) -> str:
    from peristalsis.names import OUTPUTS

    return OUTPUTS[name].dimensions[0]


def test_diameter_map_shows_the_recorded_diameters(run: ps.Result) -> None:
    time, place, diameter = data.diameter_map(run)
    mesh = run.plot.diameter_map().axes[0].collections[0]
    assert np.array_equal(np.asarray(mesh.get_array()).reshape(place.size, time.size), diameter.T)
    assert 0.1 * diameter.min() == pytest.approx(2.0 * run.arrays["radius"].min(), rel=2e-3)
    assert 0.1 * diameter.min() == pytest.approx(run.summary["min_diameter_cm"], rel=1e-2)
    assert diameter.max() == pytest.approx(20.0 * run.configuration.pellet.radius, rel=2e-3)


def test_track_is_the_recorded_track(run: ps.Result) -> None:
    axes = run.plot.track().axes[0]
    line = next(line for line in axes.lines if line.get_label() == "pellet, centre")
    assert np.array_equal(line.get_ydata(), 10.0 * run.arrays["pellet_position"])
    low, high = axes.get_ylim()
    assert low > high  # the oral end is at the top


def test_pellet_poles_are_a_radius_from_the_track(run: ps.Result) -> None:
    lines = run.plot.diameter_map().axes[0].lines
    centre, oral, anal = (np.asarray(line.get_ydata()) for line in lines)
    radius = 10.0 * run.configuration.pellet.radius
    assert np.allclose(centre - oral, radius)
    assert np.allclose(anal - centre, radius)


def test_forces_on_the_pellet_cancel(run: ps.Result) -> None:
    """Contact, viscous and dry friction add up to nothing: to rounding, of forces of tens of mN."""
    assert np.abs(run.arrays["axial_force"]).max() > 10.0
    assert np.abs(force_budget.total(run)).max() < 1e-9


def test_currents_are_those_the_cell_had(run: ps.Result) -> None:
    """At rest, before the wave arrives at the probe, the five currents cancel in both layers."""
    for layer in ("longitudinal", "circular"):
        flows = currents.currents_at(run, layer)
        assert set(flows) == {*currents.LARGE, *currents.SMALL}
        assert abs(sum(flow[0] for flow in flows.values())) < 1e-6 * abs(flows["leak"][0])
    with pytest.raises(ConfigurationError, match=r"output\.probes"):
        run.plot.currents(probe=1)


def test_contact_map_lies_within_the_recorded_edges(run: ps.Result) -> None:
    """What is coloured is the contact band, and its largest value is the recorded one."""
    _, place, pressure = data.contact_map(run)
    band = data.at_frames(run, "contact_end", "mm") - data.at_frames(run, "contact_start", "mm")
    element = 10.0 * run.configuration.wall.length / run.configuration.grid.n_z_wall
    coloured = (pressure > 0.0).sum(axis=1) * (place[1] - place[0])
    assert np.all(np.abs(coloured - band) < 4.0 * element)
    assert pressure.max() == pytest.approx(np.max(run.arrays["contact_pressure"]), rel=0.05)


def test_caption_names_the_level_of_activation(run: ps.Result) -> None:
    level = f"{ACTIVATION_LEVEL:g}".replace("-", "\N{MINUS SIGN}")
    assert f"rise through {level} mV" in run.plot.caption("potential_maps")


def test_folds_of_the_wall_leave_the_map_defined(run: ps.Result) -> None:
    """Where the wall runs backwards the interpolation skips it rather than failing or inventing values."""
    places = run.arrays["axial_position"].copy()
    places[:, 50] = places[:, 48]
    folded = replace(run, arrays={**run.arrays, "axial_position": places})
    _, _, diameter = data.diameter_map(folded)
    assert diameter.min() >= 20.0 * run.arrays["radius"].min()
    assert diameter.max() <= 20.0 * run.arrays["radius"].max()


def test_manometry_reads_the_lumen_where_nothing_touches(run: ps.Result) -> None:
    _, place, pressure = data.manometry(run, 10.0)
    assert place.tolist() == [10.0 * k for k in range(1, 10)]
    lumen = data.at_frames(run, "lumen_pressure", "mmHg")
    assert np.allclose(pressure[:, -1], lumen)
    assert pressure[:, 0].max() > 2.0 * lumen.max()  # the sensor under the pellet


def test_save_writes_what_was_asked_for(run: ps.Result, tmp_path: Path) -> None:
    files = run.plot.save(tmp_path, ["track", "contact"], ("png", "svg", "pdf"))
    assert sorted(file.name for file in files) == sorted(
        f"{name}.{ending}" for name in ("track", "contact") for ending in ("png", "svg", "pdf")
    )
    assert sorted(tmp_path.iterdir()) == sorted(files)
    assert all(file.stat().st_size > 1000 for file in files)


def test_pictures_carry_their_caption(run: ps.Result, tmp_path: Path) -> None:
    from PIL import Image

    (file,) = run.plot.save(tmp_path, ["energy"])
    with Image.open(file) as picture:
        assert picture.info["Description"] == run.plot.caption("energy")


def test_listing_the_figures_loads_no_matplotlib() -> None:
    code = "import sys; from peristalsis.plots import Plots; Plots.names(); sys.exit('matplotlib' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_unknown_names_are_refused(run: ps.Result, tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match="diameter_map"):
        run.plot.save(tmp_path, ["diametre_map"])
    with pytest.raises(ConfigurationError, match="jpeg"):
        run.plot.save(tmp_path, ["track"], ["jpeg"])
    with pytest.raises(AttributeError, match="diameter_map"):
        run.plot.diameter_mapp  # noqa: B018


def test_film_has_its_frames_and_they_differ(run: ps.Result, tmp_path: Path) -> None:
    from PIL import Image

    path = run.plot.film(tmp_path / "film.gif", frames=7)
    with Image.open(path) as film:
        assert film.n_frames == 7
        film.seek(0)
        first = np.asarray(film.convert("RGB"))
        film.seek(6)
        assert (np.asarray(film.convert("RGB")) != first).any()
        assert tuple(first[0, 0]) == (255, 255, 255)
    assert [file.name for file in tmp_path.iterdir()] == ["film.gif"]


def test_film_of_a_narrow_tube_shows_its_axis(run: ps.Result, monkeypatch: pytest.MonkeyPatch) -> None:
    """Ticks wider than the tube made the axes higher than the picture, which cut off what stands below them."""
    from matplotlib.axes import Axes

    narrow = replace(run, arrays={**run.arrays, "radius": 0.5 * run.arrays["radius"]})
    limits: list[tuple[float, float]] = []
    draw = Axes.draw
    monkeypatch.setattr(Axes, "draw", lambda axes, *words: (limits.append(axes.get_ylim()), draw(axes, *words))[1])
    _pictures(narrow, [0], 20)
    widest = 10.0 * float(narrow.arrays["radius"].max()) + 2.0
    assert widest < 10.0
    assert limits[0] == pytest.approx((-widest, widest), rel=1e-6)


def test_film_without_ffmpeg_says_what_is_missing(
    run: ps.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("peristalsis.plots.film.ffmpeg", lambda: None)
    with pytest.raises(ConfigurationError, match=r"needs ffmpeg.*\.gif"):
        run.plot.film(tmp_path / "film.mp4")
    with pytest.raises(ConfigurationError, match=r"\.gif or \.mp4"):
        run.plot.film(tmp_path / "film.avi")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(ffmpeg() is None, reason="no ffmpeg here; the GIF needs none")
def test_film_as_mp4(run: ps.Result, tmp_path: Path) -> None:
    path = run.plot.film(tmp_path / "film.mp4", frames=5)
    assert b"ftyp" in path.read_bytes()[:64]


class Encoder:
    """Stands in for ffmpeg: writes what it is given, or fails as it is told."""

    def __init__(self, code: int = 0, said: bytes = b"") -> None:
        self.returncode, self.stderr = code, said

    def __call__(self, command: list[str], **options: Any) -> Encoder:
        self.command, self.given = command, options["input"]
        if self.returncode == 0:
            Path(command[-1]).write_bytes(self.given)
        return self


def test_film_is_handed_to_ffmpeg_whole(run: ps.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Size and rate in its words, all pixels of all frames at its input, even sides."""
    encoder = Encoder()
    monkeypatch.setattr("peristalsis.plots.film.ffmpeg", lambda: "/bin/ffmpeg")
    monkeypatch.setattr(subprocess, "run", encoder)
    path = run.plot.film(tmp_path / "film.mp4", frames=3, rate=7)
    words = encoder.command
    width, height = (int(side) for side in words[words.index("-s") + 1].split("x"))
    assert width % 2 == height % 2 == 0
    assert path.stat().st_size == 3 * 3 * width * height
    assert words[0] == "/bin/ffmpeg"
    assert words[words.index("-r") + 1] == "7"
    frames = np.frombuffer(encoder.given, np.uint8).reshape(3, height, width, 3)
    assert (frames[0] != frames[2]).any()
    assert [file.name for file in tmp_path.iterdir()] == ["film.mp4"]


@pytest.mark.parametrize(
    ("stderr", "said"), [(b"first\nUnknown encoder 'libx264'\n", "Unknown encoder 'libx264'"), (b"", "no reason given")]
)
def test_failure_of_ffmpeg_is_told_in_its_words(
    run: ps.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stderr: bytes, said: str
) -> None:
    monkeypatch.setattr("peristalsis.plots.film.ffmpeg", lambda: "ffmpeg")
    monkeypatch.setattr(subprocess, "run", Encoder(1, stderr))
    with pytest.raises(ConfigurationError, match=rf"could not make.*{said}; name a \.gif"):
        run.plot.film(tmp_path / "film.mp4", frames=1)
    assert list(tmp_path.iterdir()) == []


def test_ffmpeg_of_the_system_comes_before_that_of_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    extra = SimpleNamespace(get_ffmpeg_exe=lambda: "/extra/ffmpeg")
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", extra)  # type: ignore[arg-type]
    monkeypatch.setattr(shutil, "which", lambda name: f"/usr/bin/{name}")
    assert ffmpeg() == "/usr/bin/ffmpeg"
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert ffmpeg() == "/extra/ffmpeg"
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)  # type: ignore[arg-type]
    assert ffmpeg() is None


@pytest.mark.parametrize("count", [{"frames": 0}, {"frames": 2001}, {"rate": 0}, {"rate": 101}])
def test_films_of_no_or_too_many_frames_are_refused(run: ps.Result, tmp_path: Path, count: dict[str, int]) -> None:
    with pytest.raises(ConfigurationError, match="give 1 to 2000 frames, and a rate of 1 to 100"):
        run.plot.film(tmp_path / "film.gif", **count)


def test_film_of_a_single_frame_without_pellet(bare: ps.Result, tmp_path: Path) -> None:
    """No speed to tell, no pellet to draw; a place that cannot be written is said."""
    from PIL import Image

    with Image.open(bare.plot.film(tmp_path / "film.gif", frames=1)) as film:
        assert film.n_frames == 1
    with pytest.raises(WriteError, match="choose another place"):
        bare.plot.film(tmp_path / "film.gif" / "film.gif", frames=1)


def test_csv_holds_the_numbers_to_the_last_bit(run: ps.Result, tmp_path: Path) -> None:
    export_csv(run, tmp_path, fields=("all",))
    with (tmp_path / "curves.csv").open(newline="", encoding="ascii") as file:
        head, *rows = csv.reader(file)
    column = head.index("pellet_position [cm]")
    assert [float(row[column]) for row in rows] == run.arrays["pellet_position"].tolist()
    with (tmp_path / "map_radius.csv").open(newline="", encoding="ascii") as file:
        head, *rows = csv.reader(file)
    assert head[0] == "time [s]; cells: radius [cm]"
    assert [[float(cell) for cell in row[1:]] for row in rows] == run.arrays["radius"][:, :, 0].tolist()
    with (tmp_path / "events.csv").open(newline="", encoding="ascii") as file:
        assert [row[2] for row in csv.reader(file)][1:] == run.arrays["event_kind"].tolist()


def test_isobars_are_drawn_where_they_occur(run: ps.Result, monkeypatch: pytest.MonkeyPatch) -> None:
    """Levels between the least and the largest pressure, as lines on the upper map, on its bar and in its title."""
    top = float(data.manometry(run, manometry.SPACING)[2].max())
    monkeypatch.setattr(manometry, "ISOBARS", (0.25 * top, 0.5 * top, 2.0 * top))
    figure = run.plot.draw("manometry")
    figure.draw_without_rendering()
    titles = " ".join(axes.get_title(loc="left") for axes in figure.axes) + " ".join(
        text.get_text() for text in figure.findobj(Text)
    )
    assert f"isobars {0.25 * top:g}, {0.5 * top:g} mmHg" in titles
    monkeypatch.setattr(manometry, "ISOBARS", (2.0 * top,))
    assert "isobars" not in " ".join(text.get_text() for text in run.plot.draw("manometry").findobj(Text))


def test_figures_that_cannot_be_written_say_so(run: ps.Result, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(WriteError, match=r"could not write figures into .*choose another folder"):
        run.plot.save(tmp_path / "file", ["track"])
    with pytest.raises(WriteError, match=r"could not write CSV files into .*choose another folder"):
        export_csv(run, tmp_path / "file")


def test_figures_are_listed_beside_what_plots_can_do(run: ps.Result) -> None:
    assert {"save", "film", *Plots.names()} <= set(dir(run.plot))


def test_csv_is_small_unless_asked(run: ps.Result, tmp_path: Path) -> None:
    """The map of diameters alone; rows as far apart as asked, the last one kept; compressed on demand."""
    import gzip

    assert {file.name for file in export_csv(run, tmp_path / "all")} == {
        "curves.csv",
        "probes.csv",
        "events.csv",
        "map_diameter_in_space.csv",
    }
    files = export_csv(run, tmp_path / "few", every=0.1, fields=("radius",), compress=True)
    assert "map_radius.csv.gz" in {file.name for file in files}
    with gzip.open(tmp_path / "few" / "curves.csv.gz", "rt", encoding="ascii") as file:
        times = [float(row[0]) for row in list(csv.reader(file))[1:]]
    assert times == pytest.approx([0.0, 0.1, 0.2, 0.3])
    with pytest.raises(ConfigurationError, match="not stored by this run"):
        export_csv(run, tmp_path, fields=("radios",))


def test_what_a_comparison_cuts_is_said(run: ps.Result, bare: ps.Result) -> None:
    from peristalsis.many.comparing import cuts

    assert cuts({"a": run, "b": run}) == []
    (sentence,) = cuts({"a": run, "b": bare})
    assert "a 0.3 s, b 0.05 s" in sentence


def test_tables_in_other_units(run: ps.Result, tmp_path: Path) -> None:
    """Each number converts once, its column says to what, and what does not convert stays; the order is the wish's."""

    def columns(folder: str, *units: str) -> dict[str, list[str]]:
        found: dict[str, list[str]] = {}
        for file in export_csv(run, tmp_path / folder, units=units):
            rows = list(csv.reader(file.read_text(encoding="ascii").splitlines()))
            found |= {f"{file.stem}: {name}": [row[k] for row in rows[1:]] for k, name in enumerate(rows[0])}
        return found

    def last(table: dict[str, list[str]], name: str) -> float:
        return float(table[name][-1])

    own, other, si = columns("own"), columns("other", "Pa", "mm"), columns("si", "SI")
    place = last(own, "curves: pellet_position [cm]")
    assert last(other, "curves: pellet_position [mm]") == pytest.approx(10.0 * place)
    assert last(si, "curves: pellet_position [m]") == pytest.approx(0.01 * place)
    pressure = last(own, "curves: lumen_pressure [kPa]")
    assert last(other, "curves: lumen_pressure [Pa]") == pytest.approx(1000.0 * pressure)
    assert last(si, "curves: axial_force [N]") == pytest.approx(1e-3 * last(own, "curves: axial_force [mN]"))
    assert last(other, "curves: axial_force [mN]") == last(own, "curves: axial_force [mN]")
    assert len(own) == len(other) == len(si)
    left = {name.rpartition("[")[2] for name in si if name.startswith("curves") and name.endswith("]")}
    assert not left & {"cm]", "mm]", "kPa]", "mN]", "mN*cm]", "cm/s]", "mV]"}


@pytest.mark.parametrize(("unit", "cause"), [("cubits", "unknown"), ("kelvin", "no number of a run"), ("2 mm", "unit")])
def test_units_that_no_number_has_are_refused(run: ps.Result, tmp_path: Path, unit: str, cause: str) -> None:
    with pytest.raises(ConfigurationError, match=cause):
        export_csv(run, tmp_path / "csv", units=(unit,))
