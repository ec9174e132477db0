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
        *(True, None, [], {}, b"0.9 cm", 1j, math.nan, math.inf, object),
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
    systems = [unit] if electrical else ["mN", "mN/cm", "mN/cm^2", "mN*s/cm", "mN*s^2/cm^3", "cm", "s", "1/s", "s/cm"]
    systems += ["mN*cm", "mN*s*cm", "mN/cm^3", "mV", "mN/(cm*mV)", "rad", "cm^2/s", "cm/s", "K"]
    target = next(system for system in systems if quantity.check(registry.Unit(system).dimensionality))
    assert to_internal(1.0, unit) == pytest.approx(quantity.to(target).magnitude, rel=1e-12)


def test_canonical_units_do_not_load_the_unit_library() -> None:
    code = (
        "import sys; from peristalsis.units import parse; parse('0.9 cm', 'cm', 'k'); "
        "parse('1 mN s/cm', 'mN*s/cm', 'k'); assert 'pint' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


SPELLINGS = {
    "cm": ("cm",),
    "deg": ("deg", "°"),
    "1/ms": ("1/ms", "ms⁻¹", "ms-1", "ms^-1", "1 / ms"),
    "1/mV": ("1/mV", "mV⁻¹"),
    "mN*cm": ("mN*cm", "mN·cm", "mN×cm", "mN.cm", "mN cm", "mN ⋅ cm"),
    "mN*s/cm": ("mN*s/cm", "mN.s/cm", "mN·s·cm⁻¹", "mN s cm-1", "mN × s / cm"),
    "mN/cm^3": ("mN/cm³", "mN·cm⁻³", "mN/cm3", "mN.cm-3"),
    "mN/(cm*mV)": ("mN/(cm·mV)", "mN/(cm.mV)", "mN·cm⁻¹·mV⁻¹"),
    "kPa": ("kPa",),
    "mg/cm^2": ("mg/cm²", "mg·cm⁻²", "mg cm-2"),
    "mS/cm^2": ("mS/cm²", "mS·cm⁻²", "mS.cm-2"),
    "uA/cm^2": ("µA/cm²", "μA·cm⁻²"),
}


@pytest.mark.parametrize(("unit", "spelling"), [(u, s) for u, many in SPELLINGS.items() for s in many])
def test_units_are_read_as_papers_write_them(unit: str, spelling: str) -> None:
    """Raised digits, signs of multiplication, full stops between units: the same number to the bit."""
    for space in (" ", "", "\u00a0", "\u202f"):
        if space or spelling[0].isalpha() or spelling == "°":
            assert parse(f"0.7{space}{spelling}", unit, "key") == 0.7


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("10 cmH₂O", "kPa", 0.980665),
        ("10 cm H2O", "kPa", 0.980665),
        ("10 cm H₂O", "kPa", 0.980665),
        ("−55 mV", "mV", -55.0),
        ("1.5×10⁻³ mV", "mV", 1.5e-3),
        ("1.5 × 10^-3 mV", "mV", 1.5e-3),
        ("2·10³ mN", "mN", 2000.0),
        ("2e3 mN", "mN", 2000.0),
    ],
)
def test_numbers_are_read_as_papers_write_them(text: str, unit: str, expected: float) -> None:
    assert parse(text, unit, "key") == pytest.approx(expected, rel=1e-15)
    assert parse("1 mm Hg", "kPa", "key") == parse("1 mmHg", "kPa", "key")


@pytest.mark.parametrize(
    "text", ["5 s.", "5 .s", "5 m×", "5 ⁻¹", "5 s--1", "5 °°", "5×10", "5×10⁻⁹⁹⁹⁹ s", "5 cm H", "5 ^s"]
)
def test_odd_spellings_stay_refused(text: str) -> None:
    with pytest.raises(ConfigurationError):
        parse(text, "s", "key")


def test_every_unit_that_is_written_is_read_back() -> None:
    """Units of parameters, of outputs and of tables, with the typography of the figures."""
    import peristalsis as ps
    from peristalsis.names import OUTPUTS

    written = {about.unit for about in ps.configuration().items()} | {output.unit for output in OUTPUTS.values()}
    for unit in sorted(written - {"", "1"}):
        pretty = unit.replace("*", "·").replace("^2", "²").replace("^3", "³").replace("u", "µ")
        for spelling in (unit, pretty):
            target = unit if unit in CANONICAL_UNITS else "deg" if unit == "rad" else unit
            assert parse(f"1 {spelling}", target, "key") > 0.0, spelling


@given(value=st.floats(min_value=1e-6, max_value=1e6), unit=st.sampled_from(sorted(SPELLINGS)), data=st.data())
def test_any_spelling_gives_the_number_of_the_plain_one(value: float, unit: str, data: st.DataObject) -> None:
    spelling = data.draw(st.sampled_from(SPELLINGS[unit]))
    assert parse(f"{value!r} {spelling}", unit, "key") == parse(f"{value!r} {unit}", unit, "key")


def test_values_of_numpy_and_pint_are_taken() -> None:
    """Scalars, switches, arrays, quantities: what a notebook has at hand, and the same configuration."""
    import numpy as np
    import pint

    import peristalsis as ps

    q = pint.UnitRegistry()
    given = {
        "pellet.radius": q.Quantity(8.5, "mm"),
        "pellet.viscous_friction": q.Quantity(np.float64(12.0), "N*s/m"),
        "reflex.enabled": np.bool_(False),
        "grid.n_z": np.int32(60),
        "longitudinal.active": np.float32(0.5),
        "output.probes": q.Quantity(np.array([20.0, 50.0]), "mm"),
        "circular.threshold": np.str_("-50 mV"),
        "circular.active": np.array(0.25),
    }
    plain = {
        "pellet.radius": "8.5 mm",
        "pellet.viscous_friction": "12.0 N*s/m",
        "reflex.enabled": False,
        "grid.n_z": 60,
        "longitudinal.active": 0.5,
        "output.probes": ["20 mm", "50 mm"],
        "circular.threshold": "-50 mV",
        "circular.active": 0.25,
    }
    assert ps.configuration(changes=given) == ps.configuration(changes=plain)
    with pytest.raises(ConfigurationError, match="the unit is missing"):
        ps.configuration(changes={"pellet.radius": np.float64(0.9)})
    with pytest.raises(ConfigurationError, match="cannot be converted"):
        ps.configuration(changes={"pellet.radius": q.Quantity(1.0, "kg")})
