"""Dose and response: Hill's curve found again, its bands, and a study of an agent from end to end."""

import csv

import numpy as np
import pytest

import peristalsis as ps
from peristalsis.cli.dispatch import dispatch
from peristalsis.errors import ConfigurationError
from peristalsis.many.dose_response import dose_response
from peristalsis.many.hill_curve import crossing, fit_hill_curve

CONCENTRATIONS = np.geomspace(1.0, 1000.0, 9)
TINY = {"grid.n_z": 80, "grid.n_z_wall": 60, "run.duration": "0.8 s"}


def hill(half, slope, bottom):
    return 1.0 + (bottom - 1.0) / (1.0 + (half / CONCENTRATIONS) ** slope)


@pytest.mark.parametrize("half", [3.0, 30.0, 400.0])
@pytest.mark.parametrize("slope", [0.7, 1.0, 2.5])
@pytest.mark.parametrize("bottom", [0.0, 0.4, 1.3])
def test_an_exact_curve_is_found_again(half, slope, bottom):
    found = fit_hill_curve(CONCENTRATIONS, hill(half, slope, bottom), resampled=5)
    assert found.half == pytest.approx(half, rel=1e-3)
    assert found.slope == pytest.approx(slope, rel=1e-3)
    assert found.bottom == pytest.approx(bottom, abs=1e-3)
    assert found.error < 1e-6


def test_the_band_holds_the_truth_as_often_as_it_says():
    chance, held, widths = np.random.default_rng(3), 0, []
    for seed in range(40):
        noisy = hill(30.0, 1.0, 0.2) + chance.normal(0.0, 0.02, CONCENTRATIONS.size)
        found = fit_hill_curve(CONCENTRATIONS, noisy, seed, resampled=150)
        held += found.half_band[0] <= 30.0 <= found.half_band[1]
        widths.append(found.half_band[1] / found.half_band[0])
    # 40 draws with 0.95 give 33 or fewer in one case of a thousand; a band of a tenth of the width holds it 4 times.
    assert held >= 33
    assert np.median(widths) < 1.5


def test_what_has_no_half_effect_says_why():
    assert "nothing changes" in fit_hill_curve(CONCENTRATIONS, np.full(9, 1.001)).reason
    few = np.full(9, np.nan)
    few[:3] = 0.5
    assert "too few" in fit_hill_curve(CONCENTRATIONS, few).reason
    far = fit_hill_curve(CONCENTRATIONS, hill(9000.0, 1.0, 0.0), resampled=5)
    assert "extrapolation" in far.reason
    step = fit_hill_curve(CONCENTRATIONS, np.where(CONCENTRATIONS > 30.0, 0.2, 1.0), resampled=5)
    assert "in a step" in step.reason


def test_the_crossing_lies_between_two_points_on_a_logarithmic_axis():
    assert crossing(np.array([1.0, 100.0]), np.array([0.75, 0.25])) == pytest.approx(10.0)
    assert crossing(np.array([1.0, 100.0]), np.array([0.9, 0.6])) is None


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    out = tmp_path_factory.mktemp("dose")
    base = ps.configuration("baseline", changes=TINY)
    kept = []

    def ask(agent, low, high, library=None, beside=()):
        kept.clear()
        return dose_response(
            agent,
            low,
            high,
            scenario=base,
            points=5,
            library_file=library,
            beside=beside,
            out=out,
            progress=lambda step: kept.append(step.kept),
        )

    return ask, kept


def test_a_study_has_a_row_for_every_concentration_and_runs_nothing_twice(study):
    ask, kept = study
    found = ask("nickel", "10 uM", "10 mM", "l_type_is_fast")
    assert len(found.rows) == 5
    assert found.share("speed").shape == (5,)
    assert np.isfinite(found.share("force")).all()
    again = ask("nickel", "10 uM", "10 mM", "l_type_is_fast")
    assert all(kept)
    assert again.csv() == found.csv()
    rows = list(csv.DictReader(found.csv().splitlines()))
    assert [row["status"] for row in rows] == [found.control.status, *(one.status for one in found.rows)]
    # The factor on the conductance is Hill's curve of the library: 250 uM, slope 1.
    first = float(rows[1]["concentration_nM"])
    assert float(rows[1]["factor on T-type"]) == pytest.approx(1.0 / (1.0 + first / 250e3))


def test_only_the_ratio_to_the_ic50_counts_so_its_range_shifts_the_axis(study):
    # Agents of one target and one slope are one and the same on an axis of c / IC50, but for its rounding.
    ask, _ = study
    one, two = ask("iberiotoxin", "0.116 nM", "116 nM"), ask("charybdotoxin", "1.16 nM", "1160 nM")
    np.testing.assert_allclose(one.share("speed"), two.share("speed"), rtol=1e-9)
    nickel = ask("nickel", "10 uM", "10 mM")
    assert nickel.uncertainty == pytest.approx((30.0 / 250.0, 1.0))
    assert one.uncertainty is None


def test_what_acts_beside_acts_on_the_control_too(study):
    ask, _ = study
    alone, beside = ask("nickel", "10 uM", "10 mM"), ask("nickel", "10 uM", "10 mM", beside=("lubricant 0.5",))
    assert beside.control.summary["travel_cm"] != alone.control.summary["travel_cm"]
    with pytest.raises(ConfigurationError, match="given twice"):
        ask("nickel", "10 uM", "10 mM", beside=("nickel 1 uM",))


@pytest.mark.parametrize(
    ("low", "high", "points", "said"),
    [
        ("0 nM", "1 nM", 9, "above 0"),
        ("5 nM", "1 nM", 9, "rise"),
        ("1 nM", "1 uM", 2, "points = 2"),
        ("1 kPa", "1 uM", 9, "cannot be converted"),
        ("1 nM", "1.0001 nM", 9, "too many between"),
    ],
)
def test_concentrations_that_are_none_are_refused(low, high, points, said, tmp_path):
    with pytest.raises(ConfigurationError, match=said):
        dose_response("nifedipine", low, high, points=points, out=tmp_path)


def test_the_command_writes_table_and_picture(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    options = [word for key, value in TINY.items() for word in ("--set", f"{key}={value}")]
    words = ["dose-response", "nickel", "--from", "10 uM", "--to", "10 mM", "--points", "5", "--out", "o", *options]
    assert dispatch(words) == 0
    said = capsys.readouterr().out
    assert "not medical advice" in said
    assert (tmp_path / "o" / "dose_response.png").stat().st_size > 10_000
    assert len((tmp_path / "o" / "table.csv").read_text().splitlines()) == 7
