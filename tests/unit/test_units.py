"""Quantities at the edge: exact round trips, conversions against hand arithmetic, one-line refusals."""

import contextlib
import math
import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from peristalsis.errors import ConfigurationError
from peristalsis.units import CANONICAL_UNITS, format_quantity, parse, to_internal

FINITE = st.floats(allow_nan=False, allow_infinity=False)


@given(value=FINITE, unit=st.sampled_from(CANONICAL_UNITS))
def test_written_quantities_read_back_bit_for_bit(value: float, unit: str) -> None:
    read = parse(format_quantity(value, unit), unit, "key")
    assert read.hex() == (value + 0.0).hex()  # negative zero loses its sign, nothing else changes


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("9 mm", "cm", 0.9),
        ("7 mm", "cm", 0.7),  # 7 * 0.1 would be 0.7000000000000001
        ("0.009m", "cm", 0.9),
        ("23 N*s/m", "mN*s/cm", 230.0),  # 23 * 1000 mN / 100 cm
        ("230 mN s/cm", "mN*s/cm", 230.0),
        ("230 mN·s/cm", "mN*s/cm", 230.0),
        ("20 N", "mN", 20000.0),
        ("100 Pa", "kPa", 0.1),
        ("1 mbar", "kPa", 0.1),
        ("10 cmH2O", "kPa", 0.980665),
        ("26.14 g/cm^2", "mg/cm^2", 26140.0),
        ("26.14 g/cm2", "mg/cm^2", 26140.0),
        ("26.14 mg/cm²", "mg/cm^2", 26.14),
        ("4 µA/cm^2", "uA/cm^2", 4.0),
        ("4 μA/cm²", "uA/cm^2", 4.0),
        ("0.04 mA/cm**2", "uA/cm^2", 40.0),
        ("40 S/m^2", "mS/cm^2", 4.0),
        ("200 us", "ms", 0.2),
        ("0.3 1/s", "1/ms", 0.0003),
        ("40 N/(m*mV)", "mN/(cm*mV)", 400.0),
        ("105 %", "1", 1.05),
        ("0.5", "1", 0.5),
        ("-55 mV", "mV", -55.0),
        ("+1.5e1 cm", "cm", 15.0),
        (".5 cm", "cm", 0.5),
        ("0 mm", "cm", 0.0),
    ],
)
def test_conversions_are_the_nearest_float(text: str, unit: str, expected: float) -> None:
    assert parse(text, unit, "key") == expected


def test_millimetres_of_mercury() -> None:
    assert parse("1 mmHg", "kPa", "key") == pytest.approx(0.133322, rel=1e-5)


@pytest.mark.parametrize("number", [0.9, 1, 0])
def test_bare_numbers_are_for_dimensionless_parameters_only(number: float) -> None:
    assert parse(number, "1", "wall.c4") == number
    with pytest.raises(ConfigurationError, match=r"pellet\.radius = .*unit is missing.*'0\.9 cm'"):
        parse(number, "cm", "pellet.radius")


def test_a_text_without_unit_is_refused_for_a_dimensional_parameter() -> None:
    with pytest.raises(ConfigurationError, match="unit is missing"):
        parse("0.9", "cm", "pellet.radius")


@pytest.mark.parametrize(
    "value",
    [
        *("nan", "inf cm", "-inf cm", "nan cm", "1e400 cm", "1e308 km", "", " ", "cm", "one cm", "0.9 kPa"),
        *(
            "0.9 furlongz",
            "0.9 kpa",
            "0.9 cm cm",
            "0.9 cm/",
            "0.9 (cm",
            "0.9 )cm(",
            "0.9 cm^99",
            "0.9 cm^4^4",
        ),
        *("0.9 2 cm", "0.9 cm; cm", "0.9 __import__('os')", "0.9 cm" + " " * 200, "9" * 200, "0x10 cm"),
        *("1_0 cm", "0.9 cm\x00", "0.9 degC", "0.9 dB", "\ud800 cm", "٣ cm"),
        *(True, None, [], {}, b"0.9 cm", 1j, math.nan, math.inf, object()),
    ],
    ids=ascii,
)
def test_what_is_not_a_length_is_refused_in_one_line(value: object) -> None:
    with pytest.raises(ConfigurationError, match=r"^key = ") as caught:
        parse(value, "cm", "key")
    message = str(caught.value)
    assert "\n" not in message
    assert message.isascii()
    assert len(message) < 300


@pytest.mark.parametrize(
    "value",
    [math.nan, math.inf, -math.inf, 10**400, 10**5000, True, "1e400", "inf", "1 cm"],
    ids=lambda value: type(value).__name__,
)
def test_what_is_not_a_plain_number_is_refused(value: object) -> None:
    with pytest.raises(ConfigurationError):
        parse(value, "1", "key")


def test_a_misspelled_unit_is_answered_with_the_nearest() -> None:
    with pytest.raises(ConfigurationError, match="did you mean kPa"):
        parse("1 kpa", "kPa", "lumen.pressure")


@given(text=st.text(max_size=60), unit=st.sampled_from(CANONICAL_UNITS))
def test_no_text_raises_anything_else(text: str, unit: str) -> None:
    for candidate in (text, f"1 {text}", f"1e3{text}"):
        with contextlib.suppress(ConfigurationError):
            assert math.isfinite(parse(candidate, unit, "key"))


@given(text=st.text(alphabet="cmNskgVP%_1^*/()-24 eE", max_size=30))
def test_no_unit_text_raises_anything_else(text: str) -> None:
    with contextlib.suppress(ConfigurationError):
        assert math.isfinite(parse(f"2 {text}", "mN*s/cm", "key"))


def test_internal_units() -> None:
    assert to_internal(0.1, "kPa") == 10.0  # mN/cm^2
    assert to_internal(26.14, "mg/cm^2") == pytest.approx(26.14e-5, rel=1e-15)  # mN s^2/cm^3
    assert to_internal(200.0, "ms") == pytest.approx(0.2, rel=1e-15)
    assert to_internal(0.9, "cm") == 0.9
    with pytest.raises(ConfigurationError, match="no internal factor"):
        to_internal(1.0, "furlong")


@pytest.mark.parametrize("unit", [unit for unit in CANONICAL_UNITS if unit not in ("1", "1/mV")])
def test_internal_factors_agree_with_dimensional_analysis(unit: str) -> None:
    """The table is written by hand; an independent unit library must give the same factors."""
    pint = pytest.importorskip("pint")
    registry = pint.UnitRegistry()
    quantity = registry.Quantity(1.0, unit)
    electrical = any(symbol in unit for symbol in ("mS", "uA", "uF"))
    # The system is mN, cm, s; mV and the electrical densities stay as they are.
    systems = [unit] if electrical else ["mN", "mN/cm", "mN/cm^2", "mN*s/cm", "mN*s^2/cm^3", "cm", "s", "1/s"]
    systems += ["mN*cm", "mN*s*cm", "mN/cm^3", "mV", "mN/(cm*mV)", "rad"]
    target = next(system for system in systems if quantity.check(registry.Unit(system).dimensionality))
    assert to_internal(1.0, unit) == pytest.approx(quantity.to(target).magnitude, rel=1e-12)


def test_canonical_units_do_not_load_the_unit_library() -> None:
    code = (
        "import sys; from peristalsis.units import parse; parse('0.9 cm', 'cm', 'k'); "
        "parse('1 mN s/cm', 'mN*s/cm', 'k'); assert 'pint' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
