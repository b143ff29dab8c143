import math
from pathlib import Path

import pytest
from command_line import printed
from hypothesis import given
from hypothesis import strategies as st
from pydantic_core import PydanticCustomError

from hydrosim.files import units
from hydrosim.files.units import Quantity, factor

LENGTH = Quantity("length", "m", "12.4 m")
MASS = Quantity("mass", "kg", "1000 tonne", above=0)
STIFFNESS = Quantity("stiffness", "N/m", "40 tonne_force/m", at_least=0)
ANGLE = Quantity("angle", "rad", "20 deg")
RATIO = Quantity("number", "", "20 %")
DEPTH = Quantity("depth", "m", "100 m", above=0, infinite=True)
NUMBERS = st.floats(-1e4, 1e4, allow_subnormal=False)  # of km, too, below the limit


def refused(quantity: Quantity, value: object) -> str:
    with pytest.raises(PydanticCustomError) as caught:
        quantity.read(value)
    return caught.value.message()


def understood(quantity: Quantity, text: str) -> bool:
    """Read as a finite number, or refused with what was expected."""
    try:
        return math.isfinite(quantity.read(text))
    except PydanticCustomError as error:
        return quantity.expected_text in error.message()


@pytest.mark.parametrize(
    ("text", "unit", "si"),
    [
        *(("132105 kN/m", "N/m", 132.105e6), ("5.6e8 N/m", "N/m", 5.6e8), ("12.4 m", "m", 12.4)),
        *(("20 deg", "rad", math.pi / 9), ("20°", "rad", math.pi / 9), ("20 %", "", 0.2)),
        *(("40 tonne_force/m", "N/m", 40 * 9810.0), ("3 tf", "N", 3 * 9810.0)),
        *(("20000 tonne_force/hour", "N/s", 20000 * 9810.0 / 3600), ("3 hour", "s", 10800.0)),
        *(("1025 kg/m^3", "kg/m^3", 1025.0), ("9.81 m/s²", "m/s^2", 9.81)),
        *(("3.3e7 N*s/m", "N*s/m", 3.3e7), ("2 kN m", "N*m", 2000.0), ("100 ft", "m", 30.48)),
        *(("1 MN*m/deg", "N*m/rad", 1e6 * 180 / math.pi), ("1 knot", "m/s", 1852 / 3600)),
        *(("20 te", "kg", 20000.0), ("3 te.m^2", "kg*m^2", 3000.0), ("2 kN.m", "N*m", 2000.0)),
        *(("2 rpm", "rad/s", 4 * math.pi / 60), ("-.5e-3 km", "m", -0.5)),
    ],
)
def test_units_convert_to_si(text: str, unit: str, si: float) -> None:
    assert Quantity("value", unit, "").read(text) == pytest.approx(si, rel=1e-14)


@given(NUMBERS)
def test_a_number_and_its_text_are_si_without_rounding(x: float) -> None:
    assert LENGTH.read(x) == LENGTH.read(repr(x)) == LENGTH.read(f"{x!r} m") == x


@given(NUMBERS, st.sampled_from(["km", "ft", "mm", "inch", "nautical_mile"]))
def test_round_trip_through_another_unit(x: float, unit: str) -> None:
    assert LENGTH.read(f"{x / factor(unit, 'm')!r} {unit}") == pytest.approx(
        x, rel=1e-15, abs=1e-300
    )


@given(st.floats(-1e6, 1e6))
def test_degrees_agree_with_python(x: float) -> None:
    assert ANGLE.read(f"{x!r} deg") == pytest.approx(math.radians(x), rel=1e-15, abs=1e-300)


@given(st.text())
def test_any_text_is_read_or_refused_in_words(text: str) -> None:
    assert understood(LENGTH, text)


@given(st.text(alphabet="kNmsg/*^-23 ()_.%", max_size=12))
def test_any_unit_is_read_or_refused_in_words(unit: str) -> None:
    assert understood(STIFFNESS, f"1 {unit}")


@pytest.mark.parametrize(
    ("quantity", "value"),
    [
        *(
            (LENGTH, v)
            for v in [float("nan"), "nan", ".nan", "nan m", float("inf"), "inf", "1e400"]
        ),
        *((LENGTH, v) for v in [True, None, [], {}, "", "m", "deep", "1,000 m", "1_000", "0x10"]),
        *((LENGTH, v) for v in ["1:30", "3 kg", "3 m^2", "3 metres deep", "3 m^2^2^9^9", "3 (m)"]),
        *((MASS, v) for v in [0, -1, "0 kg", "-5 tonne", "3 kN"]),
        *((ANGLE, v) for v in ["20 %", "3 m", "1 Hz"]),
        *((RATIO, v) for v in ["20 deg", "0.2 m"]),
        *((DEPTH, v) for v in ["inf", float("inf"), 0, "-100 m", "infinite m", "infinity"]),
        (Quantity("angular velocity", "rad/s", "1 deg/s"), "1 Hz"),
    ],
)
def test_refused(quantity: Quantity, value: object) -> None:
    assert quantity.expected_text in refused(quantity, value)


def test_infinite_only_where_it_means_something() -> None:
    assert DEPTH.read("infinite") == math.inf
    refused(LENGTH, "infinite")


def test_message_says_what_was_found_expected_and_wrong() -> None:
    assert refused(MASS, "3 kN") == (
        'found "3 kN"; expected a mass in kg, or with a unit, such as "1000 tonne"; '
        '"kN" has a force where a mass belongs: divide a weight by 9.81 m/s^2'
    )
    assert '"m" is another kind of quantity' in refused(MASS, "3 m")
    assert "not known" in refused(LENGTH, "3 metrs")
    assert "above 0" in refused(MASS, "0 kg")
    assert "0 or more" in refused(STIFFNESS, "-1 N/m")


def test_weights_are_not_masses() -> None:
    assert "a weight is in tonne_force" in refused(STIFFNESS, "40 t/m")


@pytest.mark.parametrize("unit", ["ton", "tons", "mt"])
def test_ambiguous_tons_are_refused(unit: str) -> None:
    assert "tons differ" in refused(MASS, f"40 {unit}")
    assert MASS.read("40 tonne") == MASS.read("40 t") == 40000.0


def test_pint_is_loaded_for_units_that_no_run_before_knew(tmp_path: Path) -> None:
    assert loads_pint(tmp_path) == ["False", "True", "3000.0"]
    assert loads_pint(tmp_path) == ["False", "False", "3000.0"]


@pytest.mark.parametrize("damage", ["", "{", "[1]", '{"km in m": null}', '{"km in m": 999.0}'])
def test_a_damaged_file_of_factors_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, damage: str
) -> None:
    monkeypatch.setenv("HYDROSIM_CACHE_DIR", str(tmp_path))
    assert read_anew("3 km") == 3000.0
    (file,) = tmp_path.iterdir()
    whole = file.read_bytes()
    file.write_text(damage)
    assert read_anew("3 km") == 3000.0
    assert file.read_bytes() == whole


def read_anew(text: str) -> float:
    """A length as a new process reads it, which knows no factors but those on disk."""
    units._load_factors.cache_clear()
    return LENGTH.read(text)


def test_a_folder_that_cannot_be_written_is_no_error(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    assert loads_pint(tmp_path / "file")[-1] == "3000.0"


def loads_pint(cache: Path) -> list[str]:
    """Whether a new process has loaded pint after a number and after a unit, and what it read."""
    code = (
        "import sys; from hydrosim.files.units import Quantity;"
        "q = Quantity('length', 'm', ''); q.read('3'); print('pint' in sys.modules);"
        "length = q.read('3 km'); print('pint' in sys.modules); print(length)"
    )
    place = {"PYTHONPATH": str(Path(__file__).parents[2]), "HYDROSIM_CACHE_DIR": str(cache)}
    return printed(code, **place).split()


@pytest.mark.parametrize(
    ("quantity", "value", "remedy"),
    [
        (LENGTH, 1e300, r"it must be 1e\+07 or less"),
        (LENGTH, "-1e12 km", r"it must be 1e\+07 or less"),
        (STIFFNESS, "1e18 kN/m", r"it must be 1e\+20 or less"),
        (MASS, 1e-300, "it must be above 1e-20"),
    ],
)
def test_sizes_that_nothing_has(quantity: Quantity, value: object, remedy: str) -> None:
    with pytest.raises(PydanticCustomError, match=remedy):
        quantity.read(value)
