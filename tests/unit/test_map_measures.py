"""What is measured of maps has a known answer, is the same bits twice, and ends where it is said to end."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import peristalsis as ps
from peristalsis import maps
from peristalsis.errors import ConfigurationError
from peristalsis.inputs import tables
from peristalsis.inputs.stimuli import read as read_stimuli
from peristalsis.maps import STANDING, Ring, courses, measures, states
from peristalsis.maps.drawing import analysis, comparison, manometry, map_figure
from peristalsis.maps.synthetic import example
from peristalsis.maps.treatment import SIGMA
from peristalsis.plots import style

DOWN = Ring(20.0, 5.0, 2.0, 85.0, 4.0)
UNEVEN = np.array([0.0, 8.0, 16.0, 24.0, 32.0, 45.0, 58.0, 71.0, 90.0, 110.0, 130.0, 150.0])


def found_in(*rings: Ring, noise: float = 0.8, seed: int = 1, duration: float = 120.0) -> maps.Contractions:
    """Contractions found in a map of rings; noise is a fifth of the depth."""
    return maps.contractions(maps.recording(rings, duration, noise=noise, seed=seed))


@pytest.mark.parametrize("speed", [2.0, -2.0, 0.6, 20.0])
def test_speed_direction_extent_depth_and_duration(speed: float) -> None:
    ring = replace(DOWN, speed=speed, place=5.0 if speed > 0.0 else 60.0, extent=55.0)
    (one,) = found_in(ring, duration=160.0)
    assert one.direction == ring.direction
    assert one.speed == pytest.approx(speed, rel=0.03)
    assert abs(one.speed - speed) < 6.0 * one.error
    assert one.extent == pytest.approx(55.0, abs=4.0)
    assert one.begin == pytest.approx(20.0, abs=0.5)
    assert one.place == pytest.approx(ring.place, abs=3.0)
    assert one.amplitude == pytest.approx(4.0, abs=0.3)
    assert one.duration == pytest.approx(3.0, abs=0.5)
    assert one.occlusion == pytest.approx(4.0 / 12.0, abs=0.03)


def test_standing_crossing_spreading_and_intervals() -> None:
    assert [one.direction for one in found_in(Ring(30.0, 20.0, STANDING, 50.0, 4.0))] == ["standing"]
    crossing = found_in(Ring(15.0, 5.0, 2.0, 90.0, 4.0), Ring(15.0, 95.0, -2.0, 90.0, 4.0))
    assert sorted(round(one.speed, 1) for one in crossing) == [-2.0, 2.0]
    assert [one.extent for one in crossing] == pytest.approx([90.0, 90.0], abs=4.0)
    spreading = found_in(Ring(20.0, 50.0, 2.0, 45.0, 4.0), Ring(20.0, 50.0, -2.0, 45.0, 4.0), noise=0.4)
    assert sorted(one.direction for one in spreading) == ["antegrade", "retrograde"]
    train = found_in(*(replace(DOWN, begin=20.0 + 40.0 * k) for k in range(4)), duration=220.0)
    assert [one.interval for one in train][1:] == pytest.approx([40.0] * 3, abs=0.3)
    assert train[0].interval is None
    assert train.numbers()["interval_s"] == pytest.approx(40.0, abs=0.3)


def test_gaps_are_crossed_and_fronts_by_threshold_are_earlier() -> None:
    recorded = maps.recording([DOWN], 120.0, noise=0.4, seed=2)
    values = np.array(recorded.values)
    values[380:420] = np.nan  # 4 s in the middle of the front
    values[:, 20:24] = np.nan
    (one,) = maps.contractions(recorded.done("gaps", values=values))
    assert one.speed == pytest.approx(2.0, rel=0.03)
    assert one.extent == pytest.approx(85.0, abs=4.0)
    (ridge,), (onset,) = (maps.contractions(recorded, maps.Rule(front=front)) for front in ("ridge", "threshold"))
    assert 0.5 < ridge.begin - onset.begin < 2.5
    assert onset.speed == pytest.approx(2.0, rel=0.05)


def test_uneven_channels_and_the_rule_of_high_amplitude() -> None:
    heights = (130.0, 70.0, 95.0)
    waves = [Ring(20.0 + 45.0 * k, 4.0, 20.0, 140.0, height, 6.0) for k, height in enumerate(heights)]
    recorded = maps.recording(waves, 160.0, place=UNEVEN, quantity="pressure", rest=5.0, noise=3.0, seed=3)
    found = maps.contractions(recorded)
    assert [one.speed for one in found] == pytest.approx([20.0] * 3, rel=0.05)
    assert [one.number for one in measures.high_amplitude(recorded, found)] == [1, 3]  # 95 + 5 mmHg of rest
    assert measures.high_amplitude(recorded, found, measures.HighAmplitude(high=60.0, lower=60.0)) == list(found.found)
    with pytest.raises(ConfigurationError, match="the rule is about pressures"):
        measures.high_amplitude(maps.recording([DOWN], 60.0), found)


def test_where_it_ends_is_as_stated() -> None:
    """The failures that docs/maps.md names: weak beside strong, fading, as fast as to stand, noise as deep as all."""
    weak = replace(DOWN, begin=80.0, amplitude=0.8)
    assert len(found_in(DOWN, weak, noise=0.08, duration=160.0)) == 1
    recorded = maps.recording([DOWN, weak], 160.0, noise=0.08)
    assert len(maps.contractions(recorded, maps.Rule(threshold=0.4))) == 2
    (fading,) = found_in(replace(DOWN, fade=1.0))
    assert 40.0 < fading.extent < 70.0
    (fast,) = found_in(replace(DOWN, speed=200.0))
    assert fast.direction == "standing"
    assert fast.speed is None
    noise_alone = maps.contractions(maps.recording((), 120.0, noise=1.0))
    assert len(noise_alone) == 0
    assert noise_alone.chosen_by_noise


def test_a_recording_that_ends_within_a_contraction_is_measured() -> None:
    """No point of it has a duration, and nothing is warned of."""
    recorded = maps.recording([Ring(10.0, 5.0, 40.0, 80.0, 4.0, 8.0)], 11.0)
    (one,) = maps.contractions(recorded, maps.Rule(threshold=1.0))
    assert np.isnan(one.duration)
    assert one.extent > 60.0
    assert maps.contractions(recorded.part(times=(0.0, 2.0))).found == ()


def test_the_same_map_measured_twice_gives_the_same_bits() -> None:
    first, second = (maps.level(example()[0], 60.0) for _ in range(2))
    assert first.fingerprint() == second.fingerprint()
    one, two = maps.contractions(first), maps.contractions(second)
    assert one.csv() == two.csv()
    assert [a.front[1].tobytes() for a in one] == [b.front[1].tobytes() for b in two]


def test_frequency_and_its_limits() -> None:
    waves = [Ring(10.0 + 15.0 * k, 5.0, 2.0, 90.0, 4.0, 4.0) for k in range(40)]
    for noise in (0.0, 0.8, 4.0):
        found = measures.spectrum(maps.recording(waves, 600.0, noise=noise), 150.0)
        assert found.peak == pytest.approx(4.0, abs=0.02)
        assert found.limits is not None
        assert found.limits[0] < 4.0 < found.limits[1]
    assert measures.spectrum(maps.recording((), 600.0, noise=1.0), 150.0).peak is None
    time = 0.25 * np.arange(4096)
    wave = 3.0 * np.sin(2.0 * np.pi * 0.125 * time)  # power 9/2 in all
    whole = measures.spectrum(maps.Map(wave[:, None], time, [0.0], "pressure"), 256.0)
    assert np.trapezoid(whole.power[:, 0], whole.frequency) == pytest.approx(4.5, rel=0.02)
    with pytest.raises(ConfigurationError, match="at least 16 steps"):
        measures.spectrum(maps.recording((), 60.0, noise=1.0), 1.0)


def test_pellets() -> None:
    time = np.arange(0.0, 60.0, 0.5)
    track = maps.Track(time, np.minimum(5.0 + 2.0 * time, 60.0), diameter=8.0)
    passed = measures.passage(track, 20.0, 50.0)
    assert passed.speed == pytest.approx(2.0)
    assert (passed.begin, passed.end) == pytest.approx((7.5, 22.5))
    assert measures.passage(track, 20.0, 80.0).why == "did not reach 80 mm"
    back = maps.Track(time, 100.0 - 1.5 * time)
    assert measures.passage(back, 80.0, 50.0).speed == pytest.approx(-1.5)
    widening = maps.Map(np.repeat(10.0 + 0.1 * time[:, None], 11, 1), time, 10.0 * np.arange(11), "diameter")
    when, speed, width = measures.velocity_against_diameter(track, widening, 2.0)
    assert width == pytest.approx(10.0 + 0.1 * when)
    assert speed[3] == pytest.approx(2.0)
    assert speed[-3] == pytest.approx(0.0)


def test_states_of_the_wall() -> None:
    pressure = maps.recording([DOWN], 120.0, quantity="pressure", rest=5.0)
    narrowing = maps.recording([DOWN], 120.0)
    active = states.states(narrowing, pressure).shares
    passive = states.states(narrowing.done("turned over", values=24.0 - narrowing.values), pressure).shares
    assert active["contracting"] > 0.02
    assert active["contracting"] == pytest.approx(active["relaxing"], rel=0.1)
    assert active["passive: distended"] == 0.0
    assert passive["passive: distended"] == pytest.approx(active["contracting"])
    assert passive["contracting"] == 0.0


def test_two_maps_are_aligned() -> None:
    one = maps.recording([DOWN], 120.0, noise=0.2, seed=5)
    two = maps.recording([replace(DOWN, begin=22.5)], 120.0, noise=0.2, seed=6)
    pair = maps.compare(one, two, most=5.0)
    assert pair.shift == pytest.approx(-2.5)
    assert pair.correlation > 0.85
    assert pair.rms == pytest.approx(0.2 * np.sqrt(2.0), rel=0.05)
    assert maps.compare(one, one).rms == 0.0
    later = one.done("later", time=one.time + 500.0)
    with pytest.raises(ConfigurationError, match="do not overlap"):
        maps.compare(one, later)


def test_treatment_is_written_down_and_does_what_it_says() -> None:
    recorded = maps.recording([DOWN], 120.0, noise=0.3, drift=2.0, seed=7)
    values = np.array(recorded.values)
    values[100, 50] = 40.0
    spiked = recorded.done("a spike", values=values)
    cleaned = maps.despiked(spiked, 2.0)
    assert np.isnan(cleaned.values[100, 50])
    assert np.isnan(cleaned.values).mean() < 1e-3
    flat = maps.level(recorded, 40.0)
    before, after = (np.median(one.values[-100:], 0) - np.median(one.values[:100], 0) for one in (recorded, flat))
    assert np.abs(after).max() < 0.5 < 2.0 < np.abs(before).max()
    coarse = maps.resampled(recorded, 1.0, 5.0)
    assert (coarse.time_step(), coarse.place_step()) == pytest.approx((1.0, 5.0))
    noise = SIGMA * np.median(np.abs(np.diff(coarse.values[60:], axis=0))) / np.sqrt(2.0)
    assert noise < 0.15  # of 0.3 before
    assert maps.filled(cleaned, 0.5).gaps == 0.0
    assert [line.split(":")[0].split(" ")[0] for line in flat.history] == ["synthetic", "level"]


def test_courses_are_inputs_of_a_run(tmp_path: Path) -> None:
    pressure = maps.recording([replace(DOWN, amplitude=20.0)], 120.0, quantity="pressure", rest=8.0, dropped=0.05)
    file = courses.write_course(pressure, 50.0, tmp_path / "pressure.csv")
    course = tables.read(file, "lumen.pressure", {"lumen.pressure": "kPa"})["lumen.pressure"]
    assert max(course.values) == pytest.approx(28.0 * 0.133322, rel=0.02)
    assert course.times[0] == 0.0
    found = maps.contractions(maps.recording([DOWN], 120.0))
    listed = courses.write_stimuli(found, tmp_path / "again.csv", 2.0)
    stimuli = read_stimuli([f"table {listed}"], 0.3)
    assert stimuli[0].layer == "circular"
    assert stimuli[10].onset == pytest.approx(20.0 + (10.0 * stimuli[10].low - 5.0 + 1.5) / 2.0, abs=0.2)
    with pytest.raises(ConfigurationError, match="takes a pressure as its protocol"):
        courses.write_course(maps.recording([DOWN], 60.0), 50.0, tmp_path / "diameter.csv")


def test_every_picture_is_drawn(tmp_path: Path) -> None:
    """With its labels, in every format, gaps and uneven channels among them; nothing is warned of."""
    recorded, _, track = example()
    found = maps.contractions(maps.level(recorded, 60.0))
    waves = [Ring(20.0 + 45.0 * k, 4.0, 20.0, 140.0, 90.0, 6.0) for k in range(3)]
    pressure = maps.recording(waves, 160.0, place=UNEVEN, quantity="pressure", rest=5.0, noise=3.0, dropped=0.05)
    power = measures.spectrum(pressure, 80.0)
    wall = states.states(maps.recording([DOWN], 120.0), maps.recording([DOWN], 120.0, quantity="pressure"))
    with style.applied():
        drawn = {
            "map": map_figure.draw(recorded, found, (track,)),
            "manometry": manometry.draw(pressure, maps.contractions(pressure)),
            "traces": manometry.draw_traces(pressure),
            "spectrum": analysis.draw_spectrum(power, pressure),
            "states": analysis.draw_states(wall, recorded),
            "velocity": analysis.draw_velocity(track, recorded, 3.0, behind=5.0),
            "difference": comparison.draw_difference(maps.compare(recorded, recorded)),
            "beside": comparison.draw_beside((recorded, recorded), (found, found), ((track,), ())),
        }
    for name, figure in drawn.items():
        for ending in ("png", "svg", "pdf") if name == "map" else ("png",):
            style.write(figure, tmp_path / f"{name}.{ending}", name, name)
    svg = (tmp_path / "map.svg").read_text(encoding="utf-8")
    for words in ("distance from the oral end (mm)", "time (s)", "inner diameter (mm)", "oral  0", "antegrade"):
        assert words in svg
    axes = drawn["map"].axes[0]
    assert axes.get_ylim() == (100.0, 0.0), "the oral end is on top"


def test_muscle_of_a_run_is_excited_where_and_when_the_recording_contracted(tmp_path: Path) -> None:
    """Both tables that a map writes drive a run. The ring is faster than what cells pass on, so its speed is kept."""
    ring = Ring(begin=1.0, place=10.0, speed=60.0, extent=70.0, amplitude=4.0)
    found = maps.contractions(maps.recording([ring], 24.0, noise=0.2))
    pressure = maps.recording([replace(ring, amplitude=1.0)], 24.0, quantity="pressure", rest=0.75)
    run = ps.run(
        "baseline",
        {
            "stimuli": f"table {courses.write_stimuli(found, tmp_path / 'again.csv', 2.0)}",
            "protocols": f"lumen.pressure: table {courses.write_course(pressure, 50.0, tmp_path / 'pressure.csv')}",
            "pacemaker.kind": "none",
            "reflex.enabled": False,
            "run.duration": "2.5 s",
            "grid.n_z": 250,
            "grid.n_z_wall": 200,
        },
    )
    begun = run.arrays["activation_circular"][:, 0]
    place = 100.0 * (np.arange(begun.size) + 0.5) / begun.size
    inside = (place > 12.0) & (place < 78.0)
    slowness, onset = np.polyfit(place[inside] - 10.0, begun[inside], 1)
    assert 1.0 / slowness == pytest.approx(60.0, rel=0.05)
    assert onset == pytest.approx(found[0].begin, abs=0.1)
