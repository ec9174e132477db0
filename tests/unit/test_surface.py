"""Surfaces: unrolled maps, VTK series read back by a reader of their own, and pictures in space."""

from __future__ import annotations

import base64
import importlib.util
import struct
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
import zlib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from unit.synthetic import SPEED, around

import peristalsis as ps
from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.inputs.recording import ALWAYS, CHOICES, chosen, planned
from peristalsis.names import FIELDS, OF_NETWORK
from peristalsis.plots import Plots, data, scene, surface, unrolled
from peristalsis.plots.export import export_vtk
from peristalsis.plots.figures import activation_maps, surface_maps
from peristalsis.plots.vtk_files import BLOCK, write_polygons

COLUMNS = 16
SMALL = {
    "step.wall": "2 ms",
    "step.conduction": "0.25 ms",
    "grid.n_z": 100,
    "grid.n_z_wall": 60,
    "run.duration": "0.2 s",
    "output.interval": "0.05 s",
}


@pytest.fixture(scope="module")
def run() -> ps.Result:
    return ps.run("baseline", SMALL)


@pytest.fixture(scope="module")
def wide(run: ps.Result) -> ps.Result:
    return around(run, COLUMNS)


# --- unrolled maps ----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["activation_maps", "surface_maps"])
@pytest.mark.parametrize("columns", [1, 2, COLUMNS])
def test_maps_draw_for_any_number_of_columns(run: ps.Result, name: str, columns: int) -> None:
    figure = (run if columns == 1 else around(run, columns)).plot.draw(name)
    figure.draw_without_rendering()
    words = " ".join([figure._suptitle.get_text(), *(axes.get_title(loc="left") for axes in figure.axes)])
    assert ("uniform around the ring" in words) == (columns == 1)


def test_maps_show_every_column_of_the_stored_field(wide: ps.Result) -> None:
    mesh = wide.plot.surface_maps(time=0.1).axes[5].collections[0]
    shown = np.asarray(mesh.get_array()).reshape(COLUMNS + 1, -1)
    frame = data.frames_at(wide, [0.1])[0]
    assert np.array_equal(shown[:-1], 10.0 * wide.arrays["radius"][frame].T)
    assert np.array_equal(shown[-1], shown[0])  # the ring closes


def test_diameters_are_those_of_the_ring_and_not_of_a_column(wide: ps.Result, run: ps.Result) -> None:
    """A ring r(1 + e cos) holds the area of a circle of radius r sqrt(1 + e^2/2), whatever one column shows."""
    z = run.arrays["z"]
    bulge = 0.2 * np.sin(np.pi * z / z[-1])
    expected = data.values(run, "radius", "mm") * 2.0 * np.sqrt(1.0 + 0.5 * bulge**2)
    assert data.ring_diameter(wide) == pytest.approx(expected, rel=0.02)
    assert data.ring_diameter(run) == pytest.approx(2.0 * data.values(run, "radius", "mm"))
    assert np.abs(data.values(wide, "radius", "mm") * 2.0 - expected).max() > 1.0


def test_a_cut_shows_both_sides(wide: ps.Result, run: ps.Result) -> None:
    up, down = data.profile(wide)
    straight = data.values(run, "radius", "mm")
    middle = run.arrays["z"].size // 2
    assert (up[:, middle] > 1.1 * straight[:, middle]).all()
    assert (-down[:, middle] < 0.9 * straight[:, middle]).all()
    assert np.array_equal(data.profile(run)[1], -straight)


def test_manometry_is_the_mean_around_the_ring(run: ps.Result, wide: ps.Result) -> None:
    share = 1.0 + np.cos(wide.arrays["theta"])
    sided = replace(wide, arrays=wide.arrays | {"contact_pressure": wide.arrays["contact_pressure"] * share})
    assert data.manometry(sided, 2.5)[2] == pytest.approx(data.manometry(run, 2.5)[2])


def test_the_hardest_contact_is_shown_unless_asked_otherwise(run: ps.Result) -> None:
    frame = surface_maps.default_frame(run)
    assert data.at_frames(run, "normal_force")[frame] == data.at_frames(run, "normal_force").max()


@pytest.mark.parametrize("columns", [64, 128])
def test_velocity_of_a_round_front_is_radial_and_has_its_speed(run: ps.Result, columns: int) -> None:
    """Away from the point of origin and from the line where the two sides of the ring meet."""
    result = around(run, columns, centre=(5.0, 180.0))
    times, radius = result.arrays["activation_circular"], result.configuration.wall.radius
    places, around_ring = np.array([15, 30, 70, 85]), np.arange(columns // 4, 3 * columns // 4, 5)
    along, across = unrolled.front_velocity(times, 0.1, radius, places, around_ring, 2)
    z = result.arrays["z_cell"][places][:, None] - 5.0
    s = radius * (2.0 * np.pi * around_ring / columns - np.pi)[None, :]
    assert np.hypot(along, across) == pytest.approx(SPEED, rel=0.02)
    assert along == pytest.approx(SPEED * z / np.hypot(z, s), rel=0.02)
    assert across == pytest.approx(SPEED * s / np.hypot(z, s), rel=0.05, abs=0.05)


def test_velocity_crosses_the_cut_of_the_map(run: ps.Result) -> None:
    result = around(run, 64, centre=(5.0, 0.0))
    times, radius = result.arrays["activation_circular"], result.configuration.wall.radius
    along, across = unrolled.front_velocity(times, 0.1, radius, np.array([70]), np.array([63, 0, 1]), 2)
    assert along[0] == pytest.approx(SPEED, rel=0.01)
    assert across[0, 0] == pytest.approx(-across[0, 2], rel=1e-9)
    assert across[0, 1] == pytest.approx(0.0, abs=1e-9)


def test_there_is_no_velocity_where_nothing_spreads() -> None:
    times = np.full((20, 4), 0.3)
    times[10:] = np.nan
    along, across = unrolled.front_velocity(times, 0.1, 0.8, np.array([4, 15]), np.array([0, 2]), 2)
    assert np.isnan(along).all()
    assert np.isnan(across).all()


def test_a_run_of_one_column_has_the_speed_of_its_wave() -> None:
    """Arrows and the recorded speed are two ways to the same number."""
    result = ps.run(
        "baseline",
        {
            **SMALL,
            "grid.n_z": 300,
            "run.duration": "2.5 s",
            "pellet.enabled": False,
            "longitudinal.active": 0.0,
            "circular.active": 0.0,
        },
    )
    times = result.arrays["activation_longitudinal"]
    along, across = unrolled.front_velocity(times, 10.0 / 300, 0.795, np.arange(100, 230, 10), np.array([0]), 5)
    assert along == pytest.approx(result.summary["wave_speed_cm_s"]["longitudinal"], rel=0.02)
    assert (across == 0.0).all()


def test_a_layer_that_was_never_activated_says_so(wide: ps.Result) -> None:
    never = np.full_like(wide.arrays["activation_circular"], np.nan)
    figure = replace(wide, arrays={**wide.arrays, "activation_circular": never}).plot.activation_maps()
    assert "not activated" in [text.get_text() for text in figure.axes[1].texts]
    assert activation_maps.norm_of(wide).vmin < activation_maps.norm_of(wide).vmax


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.87), (0.013, 0.0131), (3.0, 250.0), (1.0, 1.0)])
def test_isochrones_are_round_and_inside(low: float, high: float) -> None:
    levels = unrolled.even(low, high, 10)
    assert ((levels > low) & (levels < high)).all()
    if high > low:
        assert 4 <= levels.size <= 10
        step = levels[1] - levels[0]
        assert np.allclose(levels / step, np.round(levels / step))


# --- surfaces ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("facets", [24, 96])
def test_a_uniform_wall_is_revolved(run: ps.Result, facets: int) -> None:
    part = surface.wall(run, 2, facets)
    assert part.points.shape == (61 * facets, 3)
    assert np.allclose(np.hypot(part.points[:, 0], part.points[:, 1]), np.repeat(run.arrays["radius"][2][:, 0], facets))
    assert np.allclose(part.points[:, 2], np.repeat(run.arrays["axial_position"][2][:, 0], facets))


def test_points_of_many_columns_are_the_stored_ones(wide: ps.Result) -> None:
    part = surface.wall(wide, 3)
    radius, angle = wide.arrays["radius"][3], wide.arrays["angle"][3]
    assert np.allclose(part.points[:, 0], (radius * np.cos(angle)).ravel())
    assert np.allclose(part.points[:, 1], (radius * np.sin(angle)).ravel())
    assert np.array_equal(part.fields["contact_pressure [kPa]"], wide.arrays["contact_pressure"][3].ravel())


@pytest.mark.parametrize("part", ["wall", "pellet"])
def test_facets_close_the_ring_and_look_outward(wide: ps.Result, part: str) -> None:
    """Every edge within the surface belongs to two facets; volumes by the divergence theorem are positive."""
    shape = surface.wall(wide, 0) if part == "wall" else surface.pellet(wide, 0, 96, 192)
    edges: dict[tuple[int, int], int] = {}
    for quad in shape.quads.tolist():
        for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
            edges[min(a, b), max(a, b)] = edges.get((min(a, b), max(a, b)), 0) + 1
    columns = COLUMNS if part == "wall" else 192
    assert sorted(edges.values()).count(1) == 2 * columns  # the two ends, which are poles of the pellet
    assert set(edges.values()) == {1, 2}
    p = shape.points[shape.quads]
    sixth = np.einsum("ij,ij->i", p[:, 0], np.cross(p[:, 1], p[:, 2])) + np.einsum(
        "ij,ij->i", p[:, 0], np.cross(p[:, 2], p[:, 3])
    )
    if part == "pellet":
        centre = wide.arrays["pellet_position"][0]
        assert shape.points[:, 2].mean() == pytest.approx(centre)
        assert sixth.sum() / 6.0 == pytest.approx(4.0 / 3.0 * np.pi * 0.9**3, rel=2e-3)
    else:
        normal = np.cross(p[:, 1] - p[:, 0], p[:, 3] - p[:, 0])
        assert (np.einsum("ij,ij->i", normal[:, :2], p[:, 0, :2]) > 0.0).mean() > 0.95


def test_fields_of_the_cells_come_to_the_nodes(run: ps.Result) -> None:
    """Linear along the tube; a conduction grid of other columns is interpolated around the closed ring."""
    z, cells = run.arrays["z"], run.arrays["z_cell"]
    values = np.repeat((3.0 * cells - 60.0)[None, :, None], 5, axis=0)
    part = surface.wall(replace(run, arrays={**run.arrays, "potential_circular": values}), 0, 8)
    inside = (z > cells[0]) & (z < cells[-1])
    got = part.fields["potential_circular [mV]"].reshape(-1, 8)
    assert np.allclose(got[inside], (3.0 * z - 60.0)[inside][:, None])
    wide = around(run, 4)
    fine = np.cos(2.0 * np.pi * np.arange(8) / 8) * np.ones((5, 100, 1))
    got = surface.wall(replace(wide, arrays={**wide.arrays, "potential_circular": fine}), 0).fields
    assert np.allclose(got["potential_circular [mV]"].reshape(-1, 4), [1.0, 0.0, -1.0, 0.0], atol=1e-12)


# --- VTK files --------------------------------------------------------------------------------------


def read_polygons(path: Path) -> tuple[dict[str, Any], np.ndarray, np.ndarray]:
    """A reader written from the format's description alone: point data, points, connectivity (k, corners)."""
    root = ElementTree.parse(path).getroot()
    assert (root.get("type"), root.get("byte_order"), root.get("header_type")) == ("PolyData", "LittleEndian", "UInt64")
    assert root.get("compressor") == "vtkZLibDataCompressor"
    (piece,) = root.iter("Piece")

    def decoded(node: ElementTree.Element) -> np.ndarray:
        text = (node.text or "").strip()
        (count,) = struct.unpack("<Q", base64.b64decode(text[:12])[:8])
        length = 4 * -(-8 * (3 + count) // 3)
        _, size, last, *packed = struct.unpack(f"<{3 + count}Q", base64.b64decode(text[:length])[: 8 * (3 + count)])
        content, blocks, at = base64.b64decode(text[length:]), [], 0
        for number, length in enumerate(packed):
            block = zlib.decompress(content[at : at + length])
            assert len(block) == (last if number == count - 1 and last else size)
            blocks.append(block)
            at += length
        assert at == len(content)
        kind = {"Float32": "<f4", "Int64": "<i8"}[str(node.get("type"))]
        values = np.frombuffer(b"".join(blocks), kind)
        components = int(node.get("NumberOfComponents", "1"))
        return values.reshape(-1, components) if components > 1 else values

    def arrays(name: str) -> dict[str, np.ndarray]:
        (section,) = piece.iter(name)
        return {str(node.get("Name")): decoded(node) for node in section}

    (points,) = arrays("Points").values()
    polygons = arrays("Polys")
    corners = np.diff(polygons["offsets"], prepend=0)
    assert points.shape == (int(piece.get("NumberOfPoints", "0")), 3)
    assert corners.size == int(piece.get("NumberOfPolys", "0"))
    assert np.unique(corners).size == 1
    fields = arrays("PointData")
    assert all(len(values) == len(points) for values in fields.values())
    return fields, points, polygons["connectivity"].reshape(-1, corners[0])


def read_series(path: Path) -> list[tuple[float, Path]]:
    root = ElementTree.parse(path).getroot()
    assert root.get("type") == "Collection"
    return [(float(str(node.get("timestep"))), path.parent / str(node.get("file"))) for node in root.iter("DataSet")]


@pytest.mark.parametrize("columns", [1, COLUMNS])
def test_a_series_holds_what_the_run_stored(run: ps.Result, wide: ps.Result, tmp_path: Path, columns: int) -> None:
    result = run if columns == 1 else wide
    assert export_vtk(result, tmp_path, facets=12) == [tmp_path / "wall.pvd", tmp_path / "pellet.pvd"]
    series = read_series(tmp_path / "wall.pvd")
    assert [time for time, _ in series] == result.arrays["time"].tolist()
    for frame, (_, file) in enumerate(series):
        fields, points, quads = read_polygons(file)
        expected = surface.wall(result, frame, 12)
        assert np.allclose(points, expected.points, rtol=1e-6, atol=1e-6)
        assert np.array_equal(quads, expected.quads)
        assert fields.keys() == expected.fields.keys()
        for name, values in fields.items():
            assert np.array_equal(values, expected.fields[name].astype(np.float32)), name
    for time, file in read_series(tmp_path / "pellet.pvd"):
        fields, points, _ = read_polygons(file)
        place = np.interp(time, result.arrays["time_step"], result.arrays["pellet_position"])
        assert points[:, 2].mean() == pytest.approx(place, abs=1e-5)
        assert np.hypot(np.hypot(points[:, 0], points[:, 1]), points[:, 2] - place) == pytest.approx(0.9, abs=1e-5)
        assert fields["velocity [cm/s]"].shape == points.shape


def test_names_of_arrays_carry_their_units(wide: ps.Result) -> None:
    names = set(surface.wall(wide, 0).fields)
    assert {"radius [cm]", "stretch_longitudinal", "tension_circumferential [mN/cm]", "contact_pressure [kPa]"} <= names
    # All but two of the places, which are the points; there is no network.
    assert len(names) == len(FIELDS) - 2 - len(OF_NETWORK)


def test_blocks_larger_than_one_are_put_together_again(tmp_path: Path) -> None:
    count = BLOCK // 4 + 1000
    points = np.random.default_rng(1).random((count, 3))
    field = np.arange(count, dtype=float)
    write_polygons(tmp_path / "a.vtp", points, np.array([[0, 1, 2, 3]]), {'odd "name" <&>': field})
    fields, read, _ = read_polygons(tmp_path / "a.vtp")
    assert np.array_equal(read, points.astype(np.float32))
    assert np.array_equal(fields['odd "name" <&>'], field.astype(np.float32))


def test_a_shorter_series_leaves_nothing_of_a_longer_one_and_other_files_alone(run: ps.Result, tmp_path: Path) -> None:
    export_vtk(run, tmp_path, facets=3)
    (tmp_path / "wall" / "mine.vtp").write_text("mine")
    export_vtk(run, tmp_path, frames=2, facets=3)
    assert len(read_series(tmp_path / "wall.pvd")) == 2
    assert sorted(file.name for file in (tmp_path / "wall").iterdir()) == ["mine.vtp", "wall_0000.vtp", "wall_0001.vtp"]


def test_what_cannot_be_exported_is_said(run: ps.Result, tmp_path: Path) -> None:
    for options in ({"frames": 0}, {"facets": 2}, {"facets": 10**6}):
        with pytest.raises(ConfigurationError, match="give 1 to"):
            export_vtk(run, tmp_path / "a", **options)
    (tmp_path / "here").write_text("a file")
    with pytest.raises(WriteError, match="could not write VTK files"):
        export_vtk(run, tmp_path / "here")


@pytest.mark.slow
@pytest.mark.skipif(importlib.util.find_spec("vtk") is None, reason="the library that reads VTK files is not here")
def test_the_reader_of_the_library_agrees(wide: ps.Result, tmp_path: Path) -> None:
    """In a process of its own: the library is loud, and may end a process that has no screen."""
    export_vtk(wide, tmp_path)
    code = (
        "import sys, numpy as np; from vtkmodules.vtkIOXML import vtkXMLPolyDataReader as R\n"
        "from vtkmodules.util.numpy_support import vtk_to_numpy as n\n"
        "r = R(); r.SetFileName(sys.argv[1]); r.Update(); p = r.GetOutput(); d = p.GetPointData()\n"
        "a = {d.GetArrayName(k): n(d.GetArray(k)) for k in range(d.GetNumberOfArrays())}\n"
        "np.savez(sys.argv[2], points=n(p.GetPoints().GetData()), quads=n(p.GetPolys().GetConnectivityArray()), **a)\n"
    )
    _, file = read_series(tmp_path / "wall.pvd")[2]
    command = [sys.executable, "-c", code, str(file), str(tmp_path / "read.npz")]
    subprocess.run(command, check=True, capture_output=True, timeout=300)
    read = np.load(tmp_path / "read.npz")
    expected = surface.wall(wide, 2)
    assert np.array_equal(read["points"], expected.points.astype(np.float32))
    assert np.array_equal(read["quads"].reshape(-1, 4), expected.quads)
    assert set(read.files) == {"points", "quads", *expected.fields}
    for name, values in expected.fields.items():
        assert np.array_equal(read[name], values.astype(np.float32)), name


# --- pictures in space ------------------------------------------------------------------------------


class Done:
    """A process that has ended."""

    def __init__(self, code: int, said: str = "") -> None:
        self.returncode, self.stderr = code, said


@pytest.mark.parametrize(
    ("done", "said"),
    [
        (Done(1, "Traceback\nModuleNotFoundError: No module named 'pyvista'\n"), r"pip install pyvista"),
        (Done(1, "ImportError: libGL.so.1: cannot open shared object file"), r"\(ImportError: libGL.so.1.*libgl1"),
        (Done(-11), r"\(signal 11\).*VTK export"),
        (Done(3), "draws an empty picture"),
    ],
)
def test_missing_libraries_are_reported_never_met(
    run: ps.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, done: Done, said: str
) -> None:
    monkeypatch.setattr(scene.subprocess, "run", lambda *_, **__: done)
    scene.problem.cache_clear()
    try:
        with pytest.raises(ConfigurationError, match=said) as caught:
            run.plot.scene(tmp_path / "scene.png")
    finally:
        scene.problem.cache_clear()
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_a_library_that_hangs_is_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    def hang(*_: object, **__: object) -> None:
        raise subprocess.TimeoutExpired("python", scene.PROBE_SECONDS)

    monkeypatch.setattr(scene.subprocess, "run", hang)
    scene.problem.cache_clear()
    try:
        assert "did not answer" in str(scene.problem())
    finally:
        scene.problem.cache_clear()


def test_scenes_that_make_no_sense_are_refused_before_any_library_is_tried(
    run: ps.Result, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(scene, "problem", lambda: pytest.fail("the library was tried"))
    with pytest.raises(ConfigurationError, match=r"\.png, \.gif or \.mp4"):
        run.plot.scene(tmp_path / "a.jpg")
    with pytest.raises(ConfigurationError, match="did you mean contact_pressure"):
        run.plot.scene(tmp_path / "a.png", colour="contact_presure")
    with pytest.raises(ConfigurationError, match="give 2 to 2000"):
        run.plot.scene(tmp_path / "a.gif", frames=1)


@pytest.mark.slow
@pytest.mark.parametrize("columns", [1, COLUMNS])
def test_a_picture_shows_wall_and_pellet(run: ps.Result, tmp_path: Path, columns: int) -> None:
    if scene.problem() is not None:
        pytest.skip(str(scene.problem()))
    from PIL import Image

    result = run if columns == 1 else around(run, columns)
    with Image.open(result.plot.scene(tmp_path / "scene.png", time=0.1, colour="radius")) as picture:
        pixels = np.asarray(picture.convert("RGB")).astype(int)
    assert pixels.shape == (scene.SIZE[1], scene.SIZE[0], 3)
    drawn = (pixels.min(axis=2) < 250).any(axis=0)
    assert 0.8 < drawn.mean() <= 1.0  # the tube fills the picture from side to side
    middle = pixels[scene.SIZE[1] // 2]
    pellet = (np.ptp(middle, axis=1) < 12) & (middle.max(axis=1) < 240)  # grey, where the wall is coloured
    centre = np.flatnonzero(pellet).mean() / scene.SIZE[0]
    assert 0.05 < centre < 0.3  # at 1.2 of 10 cm, the oral end at the left


@pytest.mark.slow
def test_a_film_in_space_has_its_frames(run: ps.Result, tmp_path: Path) -> None:
    if scene.problem() is not None:
        pytest.skip(str(scene.problem()))
    from PIL import Image

    with Image.open(run.plot.scene(tmp_path / "scene.gif", frames=3)) as film:
        assert film.n_frames == 3


class Mesh:
    """A surface as the graphics library holds it."""

    def __init__(self, points: Any, faces: Any) -> None:
        self.points, self.faces, self.point_data = points, faces, dict[str, Any]()
        self.center = tuple(0.5 * (points.min(axis=0) + points.max(axis=0)))

    def scale(self, factor: float, point: tuple[float, ...]) -> Mesh:
        middle = np.asarray(point)
        return Mesh(middle + factor * (self.points - middle), self.faces)


class Plotter:
    """A plotter that keeps what it is told; a frame's picture is grey, with a band as wide as its number."""

    def __init__(self, off_screen: bool, window_size: list[int], lighting: str) -> None:
        self.off_screen, self.size, self.closed = off_screen, window_size, False
        self.meshes: list[dict[str, Mesh]] = [{}]
        self.options: dict[str, dict[str, Any]] = {}
        self.texts: list[str] = []
        self.camera = SimpleNamespace()

    def set_background(self, colour: str) -> None:
        self.background = colour

    def add_mesh(self, mesh: Mesh, name: str, **options: Any) -> None:
        self.meshes[-1][name], self.options[name] = mesh, options

    def add_text(self, text: str, **options: Any) -> None:
        self.texts.append(text)

    def screenshot(self, return_img: bool) -> Any:
        self.meshes.append({})
        picture = np.full((self.size[1], self.size[0], 3), 215, np.uint8)
        picture[: 9 * len(self.texts)] = 40
        return picture

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def plotters(monkeypatch: pytest.MonkeyPatch) -> list[Plotter]:
    """All plotters that are made of a graphics library that stands in for the real one."""
    made: list[Plotter] = []

    def plotter(**options: Any) -> Plotter:
        made.append(Plotter(**options))
        return made[-1]

    library = SimpleNamespace(Plotter=plotter, PolyData=Mesh, vtk_verbosity=lambda level: None)
    monkeypatch.setitem(sys.modules, "pyvista", library)  # type: ignore[arg-type]
    monkeypatch.setattr(scene, "problem", lambda: None)
    return made


def test_picture_is_of_the_time_asked_for(run: ps.Result, tmp_path: Path, plotters: list[Plotter]) -> None:
    """The wall without the quarter before the camera, the pellet a hundredth smaller at its place, both in words."""
    from PIL import Image

    with Image.open(run.plot.scene(tmp_path / "new" / "scene.png", time=0.1, colour="radius")) as picture:
        assert picture.size == scene.SIZE
        assert [picture.getpixel((0, row)) for row in (8, 9)] == [(40,) * 3, (215,) * 3]
    assert [file.name for file in (tmp_path / "new").iterdir()] == ["scene.png"]
    (plotter,) = plotters
    assert plotter.off_screen
    assert plotter.closed
    frame = data.frames_at(run, [0.1])[0]
    wall, pellet = plotter.meshes[0]["wall"], plotter.meshes[0]["pellet"]
    whole = surface.wall(run, frame)
    corners = wall.faces.reshape(-1, 5)
    assert np.all(corners[:, 0] == 4)
    assert len(corners) == pytest.approx((1.0 - scene.CUT / 360.0) * len(whole.quads), rel=0.03)
    middle = wall.points[corners[:, 1:]].mean(axis=1)
    turn = np.rad2deg(np.arctan2(middle[:, 1], middle[:, 0]))
    assert not np.any((turn > 20.0) & (turn < 100.0)), "nothing is left between the camera and the pellet"
    assert np.array_equal(wall.point_data["radius [cm]"], whole.fields["radius [cm]"])
    radius = run.configuration.pellet.radius
    assert np.ptp(pellet.points[:, 2]) == pytest.approx(0.99 * 2.0 * radius)
    assert pellet.center[2] == pytest.approx(data.at_frames(run, "pellet_position")[frame])
    assert plotter.options["wall"]["scalars"] == "radius [cm]"
    shown = run.arrays["radius"]
    assert plotter.options["wall"]["clim"] == pytest.approx((shown.min(), shown.max()))
    assert plotter.texts == [f"baseline, t = {run.arrays['time'][frame]:.2f} s; oral end left, 10 cm"]


@pytest.mark.parametrize(
    ("colour", "map_"), [("stretch_circumferential", "RdBu"), ("active_tension_longitudinal", "viridis")]
)
def test_stretches_diverge_from_the_undeformed_length(
    run: ps.Result, tmp_path: Path, plotters: list[Plotter], colour: str, map_: str
) -> None:
    """Colours of a stretch lie as far on either side of one as it goes; by default at the hardest contact."""
    run.plot.scene(tmp_path / "scene.png", colour=colour)
    options = plotters[0].options["wall"]
    low, high = options["clim"]
    assert options["cmap"] == map_
    values = run.arrays[colour]
    if colour.startswith("stretch"):
        assert (1.0 - low, high - 1.0) == pytest.approx([np.abs(values - 1.0).max()] * 2)
    else:
        assert (low, high) == pytest.approx((values.min(), max(values.max(), values.min() + 1e-6)))
    frame = surface_maps.default_frame(run)
    assert f"t = {run.arrays['time'][frame]:.2f} s" in plotters[0].texts[0]


def test_film_in_space_is_of_one_camera(wide: ps.Result, tmp_path: Path, plotters: list[Plotter]) -> None:
    """All frames with one plotter of half the size; the scale of colours stays."""
    from PIL import Image

    with Image.open(wide.plot.scene(tmp_path / "scene.gif", frames=3, rate=10)) as film:
        assert film.n_frames == 3
        assert film.size == (scene.SIZE[0] // 2, scene.SIZE[1] // 2)
    (plotter,) = plotters
    times = [wide.arrays["time"][frame] for frame in data.spread_frames(wide, 3)]
    assert [text.split("t = ")[1][:4] for text in plotter.texts] == [f"{time:.2f}" for time in times]
    places = [frame["pellet"].center[2] for frame in plotter.meshes[:-1]]
    assert places == pytest.approx(data.at_frames(wide, "pellet_position")[data.spread_frames(wide, 3)])


def test_scene_without_pellet_has_a_wall(run: ps.Result, tmp_path: Path, plotters: list[Plotter]) -> None:
    bare = replace(run, configuration=run.configuration.with_changes({"pellet.enabled": False}))
    assert not data.has_pellet(bare)
    bare.plot.scene(tmp_path / "scene.png")
    assert set(plotters[0].meshes[0]) == {"wall"}


def test_scene_that_cannot_be_written_says_so(run: ps.Result, tmp_path: Path, plotters: list[Plotter]) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(WriteError, match="choose another place"):
        run.plot.scene(tmp_path / "file" / "scene.png")
    assert plotters[0].closed


def test_a_library_that_can_draw_is_used(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(scene.subprocess, "run", lambda *_, **__: Done(0))
    scene.problem.cache_clear()
    try:
        assert scene.problem() is None
    finally:
        scene.problem.cache_clear()


# --- what is stored ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "fields", [(), ("contact_pressure",), ("potential_circular", "stretch_longitudinal"), ("all",)]
)
def test_only_the_chosen_fields_are_stored_and_their_size_is_as_planned(fields: tuple[str, ...]) -> None:
    result = ps.run("baseline", {**SMALL, "output.fields": list(fields)})
    stored = {output.name for output in FIELDS if output.name in result.arrays}
    assert stored == set(chosen(fields))
    assert stored >= set(ALWAYS)
    recorded = sum(
        values.nbytes
        for name, values in result.arrays.items()
        if values.ndim
        and ps_dimensions(name)[0] in ("time", "time_step")
        and len(ps_dimensions(name)) > (name in ("time", "time_step"))
    )
    expected = planned(0.2, 0.05, 0.002, 61, 100, 1, fields)
    assert expected.size == pytest.approx(recorded, rel=0.25)  # one more time, and numbers in whole
    assert expected.fields == chosen(fields)


def ps_dimensions(name: str) -> tuple[str, ...]:
    from peristalsis.names import OUTPUTS

    return OUTPUTS[name].dimensions


def test_stored_frames_keep_nothing_else_alive(run: ps.Result) -> None:
    """A slice of the state would keep the arrays it is cut from."""
    from peristalsis.running.observers import FieldRecorder

    simulation = ps.Simulation(ps.configuration("baseline", changes=SMALL))
    recorder = FieldRecorder(1, ("calcium_circular", "radius"))
    recorder.start(simulation.model, simulation.state)
    assert all(frames[0].base is None for frames in recorder.frames.values())


@pytest.mark.parametrize("left_out", CHOICES[1:])
def test_figures_without_their_fields_say_so_and_all_others_draw(run: ps.Result, left_out: str) -> None:
    short = replace(run, arrays={name: values for name, values in run.arrays.items() if name != left_out})
    offered = set(short.plot.available())
    for name in sorted(set(Plots.names()) - offered):
        with pytest.raises(ConfigurationError, match=rf"{left_out} was not stored.*output\.fields"):
            short.plot.draw(name)


def test_every_figure_that_is_offered_draws_from_what_is_stored(run: ps.Result) -> None:
    bare = replace(run, arrays={name: values for name, values in run.arrays.items() if name not in CHOICES})
    assert {"diameter_map", "track", "activation_maps"} <= set(bare.plot.available()) < set(Plots.names())
    for name in bare.plot.available():
        assert bare.plot.draw(name).axes, name
    assert "radius [cm]" in surface.wall(bare, 0).fields


def test_sizes_are_said_in_words() -> None:
    words = planned(10.0, 0.01, 0.002, 801 * 64, 1000 * 64, 1, ("all",)).words()
    assert words == "recording 16 fields at up to 1002 times, about 6.99 GB"
    assert "potential_circular" not in planned(1.0, 0.01, 0.002, 10, 10, 0, ()).fields
