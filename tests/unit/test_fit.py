"""Fits of tracks: on a model whose answer is known by hand, its failures, and one real run from end to end."""

import math

import numpy as np
import pytest

import peristalsis as ps
from peristalsis import maps
from peristalsis.cli.dispatch import dispatch
from peristalsis.errors import ConfigurationError
from peristalsis.inputs.config import Configuration
from peristalsis.many.fitting import fit, free_parameters, observed, problem
from peristalsis.many.fitting.problem import Offsets, track_at
from peristalsis.many.rows import Point, Row, Step
from peristalsis.maps.recording import Track

TIMES = np.linspace(0.1, 2.0, 25)
VISCOUS, DRY = "pellet.viscous_friction", "pellet.dry_friction"
FORCE = 500.0
RAN = []


def positions(configuration, time):
    """1 cm + speed x time, speed = (500 mN - dry) / viscous, a bend that the circular active force sets, and a jump."""
    speed = (FORCE - configuration.pellet.dry_friction) / configuration.pellet.viscous_friction
    jump = 0.1 if configuration.longitudinal.active > 1.5 and configuration.pellet.viscous_friction > 180.5 else 0.0
    return 1.0 + jump + speed * time - 0.5 * configuration.circular.active * np.sin(2.0 * time)


def by_formula(configurations, folder, measure, workers, progress):
    rows = {}
    for name, configuration in configurations.items():
        RAN.append(name)
        time = np.arange(0.0, configuration.run.duration + 0.0025, 0.005)
        if configuration.pellet.viscous_friction > 900.0:
            row = Row({"status": "diverged", "error": "it came apart"})
        else:
            row = Row({"status": "expelled"}, {"time_step": time, "pellet_position": positions(configuration, time)})
        rows[name] = row
        progress(Step(Row(row.summary, row.arrays, Point(name, configuration=configuration)), 1, 1, False))
    return rows


@pytest.fixture(autouse=True)
def formula(monkeypatch, request):
    if "real" not in request.node.name:
        RAN.clear()
        monkeypatch.setattr(problem, "sweep", by_formula)


def seen(noise=0.0, seed=0, name="a", **changes):
    truth = ps.configuration("baseline", changes={VISCOUS: "180 mN*s/cm", **changes})
    chance = np.random.default_rng(seed)
    return Track(
        TIMES, 10.0 * positions(truth, TIMES) + chance.normal(0.0, 10.0 * noise, TIMES.size) * (noise > 0), name
    )


def test_an_exact_track_gives_the_truth_back(tmp_path):
    found = fit([seen()], [VISCOUS], out=tmp_path)
    assert found.success
    assert found.values[VISCOUS] == pytest.approx(180.0, rel=1e-5)
    assert found.configuration.pellet.viscous_friction == found.values[VISCOUS]
    assert Configuration.from_toml(found.configuration.to_toml()) == found.configuration


def test_the_interval_is_that_of_linear_theory_and_the_profile_agrees(tmp_path):
    sigma = 0.02
    found = fit([seen(sigma)], [VISCOUS], noise=sigma, out=tmp_path)
    value = found.values[VISCOUS]
    # d place / d viscous = -speed t / viscous: the standard error by hand.
    speed = (FORCE - 20.0) / value
    error = sigma / math.sqrt(float(np.sum((speed * TIMES / value) ** 2)))
    low, high = found.estimates[0].interval
    # Differences of one per cent of 1 / viscous are off by half a per cent of themselves.
    assert (high - low) / (2 * 1.96 * error) == pytest.approx(1.0, abs=0.02)
    by_profile = found.estimates[0].profile
    assert by_profile == pytest.approx((low, high), rel=0.003)


def test_the_interval_holds_the_truth_as_often_as_it_says(tmp_path):
    held = 0
    for seed in range(24):
        found = fit([seen(0.02, seed)], [VISCOUS, "circular.active"], profiles=False, out=tmp_path)
        low, high = found.estimates[0].interval
        held += low <= 180.0 <= high
    # With 0.95, 18 or fewer of 24 come up less than once in a thousand.
    assert held >= 19


def test_what_the_track_cannot_tell_apart_is_said(tmp_path):
    # One speed determines (force - dry) / viscous alone.
    found = fit([seen(0.02)], [VISCOUS, DRY], out=tmp_path, bounds={DRY: ("0 mN", "100 mN")})
    assert any("can hardly be told apart" in one for one in found.remarks())
    assert abs(found.correlation[0, 1]) > 0.999
    assert None in found.estimates[1].profile
    # Along the profile of one the other follows: (500 - dry) / viscous stays.
    points = found.profiles[DRY].others
    viscous, dry = np.exp(points[:, 0]), points[:, 1] * found.problem.free[1].scale
    ratio = (FORCE - dry) / viscous
    assert np.ptp(dry) > 50.0
    assert np.ptp(ratio) / ratio.mean() < 0.01


def test_two_tracks_under_different_conditions_tell_them_apart(tmp_path):
    alone = fit([seen(0.005)], [VISCOUS, "circular.active"], out=tmp_path, profiles=False)
    more = {"circular.active": 0.3}
    pair = [seen(0.005), (seen(0.005, 1, "b", **more), more)]
    both = fit(pair, [VISCOUS], out=tmp_path, profiles=False)
    assert both.values[VISCOUS] == pytest.approx(180.0, rel=0.01)
    assert both.problem.size == 2 * TIMES.size
    assert alone.success


def test_offsets_that_are_stated_are_taken_away_and_free_ones_are_found(tmp_path):
    moved = Track(TIMES + 0.3, seen().position + 12.0, "moved")
    given = fit(observed([moved], time_offset=0.3, place_offset=1.2), [VISCOUS], out=tmp_path, profiles=False)
    assert given.values[VISCOUS] == pytest.approx(180.0, rel=1e-5)
    dated = observed([moved], time_offset=0.3)
    found = fit(dated, [VISCOUS], free_offsets=Offsets(place=True), out=tmp_path, profiles=False)
    assert found.values[VISCOUS] == pytest.approx(180.0, rel=1e-4)
    assert found.numbers()["offsets"]["place of moved"] == pytest.approx(1.2, abs=1e-4)
    # A bend in the track dates it.
    dated = Track(TIMES + 0.05, seen().position, "dated")
    found = fit([dated], [VISCOUS, "circular.active"], free_offsets=Offsets(time=True), out=tmp_path, profiles=False)
    assert found.numbers()["offsets"]["time of dated"] == pytest.approx(0.05, abs=1e-3)


def test_runs_that_fail_at_the_start_are_no_success(tmp_path):
    base = ps.configuration("baseline", changes={VISCOUS: "950 mN*s/cm"})
    found = fit([seen()], [VISCOUS], scenario=base, out=tmp_path)
    assert found.status == "failed"
    assert not found.success
    assert "it came apart" in found.message


def test_runs_that_fail_on_the_way_are_stepped_back_from(tmp_path):
    # Slow: the first step from 300 leads beyond 900, where runs diverge; the answer is 700.
    slow = ps.configuration("baseline", changes={VISCOUS: "700 mN*s/cm"})
    track = Track(TIMES, 10.0 * positions(slow, TIMES))
    base = ps.configuration("baseline", changes={VISCOUS: "300 mN*s/cm"})
    found = fit([track], [VISCOUS], scenario=base, out=tmp_path, profiles=False)
    assert found.success
    assert found.values[VISCOUS] == pytest.approx(700.0, rel=1e-3)


def test_a_derivative_is_taken_to_the_side_on_which_runs_succeed(tmp_path):
    edge = ps.configuration("baseline", changes={VISCOUS: "899 mN*s/cm"})
    track = Track(TIMES, 10.0 * positions(edge, TIMES))
    found = fit([track], [VISCOUS], scenario=edge, out=tmp_path, profiles=False)
    assert found.success
    assert found.values[VISCOUS] == pytest.approx(899.0, rel=1e-3)


def test_a_parameter_at_its_bound_is_said(tmp_path):
    found = fit([seen()], [VISCOUS], bounds={VISCOUS: ("200 mN*s/cm", "400 mN*s/cm")}, out=tmp_path, profiles=False)
    assert any("at its bound" in one for one in found.remarks())


def test_a_model_that_misses_the_shape_is_said(tmp_path):
    bent = Track(TIMES, seen().position + 2.0 * np.sin(3.0 * TIMES), "bent")
    found = fit([bent], [VISCOUS], out=tmp_path, profiles=False)
    assert any("neighbouring residuals are alike" in one for one in found.remarks())


def test_a_model_that_jumps_beside_the_answer_is_said(tmp_path):
    rough = ps.configuration("baseline", changes={"longitudinal.active": 2.0, VISCOUS: "180 mN*s/cm"})
    jumping, smooth = (
        fit([seen(0.02)], [VISCOUS], scenario=base, out=tmp_path, profiles=False)
        for base in (rough, ps.configuration("baseline"))
    )
    assert any("track jumps where pellet.viscous_friction" in one for one in jumping.remarks())
    assert smooth.remarks() == ()


def test_tied_parameters_have_one_value(tmp_path):
    both = "longitudinal.fast_calcium+circular.fast_calcium"
    one = free_parameters([both], ps.configuration("baseline"))[0]
    assert one.changes(math.log(3.0)).keys() == {"longitudinal.fast_calcium", "circular.fast_calcium"}
    assert len(set(one.changes(math.log(3.0)).values())) == 1


def test_a_track_that_says_nothing_of_a_parameter_has_its_bounds_as_interval(tmp_path):
    # The active force of the longitudinal layer is in no track of this model.
    found = fit([seen(0.02)], ["longitudinal.active"], out=tmp_path)
    assert found.estimates[0].interval == (found.problem.free[0].low, found.problem.free[0].high)
    assert found.estimates[0].profile == (None, None)


@pytest.mark.parametrize(
    ("free", "bounds", "said"),
    [
        (["pellet.viscous"], None, "did you mean pellet.viscous_friction"),
        (["pellet.enabled"], None, "no number"),
        ([], None, "name one"),
        ([VISCOUS, VISCOUS], None, "named twice"),
        ([VISCOUS], {DRY: ("0 mN", "1 mN")}, "is not free"),
        ([VISCOUS], {VISCOUS: ("1 mN*s/cm", "2 mN*s/cm")}, "set a start within"),
        ([VISCOUS], {VISCOUS: ("1 mN", "2 mN")}, "cannot be converted"),
        (["longitudinal.conductivity_scale+circular.conductivity_scale"], None, "begin with one value"),
        (["pellet.start_gap"], None, "state bounds"),
    ],
)
def test_what_cannot_be_free_is_refused(free, bounds, said):
    base = ps.configuration("baseline", changes={"pellet.start_gap": "0 cm"} if free == ["pellet.start_gap"] else {})
    with pytest.raises(ConfigurationError, match=said):
        free_parameters(free, base, bounds)


def test_tracks_that_the_model_cannot_have_are_refused(tmp_path):
    with pytest.raises(ConfigurationError, match="before the model starts"):
        fit(observed([seen()], time_offset=10.0), [VISCOUS], out=tmp_path)
    with pytest.raises(ConfigurationError, match="state the scale"):
        fit([Track(TIMES, 100.0 * seen().position)], [VISCOUS], out=tmp_path)
    with pytest.raises(ConfigurationError, match="too few"):
        fit([Track(TIMES[:3], seen().position[:3])], [VISCOUS, DRY, "circular.active"], out=tmp_path)
    with pytest.raises(ConfigurationError, match="no track to fit"):
        fit([seen()], [VISCOUS], scenario=ps.configuration("baseline", changes={"pellet.enabled": False}), out=tmp_path)


def test_a_pellet_that_is_out_goes_on_as_it_left():
    time = np.linspace(0.0, 1.0, 201)
    row = Row({"status": "expelled"}, {"time_step": time, "pellet_position": 1.0 + 2.0 * time})
    assert track_at(row, np.array([-0.5, 0.5, 1.25])) == pytest.approx([1.0, 2.0, 3.5])


def test_pixels_and_frames_are_read_with_their_scale(tmp_path):
    file = tmp_path / "video.csv"
    file.write_text("frame,position [px]\n0,100\n30,200\n60,310\n")
    one = maps.tracks(file, scale=(0.1, 30.0))[0]
    np.testing.assert_allclose(one.time, [0.0, 1.0, 2.0])
    np.testing.assert_allclose(one.position, [10.0, 20.0, 31.0])
    assert observed(file, scale=(0.1, 30.0), place_offset=1.0)[0].place == pytest.approx([0.0, 1.0, 2.1])
    with pytest.raises(ConfigurationError, match="millimetres a pixel"):
        maps.tracks(file)
    with pytest.raises(ConfigurationError, match="above 0"):
        maps.tracks(file, scale=(0.0, 30.0))
    file.write_text("time [s],position [mm]\n0,1\n1,2\n")
    assert maps.tracks(file, scale=(0.1, 30.0))[0].position.tolist() == [1.0, 2.0]


def test_the_command_writes_what_can_be_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    maps.write_tracks([seen(0.02)], tmp_path / "track.csv")
    assert dispatch(["fit", "track.csv", "--free", VISCOUS, "--out", "o"]) == 0
    said = capsys.readouterr().out
    assert "95 % by profile" in said
    assert 170.0 < Configuration.from_toml(tmp_path / "o" / "fit.toml").pellet.viscous_friction < 190.0
    assert (tmp_path / "o" / "fit.png").stat().st_size > 10_000
    assert len((tmp_path / "o" / "residuals.csv").read_text().splitlines()) == TIMES.size + 1
    words = ["fit", "track.csv", "--free", VISCOUS, "--set", f"{VISCOUS}=950 mN*s/cm", "--out", "p", "--json"]
    assert dispatch(words) == 3
    assert "it came apart" in capsys.readouterr().err
    assert not (tmp_path / "p" / "fit.toml").exists()


def test_a_real_run_is_fitted_and_a_second_fit_runs_nothing(tmp_path):
    base = ps.configuration("baseline", changes={"grid.n_z": 100, "grid.n_z_wall": 80, "run.duration": "0.7 s"})
    truth = ps.run(
        base.scenario, {"grid.n_z": 100, "grid.n_z_wall": 80, "run.duration": "0.7 s", VISCOUS: "180 mN*s/cm"}
    )
    time, place = truth.arrays["time_step"], truth.arrays["pellet_position"]
    at = np.linspace(0.2, 0.65, 12)
    track = Track(at, 10.0 * np.interp(at, time, place))
    found = fit([track], [VISCOUS], scenario=base, out=tmp_path, profiles=False)
    assert found.success
    assert found.values[VISCOUS] == pytest.approx(180.0, rel=1e-3)
    again = fit([track], [VISCOUS], scenario=base, out=tmp_path, profiles=False)
    assert again.problem.runs == 0
    assert again.values == found.values


@pytest.mark.parametrize("noise", [-0.1, 0.0, float("nan"), float("inf")])
def test_a_deviation_that_is_none_is_refused_before_anything_is_run(tmp_path, noise):
    with pytest.raises(ConfigurationError, match="is no deviation of a position; give one above 0 cm"):
        fit([seen()], [VISCOUS], noise=noise, out=tmp_path)
    assert not list(tmp_path.iterdir())


def test_bounds_that_do_not_rise_say_so():
    bounds = {VISCOUS: ("300 mN*s/cm", "100 mN*s/cm")}
    with pytest.raises(ConfigurationError, match=r"300 to 100 mN.s/cm do not rise; give the smaller one first"):
        free_parameters([VISCOUS], ps.configuration("baseline"), bounds)
