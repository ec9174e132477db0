"""What a run leaves behind: stored and read back without losing a bit, or refused."""

import io
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import h5netcdf
import h5py
import numpy as np
import pytest
import xarray

from peristalsis.errors import ConfigurationError, WriteError
from peristalsis.names import OUTPUTS
from peristalsis.results.measures import wave_speed
from peristalsis.results.result import Result, load
from peristalsis.running.simulation import Simulation
from peristalsis.storing.netcdf import netcdf_image
from verification.exact.runs import configured


@pytest.fixture(scope="module")
def result() -> Result:
    changes = {"grid.n_z": 100, "grid.n_z_wall": 60, "run.duration": "0.1 s", "pellet.viscous_friction": "120 mN*s/cm"}
    return Simulation(configured(changes)).run()


def test_round_trip_keeps_every_bit(result: Result, tmp_path: Path) -> None:
    """Arrays, summary, configuration and remarks; nan stays nan."""
    back = load(result.save(tmp_path / "run"))
    assert back.arrays.keys() == result.arrays.keys()
    for name, values in result.arrays.items():
        if values.dtype.kind != "O":  # texts of any length come back with a length
            assert back.arrays[name].dtype == values.dtype, name
        assert np.array_equal(back.arrays[name], values, equal_nan=values.dtype.kind == "f"), name
    assert back.summary == result.summary
    assert back.configuration == result.configuration
    assert back.remarks == result.remarks


def test_dataset_carries_units_dimensions_and_origin(result: Result) -> None:
    """Every output as it is named once, and the configuration that made it."""
    dataset = result.dataset
    for name in result.arrays:
        assert dataset[name].attrs.get("units", "") == OUTPUTS[name].unit
        assert dataset[name].dims == OUTPUTS[name].dimensions
    assert dataset.attrs["configuration"] == result.configuration.to_toml()
    assert dataset.attrs["configuration_digest"] == result.configuration.digest()
    assert dataset["radius"].shape == (11, 61, 1)


def test_the_file_is_the_dataset(result: Result, tmp_path: Path) -> None:
    """For who opens it with xarray: names, dimensions, coordinates, attributes and numbers, with and without events."""
    assert result.arrays["event_time"].size > 0
    uneventful = {n: v[:0] if n.startswith("event_") else v for n, v in result.arrays.items()}
    for name, one in (("some", result), ("none", replace(result, arrays=uneventful))):
        with xarray.open_dataset(one.save(tmp_path / name) / "result.nc", engine="h5netcdf") as stored:
            empty = [n for n, v in one.arrays.items() if v.size == 0]  # a length of 0 would mean "unlimited"
            assert not set(empty) & set(stored.variables)
            xarray.testing.assert_identical(stored.load(), one.dataset.drop_vars(empty))


def test_the_file_is_one_that_a_netcdf_library_writes(result: Result) -> None:
    """Scales, fill values, types and attributes as h5netcdf leaves them, read by HDF5 alone."""
    wanted = ("time_step", "lumen_pressure", "time", "z_cell", "radius", "event_time", "event_kind")
    arrays = {name: result.arrays[name] for name in ("radius", *wanted)}  # a field before what it lies on
    theirs = io.BytesIO()
    with h5netcdf.File(theirs, "w") as file:
        for name, values in arrays.items():
            values, dimensions = np.asarray(values), OUTPUTS[name].dimensions
            if values.dtype.kind in "OU":
                values = np.char.encode(values.astype(str))[:, None].view("S1")
                dimensions = (*dimensions, f"{name}_length")
            for dimension, size in zip(dimensions, values.shape, strict=True):
                if dimension not in file.dimensions:
                    file.dimensions[dimension] = size
            more = {} if dimensions == (name,) or values.dtype.kind == "S" else {"fillvalue": np.nan}
            file.create_variable(name, dimensions, data=values, **more)
    with h5py.File(io.BytesIO(netcdf_image(arrays, {"schema": 1}))) as ours, h5py.File(theirs) as other:
        assert set(ours) == set(other)
        for name, one in ours.items():
            two = other[name]
            assert (one.shape, one.dtype) == (two.shape, two.dtype), name
            if name in arrays:
                assert one[()].tobytes() == two[()].tobytes(), name
            scale = [bytes(file[name].attrs.get("NAME", b"")) for file in (ours, other)]
            assert scale[0] == scale[1], name
            assert [scales.keys() for scales in one.dims] == [scales.keys() for scales in two.dims], name
            # h5netcdf 1.3 writes one number where 1.8 writes a row of one.
            fills = [np.ravel(file[name].attrs.get("_FillValue", np.zeros(0))) for file in (ours, other)]
            assert np.array_equal(*fills, equal_nan=True), name
            assert one.is_scale == two.is_scale, name
    with h5netcdf.File(io.BytesIO(netcdf_image(arrays, {"schema": 1})), "r") as read:
        assert read["radius"].dimensions == OUTPUTS["radius"].dimensions
        assert read.attrs["schema"] == 1


def test_saving_does_without_xarray(result: Result, tmp_path: Path) -> None:
    """Which takes half a second to import, a tenth of a whole run."""
    source = f"""
import sys
from peristalsis.results.result import Result
from peristalsis.running.simulation import Simulation
from verification.exact.runs import configured
changes = {{"grid.n_z": 100, "grid.n_z_wall": 60, "run.duration": "10 ms"}}
Simulation(configured(changes)).run().save({str(tmp_path / "run")!r})
print("xarray" in sys.modules, "pandas" in sys.modules, "h5netcdf" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", source], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False"] * 3


def test_existing_folder_is_not_overwritten_unasked(result: Result, tmp_path: Path) -> None:
    folder = result.save(tmp_path / "run")
    with pytest.raises(WriteError, match="exists"):
        result.save(folder)
    assert result.save(folder, overwrite=True) == folder
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run"], "nothing temporary may stay"


def test_foreign_folder_is_never_overwritten(result: Result, tmp_path: Path) -> None:
    (tmp_path / "thesis.txt").write_text("years of work", encoding="utf-8")
    with pytest.raises(WriteError, match="no result of peristalsis"):
        result.save(tmp_path, overwrite=True)
    assert (tmp_path / "thesis.txt").exists()


@pytest.mark.parametrize("keep", [0, 100, 5000])
def test_truncated_file_is_refused(result: Result, tmp_path: Path, keep: int) -> None:
    """R3: a torn file is one sentence, never half a result."""
    folder = result.save(tmp_path / "run")
    file = folder / "result.nc"
    file.write_bytes(file.read_bytes()[:keep])
    with pytest.raises(ConfigurationError, match="not a whole result"):
        load(folder)


def test_missing_result_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ConfigurationError, match=r"result.nc is missing"):
        load(tmp_path)


def test_wave_speed_is_the_slope_between_3_and_8_cm() -> None:
    z = np.linspace(0.05, 9.95, 100)
    times = 0.3 + z / 4.2
    times[z < 2.9] += 7.0
    assert wave_speed(z, times) == pytest.approx(4.2, rel=1e-12)
    times[50] = np.nan
    assert wave_speed(z, times) == pytest.approx(4.2, rel=1e-12), "one silent cell stops no wave"
    times[40:60] = np.nan
    assert wave_speed(z, times) is None, "a wave that did not pass has no speed"


def test_summary_agrees_with_the_arrays(result: Result) -> None:
    """The numbers of the summary are those of the recorded steps."""
    summary, arrays = result.summary, result.arrays
    assert summary["final_position_cm"] == arrays["pellet_position"][-1]
    assert summary["travel_cm"] == pytest.approx(arrays["pellet_position"][-1] - arrays["pellet_position"][0])
    assert summary["max_axial_force_mN"] == np.abs(arrays["axial_force"]).max()
    assert summary["steps"] == 50
    assert summary["simulated_s"] == pytest.approx(0.1)
