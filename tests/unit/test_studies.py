"""Study files: what is varied, by which design; refusals name the value, the cause and the fix."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import stats

from peristalsis.errors import ConfigurationError, ReadingNotFound
from peristalsis.many.studies import classes
from peristalsis.many.studies.designs import Design
from peristalsis.many.studies.distributions import Distribution
from peristalsis.many.studies.study import located_study, read_study
from peristalsis.many.studies.variables import read_variables
from peristalsis.scoring import sources

FRICTION = 'pellet.viscous_friction = { from = "60 mN*s/cm", to = "240 mN*s/cm", scale = "log", count = 3 }\n'
MUSCLE = 'muscle = { keys = ["longitudinal.active", "circular.active"], relative = true, from = 0.5, to = 1.0 }\n'
SHARES = np.array([0.0, 0.1, 0.5, 0.9, 1.0])


def study(parameters: str, design: str = 'kind = "grid"', head: str = ""):
    return read_study(f"{head}\n[design]\n{design}\n[parameters]\n{parameters}")


def test_a_logarithmic_grid_is_even_in_logarithms_and_has_its_ends_to_the_bit() -> None:
    points = study(FRICTION).points()
    assert [one.values["pellet.viscous_friction"] for one in points] == [60.0, pytest.approx(120.0, rel=1e-14), 240.0]
    assert points[2].configuration.pellet.viscous_friction == 240.0


def test_tied_parameters_get_one_factor_of_what_each_has() -> None:
    head = "[changes]\ncircular.active = 0.8"
    (point,) = study(MUSCLE, 'kind = "random"\nsamples = 1', head).points()
    factor = point.values["muscle"]
    assert 0.5 <= factor <= 1.0
    assert point.configuration.longitudinal.active == factor
    assert point.configuration.circular.active == factor * 0.8


def test_listed_values_and_names_are_combined_in_the_order_of_the_file() -> None:
    points = study('reading = ["tight", "printed"]\n"pellet.dry_friction" = ["10 mN", "0.02 N"]\n').points()
    assert [tuple(one.values.values()) for one in points] == [
        ("tight", 10.0), ("tight", 20.0), ("printed", 10.0), ("printed", 20.0),
    ]  # fmt: skip
    assert [one.configuration.reading for one in points] == ["tight", "tight", "printed", "printed"]
    listed = study('reading = ["tight", "printed"]\n"pellet.dry_friction" = ["10 mN", "0.02 N"]\n', 'kind = "list"')
    assert [tuple(one.values.values()) for one in listed.points()] == [("tight", 10.0), ("printed", 20.0)]


@pytest.mark.parametrize("kind", ["random", "sobol", "latin_hypercube"])
def test_drawn_designs_are_those_of_their_seed(kind: str) -> None:
    first = Design(kind, 16, 7).shares(3)
    assert np.array_equal(first, Design(kind, 16, 7).shares(3))
    assert not np.array_equal(first, Design(kind, 16, 8).shares(3))
    assert first.shape == (16, 3)
    assert ((first >= 0.0) & (first < 1.0)).all()


@pytest.mark.parametrize("kind", ["random", "sobol"])
def test_a_longer_design_begins_with_the_shorter_one(kind: str) -> None:
    """What makes an extended study run only what is missing."""
    assert np.array_equal(Design(kind, 40, 7).shares(3)[:16], Design(kind, 16, 7).shares(3))


@pytest.mark.parametrize("kind", ["sobol", "latin_hypercube"])
def test_even_designs_have_one_point_in_every_sixteenth(kind: str) -> None:
    """The defining property of a Latin hypercube, which 16 points of a Sobol' sequence have too."""
    for column in Design(kind, 16, 3).shares(4).T:
        assert sorted((16 * column).astype(int)) == list(range(16))


def test_quantiles_are_those_of_scipy() -> None:
    uniform = Distribution("uniform", low=2.0, high=4.0)
    assert uniform.quantiles(SHARES) == pytest.approx(2.0 + 2.0 * SHARES)
    log = Distribution("loguniform", low=1.0, high=100.0)
    assert log.quantiles(SHARES) == pytest.approx(stats.loguniform(1.0, 100.0).ppf(SHARES))
    normal = Distribution("normal", mean=5.0, deviation=2.0)
    assert normal.quantiles(SHARES[1:-1]) == pytest.approx(stats.norm(5.0, 2.0).ppf(SHARES[1:-1]))
    wide = Distribution("lognormal", median=3.0, spread=2.0)
    assert wide.quantiles(SHARES[1:-1]) == pytest.approx(stats.lognorm(math.log(2.0), scale=3.0).ppf(SHARES[1:-1]))


def test_a_cut_distribution_keeps_its_shape_between_its_ends() -> None:
    cut = Distribution("normal", low=4.0, mean=5.0, deviation=2.0)
    whole, below = stats.norm(5.0, 2.0), stats.norm(5.0, 2.0).cdf(4.0)
    assert cut.quantiles(SHARES[:-1]) == pytest.approx(whole.ppf(below + SHARES[:-1] * (1.0 - below)))
    both = Distribution("lognormal", low=2.0, high=8.0, median=3.0, spread=2.0)
    assert both.quantiles(np.array([0.0, 1.0])) == pytest.approx([2.0, 8.0])


@pytest.mark.parametrize(
    ("parameters", "said"),
    [
        ("", "nothing is varied"),
        ("pellet.radios = [1]\n", "did you mean pellet.radius"),
        ('mine = { from = "1 mN", to = "2 mN" }\n', "needs keys"),
        ("pellet.dry_friction = { from = 1, to = 2 }\n", "the unit is missing"),
        ('pellet.dry_friction = { from = "2 mN", to = "1 mN", count = 2 }\n', "exchange them"),
        ('pellet.dry_friction = { from = "0 mN", to = "1 mN", scale = "log", count = 2 }\n', "no logarithm"),
        ('pellet.dry_friction = { from = "1 mN" }\n', "to is missing"),
        ('pellet.dry_friction = { mean = "1 mN", distribution = "normal" }\n', "deviation is missing"),
        ('pellet.dry_friction = { from = "1 mN", to = "2 mN", mean = "1 mN" }\n', "no mean"),
        ('pellet.dry_friction = { from = "1 mN", to = "2 mN", distribution = "beta" }\n', "choose one of"),
        ('pellet.dry_friction = { from = "1 mN", to = "2 mN" }\n', "give count"),
        ('pellet.dry_friction = { values = ["1 mN"], from = "2 mN" }\n', "keep one"),
        ('pellet.dry_friction = ["1 mN", "0.001 N"]\n', "listed twice"),
        ('mine = { keys = ["pellet.radius", "pellet.dry_friction"], values = ["1 cm"] }\n', "relative = true"),
        (f'{FRICTION}f = {{ keys = ["pellet.viscous_friction"], values = ["1 mN*s/cm"] }}\n', "varied twice"),
    ],
)
def test_refusals_of_parameters(parameters: str, said: str) -> None:
    with pytest.raises(ConfigurationError, match=said):
        study(parameters).points()


@pytest.mark.parametrize(
    ("design", "head", "said"),
    [
        ('kind = "sobol"', "", "needs their number"),
        ('kind = "sobol"\nsamples = 0', "", "from 1"),
        ('kind = "grid"\nsamples = 3', "", "leave samples out"),
        ('kind = "random"\nsamples = 3\nseed = -1', "", "from 0"),
        ('kind = "soboll"\nsamples = 3', "", "did you mean sobol"),
        ('kind = "random"\nsamples = 1000000', "", "divide it"),
        ('kind = "grid"', 'outputs = ["transits"]', "did you mean"),
        ('kind = "grid"', "outputs = []", "list of names"),
        ('kind = "grid"', 'scenario = "nowhere"', "no such scenario"),
        ('kind = "grid"', "parameter = 1", "did you mean parameters"),
    ],
)
def test_refusals_of_studies(design: str, head: str, said: str) -> None:
    with pytest.raises(ConfigurationError, match=said):
        study(FRICTION, design, head).points()


def test_a_refused_value_spoils_its_point_alone() -> None:
    points = study('pellet.radius = ["0.9 cm", "-1 cm"]\n').points()
    assert points[0].configuration is not None
    assert points[1].configuration is None
    assert "pellet.radius" in str(points[1].refusal)


def test_classifiers_have_names() -> None:
    row = {"status": "arrested", "transit_s": None}
    assert classes.get("expelled")(row) == "not expelled"
    assert classes.get("peristalsis.many.studies.classes:status")(row) == "arrested"
    classes.register("mine", lambda row: "all")
    with pytest.raises(ConfigurationError, match="choose another name"):
        classes.register("mine", lambda row: "other")
    classes.forget("mine")
    for name in ("mine", "nowhere:f", "peristalsis.many.studies.classes:f", "math:pi"):
        with pytest.raises(ConfigurationError, match="classes"):
            classes.get(name)


@pytest.mark.parametrize("wave", [{"wave_speed_cm_s.circular": 6.0}, {"wave_speed_cm_s": {"circular": 6.0}}])
def test_motion_is_told_by_the_wave_and_by_the_travel(wave: dict[str, object]) -> None:
    """A wave of 6 cm/s needs 1.5 s for 9 cm; a pellet that needs a quarter more than that still rides it."""
    motion = classes.get("motion")
    for transit, travel, said in (
        (1.5 * 1.25, 9.0, classes.RIDES),
        (1.5 * 1.26, 9.0, classes.CAUGHT),
        (None, 0.5, classes.LEFT),
        (None, 0.49, classes.ARRESTED),
        (None, None, ""),
    ):
        assert motion({"status": "any", "transit_s": transit, "travel_cm": travel, **wave}) == said
    assert motion({"transit_s": 1.5, "travel_cm": 9.0}) == classes.CAUGHT, "without a wave there is none to ride"
    assert motion({"oral_exit_s": 1.0, "travel_cm": -1.0}) == "expelled orally"


def test_a_search_and_a_map_call_one_motion_by_one_name() -> None:
    space = sources.get("paper").space
    assert space is not None
    row = {"transit_s": 2.0, "travel_cm": 9.0, "wave_speed_cm_s": {"circular": 6.0}}
    for transit in (1.0, 1.8, 1.9, 4.0, None):
        told = {**row, "transit_s": transit}
        assert space.edge.regime(told) == classes.motion(told, space.edge.rides_within)
    assert space.edge.rides_within == classes.WITHIN


def test_another_reading_than_that_of_the_file() -> None:
    tight = study(MUSCLE, 'kind = "sobol"\nsamples = 2')
    edge = located_study(tight, reading="edge")
    for one, two in zip(tight.points(), edge.points(), strict=True):
        assert (one.configuration.reading, two.configuration.reading) == ("tight", "edge")
        assert two.configuration.circular.active == pytest.approx(0.513859 * one.configuration.circular.active)
    with pytest.raises(ReadingNotFound):
        located_study(tight, reading="no such")
    varied = read_study('[parameters]\nreading = ["tight", "edge"]\n')
    with pytest.raises(ConfigurationError, match="varies the reading itself"):
        located_study(varied, reading="edge")


def test_nested_tables_and_quoted_names_are_the_same() -> None:
    ends = {"from": "1 mN", "to": "2 mN"}
    assert read_variables({"pellet": {"dry_friction": ends}}) == read_variables({"pellet.dry_friction": ends})
