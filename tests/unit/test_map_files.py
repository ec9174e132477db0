"""Files of maps: what is written comes back, what laboratories export is read, what cannot be read is one sentence."""

from __future__ import annotations

import io
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest
from PIL import Image
from scipy.io import netcdf_file, savemat

from peristalsis import maps
from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.maps.synthetic import example
from peristalsis.maps.text_files import numbers, table_of

TIME, PLACE = 2.0 + 0.25 * np.arange(40), 5.0 + 0.5 * np.arange(30)


@pytest.fixture(scope="module")
def small() -> maps.Map:
    """Diameters with gaps, from 2 s and 5 mm on."""
    random = np.random.default_rng(4)
    values = 10.0 + random.standard_normal((TIME.size, PLACE.size))
    values[3:5] = np.nan
    values[:, 7] = np.nan
    return maps.Map(values, TIME, PLACE, "diameter", "small", ("made", "by hand"))


@pytest.mark.parametrize(
    ("name", "options"),
    [("a.csv", {}), ("b.csv", {"form": "long"}), ("c.nc", {}), ("d.mat", {})],
)
def test_written_and_read_back_to_the_same_bits(small: maps.Map, tmp_path: Path, name: str, options: dict) -> None:
    back = maps.read(maps.write(small, tmp_path / name, **options))
    assert back.fingerprint() == small.fingerprint()
    assert back.history[:2] == ("made", "by hand") or name == "b.csv"


@pytest.mark.parametrize(
    ("name", "options", "levels"),
    [
        ("a.tif", {}, 65534),
        ("b.tif", {"bits": 8}, 254),
        ("c.tif", {"time": "down"}, 65534),
        ("d.png", {}, 65534),
        ("e.png", {"bits": 8, "time": "down"}, 254),
    ],
)
def test_pictures_lose_half_a_step_and_keep_their_scale(
    small: maps.Map, tmp_path: Path, name: str, options: dict, levels: int
) -> None:
    back = maps.read(maps.write(small, tmp_path / name, **options))
    span = float(np.nanmax(small.values) - np.nanmin(small.values))
    assert np.nanmax(np.abs(back.values - small.values)) <= 0.5 * span / levels * (1.0 + 1e-9)
    assert np.array_equal(np.isnan(back.values), np.isnan(small.values))
    assert back.time == pytest.approx(small.time, abs=1e-9)
    assert back.place == pytest.approx(small.place, abs=1e-9)
    assert back.quantity == "diameter"


def test_another_reader_sees_the_scale_of_a_tiff(small: maps.Map, tmp_path: Path) -> None:
    """Pixels per unit in the tags, units, origin and the line from grey to value where ImageJ keeps them."""
    with Image.open(maps.write(small, tmp_path / "map.tif")) as picture:
        tags, size, grey = picture.tag_v2, picture.size, np.asarray(picture)
    lines = dict(line.split("=", 1) for line in tags[270].splitlines())
    assert size == (TIME.size, PLACE.size)
    assert (float(tags[282]), float(tags[283]), tags[296]) == (4.0, 2.0, 1)
    assert (lines["unit"], lines["yunit"], lines["vunit"]) == ("sec", "mm", "mm")
    assert (float(lines["xorigin"]), float(lines["yorigin"])) == (-8.0, -10.0)
    assert tags[270].startswith("ImageJ=")
    values = float(lines["c0"]) + float(lines["c1"]) * grey[grey > 0]
    assert values.min() == pytest.approx(np.nanmin(small.values), abs=1e-6)
    assert values.max() == pytest.approx(np.nanmax(small.values), abs=1e-6)


def test_a_tiff_of_imagej_needs_its_greys_alone(tmp_path: Path) -> None:
    """As ImageJ saves a map that was scaled there: time down, 0.2 mm and 0.5 s a pixel; tags alone, no line of ours."""
    grey = np.arange(24, dtype=np.uint8).reshape(6, 4)
    text = "ImageJ=1.54f\nunit=mm\nyunit=sec\nloop=false\n"
    Image.fromarray(grey).save(tmp_path / "map.tif", tiffinfo={270: text, 282: 5.0, 283: 2.0, 296: 1})
    read = maps.read(tmp_path / "map.tif", grey=((0.0, 5.0), (100.0, 15.0)))
    assert read.values == pytest.approx(5.0 + 0.1 * grey)
    assert (read.time_step(), read.place_step()) == pytest.approx((0.5, 0.2))
    turned = maps.read(tmp_path / "map.tif", grey=((0.0, 5.0), (100.0, 15.0)), oral="last")
    assert turned.values == pytest.approx(read.values[:, ::-1])
    assert "turned around: the oral end was last" in turned.history


def test_a_plain_picture_is_read_as_stated(tmp_path: Path) -> None:
    grey = np.arange(24, dtype=np.uint16).reshape(4, 6) * 1000
    Image.fromarray(grey).save(tmp_path / "map.png")
    read = maps.read(tmp_path / "map.png", mm_per_px=0.1, s_per_px=0.04, grey=((0.0, 0.0), (1000.0, 1.0)), gap=23000)
    assert read.values.shape == (6, 4)
    assert read.values[2, 1] == pytest.approx(8.0)
    assert np.isnan(read.values[5, 3])
    assert read.time[-1] == pytest.approx(0.2)
    assert any("as stated" in line for line in read.history)


def test_manometry_of_uneven_channels_in_any_order_and_unit(tmp_path: Path) -> None:
    file = tmp_path / "catheter.csv"
    file.write_text(
        "time [min],P2 @ 3 cm [kPa],P1 @ 10 mm [kPa],P3 @ 75 mm [kPa]\n0,1,2,3\n0.5,4,,nan\n", encoding="utf-8"
    )
    read = maps.read(file)
    assert read.quantity == "pressure"
    assert read.place.tolist() == [10.0, 30.0, 75.0]
    assert read.time.tolist() == [0.0, 30.0]
    assert read.values[0] == pytest.approx(np.array([2.0, 1.0, 3.0]) / 0.133322387415)
    assert np.isnan(read.values[1]).tolist() == [True, False, True]
    file.write_text("time [s],a [cmH2O],b [cmH2O]\nplace [cm],1,2.5\n0,10,20\n1,11,21\n", encoding="utf-8")
    second = maps.read(file)
    assert second.place.tolist() == [10.0, 25.0]
    assert second.values[0, 0] == pytest.approx(7.3556, abs=1e-4)
    file.write_text("time [s],a,b\n0,10,20\n1,11,21\n", encoding="utf-8")
    assert maps.read(file, positions=(5.0, 9.0), unit="mmHg").place.tolist() == [5.0, 9.0]


def test_decimal_commas_places_down_and_descending_places(tmp_path: Path) -> None:
    file = tmp_path / "map.csv"
    file.write_text("place [cm] / time [s];0;0,5\n2;1,5;2,5\n1;3,5;\n", encoding="utf-8")
    read = maps.read(file, quantity="diameter", unit="cm")
    assert read.place.tolist() == [10.0, 20.0]
    assert read.values == pytest.approx(np.array([[35.0, 15.0], [np.nan, 25.0]]), nan_ok=True)
    assert any("10 times those in cm" in line for line in read.history)


def test_arrays_of_other_programs(tmp_path: Path) -> None:
    values = np.arange(12.0).reshape(4, 3)
    savemat(tmp_path / "a.mat", {"t": np.arange(4.0), "x": np.array([1.0, 2.0, 4.0]), "dmap": values})
    given = {"quantity": "diameter", "unit": "cm", "time_unit": "s", "place_unit": "cm"}
    read = maps.read(tmp_path / "a.mat", **given)
    assert read.place.tolist() == [10.0, 20.0, 40.0]
    assert read.values[1, 2] == 50.0
    with h5py.File(tmp_path / "b.mat", "w") as file:  # as version 7.3 stores it: turned
        file["time_s"], file["place_mm"], file["pressure_mmHg"] = np.arange(4.0)[None], np.arange(3.0)[None], values.T
    assert maps.read(tmp_path / "b.mat").values == pytest.approx(values)
    with netcdf_file(tmp_path / "c.nc", "w") as file:
        file.createDimension("x", 3)
        file.createDimension("t", 4)
        for name, dimensions, unit, data in (
            ("x", ("x",), "cm", np.arange(3.0)),
            ("t", ("t",), "s", np.arange(4.0)),
            ("diameter", ("x", "t"), "mm", values.T),
        ):
            variable = file.createVariable(name, "d", dimensions)
            variable[:] = data
            variable.units = unit
    classic = maps.read(tmp_path / "c.nc")
    assert classic.values == pytest.approx(values)
    assert classic.place.tolist() == [0.0, 10.0, 20.0]


def test_tracks_of_several_pellets(tmp_path: Path) -> None:
    pellets = (maps.Track(np.arange(3.0), np.array([1.0, 2.0, 4.0])), maps.Track(np.arange(2.0), np.array([5.0, 6.0])))
    back = maps.tracks(maps.write_tracks(pellets, tmp_path / "pellets.csv"))
    assert [one.position.tolist() for one in back] == [[1.0, 2.0, 4.0], [5.0, 6.0]]
    (tmp_path / "wide.csv").write_text("time [s],A [cm],B [cm]\n0,1,\n1,2,3\n2,,4\n", encoding="utf-8")
    wide = maps.tracks(tmp_path / "wide.csv")
    assert [(one.name, one.position.tolist()) for one in wide] == [("A", [10.0, 20.0]), ("B", [30.0, 40.0])]


def _png(mode: str, **more: object) -> bytes:
    image = io.BytesIO()
    Image.new(mode, (4, 3), **more).save(image, "PNG")
    return image.getvalue()


def _pages() -> bytes:
    image = io.BytesIO()
    page = Image.new("L", (4, 3))
    page.save(image, "TIFF", save_all=True, append_images=[page])
    return image.getvalue()


def _mat(**arrays: object) -> bytes:
    image = io.BytesIO()
    savemat(image, arrays)
    return image.getvalue()


AXES, SAID = "time [s] / place [mm],", "# quantity: diameter [mm]\ntime [s] / place [mm],"
DIAMETER = {"quantity": "diameter", "unit": "mm"}
PIXELS = {"mm_per_px": 1.0, "s_per_px": 1.0}
LONG = "time [s],place [mm],diameter [mm]\n"

MALFORMED: dict[str, tuple[str, bytes | str, dict, str]] = {
    "empty": ("a.csv", "", {}, "is empty"),
    "other ending": ("a.xlsx", "x", {}, "a map ends in"),
    "binary": ("a.csv", b"\xff\xfe\x00\x01,\x00", {}, "no text of UTF-8"),
    "zeros": ("a.csv", b"time\0[s],a\n0,1\n", {}, "no text file"),
    "one column": ("a.csv", "time [s]\n0\n", {}, "has 1 columns"),
    "no header": ("a.csv", "0,1,2\n1,2,3\n", {}, "begins with '0'"),
    "no rows": ("a.csv", AXES + "0,1\n", {}, "no rows"),
    "remarks alone": ("a.csv", "# quantity: diameter\n# more\n", {}, "no numbers"),
    "word in a cell": ("a.csv", SAID + "0,1\n0,1,2\n1,x,2\n", {}, "row 2, column 2"),
    "ragged": ("a.csv", SAID + "0,1\n0,1,2\n1,2\n", {}, "columns changed"),
    "falling times": ("a.csv", SAID + "0,1\n1,1,2\n0,1,2\n", {}, "do not rise"),
    "places out of order": ("a.csv", SAID + "0,2,1\n0,1,2,3\n", {}, "places do not rise"),
    "word in the header": ("a.csv", AXES + "0,one\n0,1,2\n", {}, "in the header is no number"),
    "nothing but gaps": ("a.csv", SAID + "0,1\n0,,\n1,nan,nan\n", {}, "only gaps"),
    "infinite": ("a.csv", SAID + "0,1\n0,1,inf\n", {}, "infinite"),
    "no quantity": ("a.csv", AXES + "0,1\n0,1,2\n", {}, "does not say what"),
    "no unit": ("a.csv", AXES + "0,1\n0,1,2\n", {"quantity": "diameter"}, "does not say the unit"),
    "wrong unit": ("a.csv", AXES + "0,1\n0,1,2\n", DIAMETER | {"unit": "kPa"}, "be converted"),
    "time without unit": ("a.csv", "time / place [mm],0,1\n0,1,2\n", DIAMETER, "times have no unit"),
    "channel nowhere": ("a.csv", "time [s],P1 [mmHg]\n0,1\n", {}, "place of channel"),
    "channels in two units": ("a.csv", "time [s],1 mm [mmHg],2 mm [kPa]\n0,1,2\n", {}, "different units"),
    "channels at one place": ("a.csv", "time [s],1 cm [mmHg],10 mm [mmHg]\n0,1,2\n", {}, "two channels are at 10 mm"),
    "twice in a long table": ("a.csv", LONG + "0,0,1\n0,1,1\n0,0,2\n", {}, "row 3 are there twice"),
    "scattered": ("a.csv", LONG + "".join(f"{k},{k},1\n" for k in range(2000)), {}, "scattered"),
    "no picture": ("a.png", b"this is no picture", {}, "no picture"),
    "cut picture": ("a.png", _png("L")[:45], PIXELS, "cannot be read"),
    "colours": ("a.png", _png("RGB", color=(9, 8, 7)), {}, "in colours"),
    "pages": ("a.tif", _pages(), {}, "2 pages"),
    "no scale": ("a.png", _png("L"), {}, "scale of its pixels is nowhere"),
    "no calibration": ("a.png", _png("L"), PIXELS, "what its greys mean"),
    "no array file": ("a.mat", b"nothing of the kind", {}, "no NetCDF and no .mat"),
    "cut array file": ("a.mat", _mat(a=np.ones((50, 60)))[:200], {}, "cannot be read"),
    "two maps": ("a.mat", _mat(a=np.ones((3, 4)), b=np.ones((3, 4))), {}, "2 arrays of two dimensions"),
    "no axes": ("a.mat", _mat(a=np.ones((3, 4))), {}, "holds the times cannot be told"),
    "axis of another length": ("a.mat", _mat(a=np.ones((3, 4)), t=np.arange(5.0), x=np.arange(4.0)), {}, "is missing"),
}  # fmt: skip


@pytest.mark.parametrize("what", MALFORMED)
def test_malformed_files_are_one_sentence(what: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Value, cause and fix, and nothing of a library's own."""
    name, content, options, said = MALFORMED[what]
    monkeypatch.chdir(tmp_path)
    file = Path(name)
    file.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(ConfigurationError) as caught:
        maps.read(file, **options)
    sentence = str(caught.value)
    assert said in sentence
    assert "\n" not in sentence
    assert len(sentence) < 400
    assert ";" in sentence, "it says what to do"
    assert name in sentence or sentence.startswith("a")


def _raises(call: Callable[[], object], said: str, kind: type[Exception] = ConfigurationError) -> None:
    with pytest.raises(kind, match=said):
        call()


def test_what_is_asked_wrongly_is_said(small: maps.Map, tmp_path: Path) -> None:
    _raises(lambda: maps.read(tmp_path / "none.csv"), "cannot be read: No such file")
    _raises(lambda: maps.read(tmp_path / "none.csv", quantiti="x"), "did you mean quantity")
    _raises(lambda: maps.read(tmp_path / "none.csv", oral="left"), "first or the last")
    _raises(lambda: maps.write(small, tmp_path / "map.jpg"), "written to .csv")
    _raises(lambda: maps.write(small, tmp_path / "map.tif", bits=12), "8 or 16")
    (tmp_path / "file").write_text("", encoding="utf-8")
    _raises(lambda: maps.write(small, tmp_path / "file" / "map.csv"), "could not write", WriteError)
    uneven = maps.Map(np.ones((2, 3)), np.arange(2.0), np.array([0.0, 1.0, 5.0]), "pressure")
    _raises(lambda: maps.write(uneven, tmp_path / "map.tif"), "resample it first")
    _raises(lambda: small.part(times=(500.0, 600.0)), "choose a span within")
    _raises(lambda: maps.resampled(small, -1.0), "must be above 0")


def test_gaps_are_filled_in_for_the_reader_alone(tmp_path: Path) -> None:
    """Empty cells at the beginning, in the middle and at the end of rows, with any ends of lines."""
    (tmp_path / "a.csv").write_bytes(AXES.encode() + b"0,1,2\r\n0,,1,\r\n1,2,,\r\n2,,,3\r\n")
    found = numbers(table_of(tmp_path / "a.csv"))
    wanted = [[0.0, np.nan, 1.0, np.nan], [1.0, 2.0, np.nan, np.nan], [2.0, np.nan, np.nan, 3.0]]
    assert found == pytest.approx(np.array(wanted), nan_ok=True)


def test_floats_of_single_precision_stay(tmp_path: Path) -> None:
    whole = example()[0].part(times=(0.0, 5.0))
    half = whole.done("single", values=whole.values.astype(np.float32))
    for name in ("a.nc", "a.mat"):
        assert maps.read(maps.write(half, tmp_path / name)).values.dtype == np.float32
    assert maps.read(maps.write(half, tmp_path / "a.csv")).fingerprint() == half.fingerprint()


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("a.csv", {"positions": [1.0, 2.0], "variable": "none", "grey": ((0, 5.0), (255, 20.0)), "time": "down"}),
        ("b.nc", {"positions": [1.0], "mm_per_px": 2.0}),
        ("c.tif", {"variable": "none", "time_unit": "min"}),
    ],
)
def test_what_a_file_has_no_use_for_is_said(small: maps.Map, tmp_path: Path, name: str, options: dict) -> None:
    back = maps.read(maps.write(small, tmp_path / name), **options)
    for key in options:
        assert any(line.startswith(key) and line.endswith("not used") for line in back.history), key
    assert not any(line.endswith("not used") for line in maps.read(tmp_path / name).history)
