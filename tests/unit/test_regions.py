"""Regions of tissue: from a file to fields on any grid, back without loss, and refused in one line."""

from __future__ import annotations

import contextlib
import math
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from peristalsis.errors import ConfigurationError, UnknownKeyError
from peristalsis.inputs import preflight
from peristalsis.inputs.build import build
from peristalsis.inputs.config import Configuration
from peristalsis.inputs.regions import QUANTITIES, Region, check, read, varies_around
from peristalsis.inputs.regions.sampling import coverage, factor_field
from peristalsis.model.initial import initial_state
from peristalsis.model.schemes.column import muscle_drive
from peristalsis.model.step import advance
from peristalsis.tissue.cells.plant import CHANNELS

RADIUS = 0.795
COARSE = {"grid.n_z": 100, "grid.n_z_wall": 60}
Z = (np.arange(200) + 0.5) * 0.05
ANGLES = 2.0 * np.pi * np.arange(96) / 96

BAND = {"name": "segment", "shape": "band", "z_from": "4 cm", "z_to": "6 cm"}
BOX = {
    "name": "window",
    "shape": "box",
    "z_from": "4 cm",
    "z_to": "6 cm",
    "angle_from": "350 deg",
    "angle_to": "20 deg",
}
DISC = {"name": "patch", "shape": "disc", "z": "5 cm", "angle": "0 deg", "radius": "8 mm"}
STRIPES = {"name": "taeniae", "shape": "stripes", "number": 3, "width": "6 mm", "phase": "30 deg"}
MAP = {
    "name": "graded",
    "shape": "map",
    "quantities": ["active"],
    "z": ["2 cm", "4 cm"],
    "angle": ["0 deg", "180 deg"],
    "values": [[1.0, 0.0], [0.5, 0.5]],
}


def field(*tables: dict[str, Any], quantity: str = "active", layer: str = "circular") -> Any:
    return factor_field(read(list(tables)), layer, quantity, Z, ANGLES, RADIUS)


def at(values: Any, z: float, degrees: float) -> float:
    """The value of the cell that is nearest to a place."""
    turn = np.abs((ANGLES - math.radians(degrees) + np.pi) % (2 * np.pi) - np.pi)
    return float(values[np.argmin(np.abs(Z - z)), np.argmin(turn)])


# --- shapes -----------------------------------------------------------------------------------------


def test_a_band_is_the_whole_ring_between_two_places() -> None:
    values = field(BAND | {"active": 0.25})
    inside = (Z > 4.0) & (Z < 6.0)
    assert (values[inside] == 0.25).all()
    assert (values[~inside] == 1.0).all()


def test_a_box_crosses_the_angle_zero() -> None:
    values = field(BOX | {"active": 0.0})
    assert [at(values, 5.0, angle) for angle in (345.0, 352.5, 0.0, 18.75, 22.5, 180.0)] == [1, 0, 0, 0, 1, 1]
    assert at(values, 3.9, 0.0) == 1.0
    share = (values == 0.0).mean()
    assert share == pytest.approx(2.0 / 10.0 * 30.0 / 360.0, rel=0.1)


def test_a_box_of_the_whole_ring_is_a_band() -> None:
    whole = BOX | {"angle_from": "0 deg", "angle_to": "360 deg", "active": 0.5}
    assert np.array_equal(field(whole), field(BAND | {"active": 0.5}))


@pytest.mark.parametrize("angle", ["0 deg", "90 deg", "-45 deg"])
def test_a_disc_has_its_area_wherever_it_lies(angle: str) -> None:
    """Measured along the undeformed surface: pi 0.8^2 of 2 pi 0.795 x 10 cm^2, across the angle 0 as elsewhere."""
    values = field(DISC | {"angle": angle, "active": 0.0})
    area = (values == 0.0).mean() * 2.0 * np.pi * RADIUS * 10.0
    assert area == pytest.approx(np.pi * 0.64, rel=0.02)


def test_a_disc_reaches_its_radius_in_both_directions() -> None:
    (region,) = read([DISC | {"active": 0.0}])
    z = np.array([5.0, 5.79, 5.81])
    angle = np.array([0.0, 0.79 / RADIUS, 0.81 / RADIUS])
    inside = coverage(region, z, angle, RADIUS)
    assert inside[:, 0].tolist() == [1.0, 1.0, 0.0]
    assert inside[0].tolist() == [1.0, 1.0, 0.0]
    assert inside[1, 1] == 0.0


def test_stripes_are_spread_evenly_and_run_along_the_tube() -> None:
    values = field(STRIPES | {"active": 2.0})
    assert (values == values[0]).all()
    assert [at(values, 5.0, angle) for angle in (30.0, 150.0, 270.0, 90.0, 210.0, 330.0)] == [2, 2, 2, 1, 1, 1]
    share = (values == 2.0).mean()
    assert share == pytest.approx(3 * 0.6 / (2.0 * np.pi * RADIUS), abs=3 / 96)


def test_a_map_is_linear_between_its_points_and_closes_around_the_ring() -> None:
    values = factor_field(
        read([MAP]), "circular", "active", np.array([1.0, 3.0, 9.0]), np.deg2rad([0, 90, 270]), RADIUS
    )
    assert values is not None
    assert np.allclose(values, [[1.0, 0.5, 0.5], [0.75, 0.5, 0.5], [0.5, 0.5, 0.5]], atol=1e-14)


@pytest.mark.parametrize("table", [BAND, BOX, DISC, STRIPES], ids=lambda t: t["shape"])
def test_smooth_edges_fade_over_their_width_about_the_sharp_edge(table: dict[str, Any]) -> None:
    (sharp,) = read([table | {"active": 0.0}])
    (smooth,) = read([table | {"active": 0.0, "edge": "2 mm"}])
    z, angle = np.linspace(3.5, 6.5, 601), np.linspace(0.0, 2.0 * np.pi, 721)
    hard, soft = coverage(sharp, z, angle, RADIUS), coverage(smooth, z, angle, RADIUS)
    assert 0.0 <= soft.min() < soft.max() == 1.0
    assert (soft[hard == 1.0] >= 0.5 - 1e-9).all()
    assert (soft[hard == 0.0] <= 0.5 + 1e-9).all()
    partly = ((soft > 0.0) & (soft < 1.0)).mean()
    assert 0.0 < partly < 0.5
    # Nowhere steeper than the cubic's 1.5 over the width, on either axis.
    steepest = max(
        np.abs(np.diff(soft, axis=0)).max() / (z[1] - z[0]), np.abs(np.diff(soft)).max() / (RADIUS * angle[1])
    )
    assert 5.0 < steepest < 7.6


def test_regions_multiply_and_keep_to_their_layer_and_quantity() -> None:
    first = BAND | {"active": 0.5, "potassium": 3.0}
    second = BAND | {"name": "half", "z_to": "5 cm", "layer": "circular", "active": 0.5}
    assert at(field(first, second), 4.5, 0.0) == 0.25
    assert at(field(first, second), 5.5, 0.0) == 0.5
    assert at(field(first, second, layer="longitudinal"), 4.5, 0.0) == 0.5
    assert at(field(first, second, quantity="potassium"), 4.5, 0.0) == 3.0
    assert field(first, second, quantity="leak") is None
    assert factor_field((), "circular", "active", Z, ANGLES, RADIUS) is None


# --- files ------------------------------------------------------------------------------------------

ALL = [
    BAND | {"layer": "circular", "excitation": 0.0, "inhibition": 0.0, "trigger": 0.5, "edge": "2 mm"},
    BAND | {"name": "second", "conductivity": 0.5, "pacemaker": 0.0, "z_from": "40 mm"},
    {**MAP, "angle": ["0 deg"], "values": [[0.1], [1.0 / 3.0]], "quantities": ["slow_calcium", "active"]},
]
"""Every kind of region that one column can show."""


def test_what_is_read_is_written_and_read_back_identically() -> None:
    config = Configuration(regions=ALL)
    text = config.to_toml()
    again = Configuration.from_toml(text)
    assert again == config
    assert again.to_toml() == text
    assert again.digest() == config.digest()
    assert hash(again) == hash(config)
    assert Configuration.from_mapping(config.texts()) == config
    assert Configuration(regions=config.regions) == config
    assert config.regions[1].shape == read([BAND | {"active": 1.0}])[0].shape


@pytest.mark.parametrize("table", [BOX, DISC, STRIPES], ids=lambda t: t["shape"])
def test_shapes_that_need_columns_are_written_and_read_back(table: dict[str, Any]) -> None:
    regions = read([table | {"fast_calcium": 0.3, "edge": "0.5 mm"}])
    assert read([region.table() for region in regions]) == regions


LENGTHS = st.floats(0.0, 200.0).map(lambda value: f"{value!r} cm")
TURNS = st.floats(-360.0, 360.0).map(lambda value: f"{value!r} deg")
FACTORS = st.dictionaries(st.sampled_from(list(QUANTITIES)), st.floats(0.0, 100.0), min_size=1)
TABLES = st.one_of(
    st.fixed_dictionaries({"name": st.just("a"), "shape": st.just("band"), "z_from": LENGTHS, "z_to": LENGTHS}),
    st.fixed_dictionaries(
        {
            "name": st.just("a"),
            "shape": st.just("box"),
            "z_from": LENGTHS,
            "z_to": LENGTHS,
            "angle_from": TURNS,
            "angle_to": TURNS,
        }
    ),
    st.fixed_dictionaries(
        {"name": st.just("a"), "shape": st.just("stripes"), "number": st.integers(1, 9), "width": LENGTHS}
    ),
)


@given(table=TABLES, factors=FACTORS, edge=LENGTHS)
@settings(max_examples=200, deadline=None)
def test_any_region_keeps_every_bit_or_is_refused(table: dict[str, Any], factors: dict[str, float], edge: str) -> None:
    with contextlib.suppress(ConfigurationError):
        (region,) = read([{**table, **factors, "edge": edge}])
        assert read([region.table()]) == (region,)
        assert repr(read([region.table()])) == repr((region,))


def test_equal_regions_digest_alike_and_different_ones_do_not() -> None:
    one = Configuration(regions=[BAND | {"active": 0.5}])
    assert one.digest() == Configuration(regions=[BAND | {"active": 0.5, "z_to": "60 mm", "edge": "0 mm"}]).digest()
    others = [
        BAND | {"active": 0.51},
        BAND | {"active": 0.5, "edge": "1 mm"},
        BAND | {"active": 0.5, "layer": "circular"},
    ]
    assert len({one.digest(), Configuration().digest(), *(Configuration(regions=[it]).digest() for it in others)}) == 5


def test_a_map_from_a_file_is_kept_whole(tmp_path: Path) -> None:
    """The configuration does not depend on the file any more, and its digest is that of the numbers."""
    table = {"name": "graded", "shape": "map", "quantities": ["active"], "file": str(tmp_path / "map.csv")}
    Path(table["file"]).write_text("z [mm] / angle [deg],0\n20,0.5\n\n40,0.25\n", encoding="utf-8")
    config = Configuration(regions=[table])
    Path(table["file"]).unlink()
    again = Configuration.from_toml(config.to_toml())
    assert again == config
    assert again.regions[0].shape.z == (2.0, 4.0)  # type: ignore[union-attr]
    inline = MAP | {"angle": ["0 deg"], "values": [[0.5], [0.25]]}
    assert Configuration(regions=[inline]).digest() == config.digest()
    other = MAP | {"angle": ["0 deg"], "values": [[0.5], [0.26]]}
    assert Configuration(regions=[other]).digest() != config.digest()


def test_an_array_will_do_for_the_values_of_a_map() -> None:
    assert read([MAP | {"values": np.array(MAP["values"])}]) == read([MAP])


def test_the_command_line_takes_a_list_of_tables() -> None:
    text = '[{name = "segment", shape = "band", z_from = "4 cm", z_to = "6 cm", active = 0.5}]'
    assert Configuration().with_changes({"regions": text}) == Configuration(regions=[BAND | {"active": 0.5}])
    assert Configuration(regions=[BAND | {"active": 0.5}]).with_changes({"regions": "[]"}) == Configuration()


@pytest.mark.parametrize(
    ("tables", "message"),
    [
        ("band", "not a list of tables"),
        ([BAND], r"segment: it changes nothing; give a factor"),
        (["band"], "number 1 = 'band': not a table"),
        ([{"shape": "band"}], "number 1: name = None is not a name"),
        ([BAND | {"name": 'a"b', "active": 0}], "is not a name; use letters"),
        ([BAND | {"shape": "bnad", "active": 0}], r"shape = 'bnad': not one of band, box.*did you mean band\?"),
        ([BAND | {"layer": 3, "active": 0}], "layer = 3: not one of both, longitudinal, circular"),
        ([BAND | {"actve": 0.5}], r"'actve' is no key of a band; did you mean active\?"),
        ([BAND | {"chloride": 0.5}], "the chloride conductance is called leak"),
        ([BAND | {"angle_from": "0 deg", "active": 0}], "'angle_from' is no key of a band"),
        ([BAND | {"active": -0.1}], r"active = -0\.1: out of range; give a value of at least 0 and at most 100"),
        ([BAND | {"active": "half"}], "segment: active = 'half': it does not begin with a finite number"),
        ([BAND | {"active": math.nan}], "not a finite number"),
        ([BAND | {"active": 0, "z_from": 4.0}], "segment: z_from = 4.0: the unit is missing"),
        ([BAND | {"active": 0, "z_from": "4 s"}], "cannot be converted to cm"),
        ([BAND | {"active": 0, "z_from": "7 cm"}], "z_from = 7 cm is not before z_to = 6 cm"),
        ([BAND | {"active": 0, "z_to": "11 cm"}], r"z_to = 11 cm lies beyond the anal end; use at most wall\.length"),
        ([{"name": "a", "shape": "band", "z_to": "1 cm", "active": 0}], "z_from is missing; give it"),
        ([BAND | {"active": 0, "edge": "-1 mm"}], r"edge = -0\.1 cm: out of range; give a value of at least 0"),
        ([BAND | {"active": 0}, BAND | {"leak": 0}], "segment is the name of two of them"),
        ([BAND | {"name": f"r{k}", "active": 0} for k in range(51)], "51 are too many; give at most 50"),
        ([BAND | {"layer": "longitudinal", "inhibition": 0}], "inhibition belongs to the circular layer"),
        ([BOX | {"active": 0, "angle_to": "350 deg"}], "both 350 deg; for the whole ring use 0 deg and 360 deg"),
        (
            [BOX | {"active": 0}],
            r"this box varies around the ring, and grid\.n_theta = 1 is one column; use",
        ),
        ([DISC | {"active": 0}], "this disc varies around the ring"),
        ([DISC | {"active": 0, "radius": "0 mm"}], "radius = 0.0 cm: out of range; give a value of more than 0"),
        ([STRIPES | {"active": 0}], "this stripes varies around the ring"),
        ([STRIPES | {"active": 0, "number": 2.5}], "number = 2.5: not a whole number"),
        ([STRIPES | {"active": 0, "number": 9}], "9 stripes of 0.6 cm fill the ring of"),
        ([MAP], "this map varies around the ring"),
        ([MAP | {"quantities": []}], "a map names what it multiplies"),
        ([MAP | {"quantities": ["actve"]}], r"did you mean active\?"),
        ([MAP | {"z": ["4 cm", "2 cm"]}], "z: the values do not rise"),
        ([MAP | {"values": [[1.0, 0.0]]}], "values has 1 rows and z 2 places"),
        ([MAP | {"values": [[1.0, 0.0], [1.0]]}], "row 2 has 1 values and angle 2"),
        ([MAP | {"values": [[1.0, 0.0], [1.0, "a"]]}], "values, row 2 = 'a'"),
        ([MAP | {"angle": ["0 deg", "360 deg"]}], "the ring closes by itself"),
        ([MAP | {"file": "a.csv"}], "file and z are both given"),
        ([{"name": "a", "shape": "map", "quantities": ["active"]}], "z is missing; a map has a file, or z, angle"),
        ([{"name": "a", "shape": "map", "quantities": ["active"], "file": "none.csv"}], "cannot be read: No such file"),
        ([{"name": "a", "shape": "map", "quantities": ["active"], "file": 3}], "name of a CSV file as text"),
        ([{"name": "a", "shape": "map", "quantities": ["active"], "file": "a\0b"}], "cannot be read"),
    ],
)
def test_what_is_wrong_is_one_line_with_cause_and_fix(tables: Any, message: str) -> None:
    with pytest.raises(ConfigurationError, match=message) as caught:
        Configuration(regions=tables)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("regions")
    assert len(str(caught.value)) < 400


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "no header with both units"),
        (b"z,0,90\n1,1,1\n", "no header with both units"),
        (b"z [cm] / angle [deg],0\n", "no header with both units"),
        (b"z [cm] / angle [deg],0\n1,one\n", "line 2 holds no plain numbers"),
        (b"z [s] / angle [deg],0\n1,1\n", "cannot be converted to cm"),
        (b"z [cm] / angle [deg],0,90\n1,1\n", "row 1 has 1 values and angle 2"),
        (b"z [cm] / angle [deg],0\n1,nan\n", "not a finite number"),
        (b"\xff\xfe\x00", "not a text file"),
        (b"0" * 1_000_001, "larger than 1000000 bytes"),
        (
            b"z [cm] / angle [deg]," + b",".join(b"%d" % k for k in range(200)) + b"\n" + b"1" + b",1" * 200 + b"\n",
            None,
        ),
    ],
)
def test_files_of_maps_are_read_or_refused(tmp_path: Path, content: bytes, message: str | None) -> None:
    file = tmp_path / "map.csv"
    file.write_bytes(content)
    table = {"name": "a", "shape": "map", "quantities": ["active"], "file": str(file)}
    if message is None:
        assert len(read([table])[0].shape.angle) == 200  # type: ignore[union-attr]
        return
    with pytest.raises(ConfigurationError, match=message) as caught:
        read([table])
    assert "\n" not in str(caught.value)


def test_maps_have_a_size_that_a_stored_configuration_can_hold() -> None:
    large = MAP | {"z": [f"{k} mm" for k in range(1, 101)], "angle": [f"{k} deg" for k in range(101)]}
    with pytest.raises(ConfigurationError, match="100 x 101 values are too many; keep to 10000"):
        read([large | {"values": [[1.0] * 101] * 100}])
    many = MAP | {"z": large["z"], "angle": large["angle"][:60], "values": [[1.0 / 3.0] * 60] * 100}
    with pytest.raises(ConfigurationError, match="maps of 12000 values are too large"):
        read([many, many | {"name": "b"}])
    one = MAP | {"z": large["z"], "angle": large["angle"][:1], "values": [[1.0 / 3.0]] * 100}
    config = Configuration(regions=[one | {"name": f"r{k}"} for k in range(50)])
    assert Configuration.from_toml(config.to_toml()) == config


def test_unknown_keys_have_their_own_error() -> None:
    with pytest.raises(UnknownKeyError):
        read([BAND | {"colour": "red"}])


def test_more_columns_show_what_one_cannot() -> None:
    regions = read([DISC | {"active": 0.0}])
    with pytest.raises(ConfigurationError, match="one column"):
        check(regions, 10.0, RADIUS, 1)
    check(regions, 10.0, RADIUS, 16)


# --- what they do -----------------------------------------------------------------------------------


def configured(*tables: dict[str, Any], **changes: Any) -> Configuration:
    return Configuration.from_mapping({**COARSE, "regions": list(tables), **changes})


def test_every_conductance_of_the_model_is_that_of_the_region() -> None:
    plain = build(configured())
    for channel, row in zip(CHANNELS, plain.circular.conductances, strict=True):
        model = build(configured(BAND | {"layer": "circular", channel: 0.25}))
        inside = (model.grid.cells > 4.0) & (model.grid.cells < 6.0)
        k = CHANNELS.index(channel)
        assert np.array_equal(model.circular.conductances[k], np.where(inside, 0.25 * row, row))
        others = [n for n in range(5) if n != k]
        assert np.array_equal(model.circular.conductances[others], plain.circular.conductances[others])
        assert np.array_equal(model.longitudinal.conductances, plain.longitudinal.conductances)


def test_without_regions_the_model_holds_plain_numbers() -> None:
    """Nothing is paid for, and no bit moves, where no region is."""
    layer = build(configured()).circular
    assert (layer.force_factor, layer.conductivity) == (1.0, 1.0)
    assert layer.response == type(layer.response)(1.0, 1.0, 1.0, 1.0)


def test_force_is_that_of_the_region_on_every_half_element() -> None:
    model, state, _ = initial_state(build(configured(BAND | {"active": 0.25}, **{"pellet.enabled": False})))
    from dataclasses import replace

    sheet = replace(state.circular, potential=np.full_like(state.circular.potential, -25.0))
    drive = muscle_drive(model, model.circular, sheet)[:, 0]
    middles = (np.arange(drive.size) + 0.5) * 10.0 / drive.size
    deep = (middles > 4.1) & (middles < 5.9)
    far = (middles < 3.9) | (middles > 6.1)
    assert np.allclose(drive[deep], 0.25 * 30.0)
    assert np.allclose(drive[far], 30.0)


def run(config: Configuration, seconds: float) -> Any:
    model, state, _ = initial_state(build(config))
    for _ in range(round(seconds / model.dt_wall)):
        state, _ = advance(model, state)
    return model, state


def test_a_region_that_multiplies_by_one_changes_no_bit() -> None:
    ones = dict.fromkeys(QUANTITIES, 1.0)
    _, plain = run(configured(), 0.2)
    _, same = run(configured(BAND | ones), 0.2)
    assert np.array_equal(plain.wall.position, same.wall.position)
    assert np.array_equal(plain.circular.potential, same.circular.potential)


def test_a_wave_ends_where_nothing_is_conducted() -> None:
    calm = {"pellet.enabled": False, "longitudinal.active": 0.0, "circular.active": 0.0}
    model, state = run(configured(BAND | {"conductivity": 0.0}, **calm), 2.5)
    arrived = np.isfinite(state.longitudinal.first_activation[:, 0])
    assert arrived[model.grid.cells < 3.9].all()
    assert not arrived[model.grid.cells > 4.1].any()


def test_cells_rest_where_their_own_conductances_put_them() -> None:
    """Each kind of tissue starts at its own rest, and stays there."""
    quiet = {"pacemaker.kind": "none", "pellet.enabled": False, "lumen.pressure": "0 kPa"}
    config = configured(BAND | {"slow_calcium": 1.4, "conductivity": 0.0, "edge": "1 cm"}, **quiet)
    model, state, _ = initial_state(build(config))
    start = state.circular.potential[:, 0]
    inside = (model.grid.cells > 4.6) & (model.grid.cells < 5.4)
    assert np.unique(start[inside]).size == 1
    assert start[inside][0] > start[0] + 0.5
    assert np.unique(start).size > 10  # the edge is graded
    alone = build(
        configured(
            BAND | {"slow_calcium": 1.4, "conductivity": 0.0, "edge": "1 cm", "z_to": "9.9 cm", "z_from": "0.1 cm"},
            **quiet,
            **{"longitudinal.conduction": False, "circular.conduction": False},
        )
    )
    _, rested, _ = initial_state(alone)
    later, _ = advance(alone, rested)
    assert np.abs(later.circular.potential - rested.circular.potential).max() < 1e-9


@pytest.mark.parametrize(("quantity", "layer"), [("pacemaker", "longitudinal"), ("trigger", "circular")])
def test_drivers_do_not_reach_a_region_without_them(quantity: str, layer: str) -> None:
    still = {"longitudinal.conduction": False, "circular.conduction": False, "pellet.enabled": False}
    drivers = {"pacemaker.width": "10 cm", **still}
    model, state = run(configured(BAND | {quantity: 0.0}, **drivers), 0.5)
    fired = np.isfinite(getattr(state, layer).first_activation[:, 0])
    inside = (model.grid.cells > 4.0) & (model.grid.cells < 6.0)
    assert not fired[inside].any()
    assert fired[~inside].all()


def test_the_reflex_is_cut_in_both_its_parts() -> None:
    """The pellet at 1.2 cm excites on its oral side and inhibits on its anal one; a region takes either away."""
    reflex = {"pacemaker.kind": "none", "pellet.start_gap": "3 cm"}
    model, plain = run(configured(**reflex), 0.2)
    cells = model.grid.cells
    rest = plain.circular.potential[-1, 0]
    oral, anal = (cells > 2.0) & (cells < 3.0), (cells > 5.2) & (cells < 6.0)
    assert plain.circular.potential[oral, 0].max() > rest + 5.0
    assert plain.circular.potential[anal, 0].min() < rest - 1.0
    everywhere = BAND | {"z_from": "0 cm", "z_to": "10 cm"}
    _, silent = run(configured(everywhere | {"excitation": 0.0}, **reflex), 0.2)
    assert silent.circular.potential[oral, 0].max() < rest + 1.0
    assert silent.circular.potential[anal, 0].min() < rest - 1.0
    _, free = run(configured(everywhere | {"inhibition": 0.0}, **reflex), 0.2)
    assert free.circular.potential[oral, 0].max() > rest + 5.0
    assert free.circular.potential[anal, 0].min() > rest - 0.5


def test_a_region_between_two_cells_is_remarked_on() -> None:
    small = BAND | {"z_from": "5.01 cm", "z_to": "5.02 cm", "active": 0.0}
    assert any(
        "region segment: no conduction cell lies in it" in remark for remark in preflight.remarks(configured(small))
    )
    assert not any("region" in remark for remark in preflight.remarks(configured(BAND | {"active": 0.0})))


def test_regions_are_data() -> None:
    (region,) = read([BAND | {"active": 0.5, "layer": "circular"}])
    assert isinstance(region, Region)
    assert region.words() == "segment (band, the circular layer): active x 0.5"
    assert read([MAP])[0].words() == "graded (map, both layers): active"


# --- the place of the pacemaker ---------------------------------------------------------------------


def test_the_pacemaker_starts_where_it_is_put() -> None:
    calm = {"pellet.enabled": False, "longitudinal.active": 0.0, "circular.active": 0.0}
    model, state = run(configured(**calm, **{"pacemaker.place": "4.85 cm"}), 0.8)
    times = state.longitudinal.first_activation[:, 0]
    assert 4.85 < model.grid.cells[np.nanargmin(times)] < 5.15
    assert np.allclose(times, times[::-1], rtol=1e-6, equal_nan=True)  # it runs both ways alike
    assert np.isfinite(times).sum() > 30


def test_an_autonomous_cell_drives_the_stretch_at_its_place() -> None:
    cell = build(configured(**{"pacemaker.kind": "cell", "pacemaker.place": "2 cm"})).pacemaker_cell
    assert cell is not None
    assert (cell.place, cell.width) == (2.0, 0.3)


def test_places_of_the_pacemaker_that_do_not_exist_are_refused() -> None:
    with pytest.raises(
        ConfigurationError, match=r"pacemaker.place = 9.8 cm: .*beyond the anal end; use at most 9.7 cm"
    ):
        configured(**{"pacemaker.place": "9.8 cm"})
    with pytest.raises(ConfigurationError, match=r"pacemaker.angular_width = 90.0 deg: .*one column.*use 360 deg"):
        configured(**{"pacemaker.angular_width": "90 deg"})
    assert configured(**{"pacemaker.place": "9.8 cm", "pacemaker.kind": "none"}).pacemaker.place == 9.8


# --- the page about them ----------------------------------------------------------------------------

PAGE = Path(__file__).parents[2] / "docs" / "regions.md"


@pytest.mark.parametrize("text", re.findall(r"```toml\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL))
def test_the_examples_of_the_page_are_regions(text: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each fits the tube; one that varies around the ring and does not ask for columns is refused with the cure."""
    (csv_map,) = re.findall(r"```text\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    (tmp_path / "biopsy.csv").write_text(csv_map, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    regions = read(tomllib.loads(text)["regions"])
    check(regions, 10.0, RADIUS, 16)
    if varies_around(regions) and "n_theta" not in text:
        with pytest.raises(ConfigurationError, match="one column"):
            Configuration.from_toml(text)
    else:
        assert Configuration.from_toml(text).regions == regions


def test_stripes_over_a_band_leave_the_stripes_as_they_were() -> None:
    thin = BAND | {"z_from": "0 cm", "z_to": "10 cm", "active": 0.2}
    values = field(thin, STRIPES | {"active": 5.0})
    assert set(np.round(np.unique(values), 12)) == {0.2, 1.0}
