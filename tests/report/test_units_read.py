"""In which unit people read what is in SI: by what a case wrote, composed of the units of parts."""

import json
import math

import pytest

import hydrosim as hs
from hydrosim.files.display_units import (
    DEFAULT,
    UNITS_ATTRIBUTE,
    Units,
    as_attribute,
    chosen_units,
    units_of,
)

TONNES = Units({"N": "tonne_force", "kg": "kg"})
FEET = Units({"m": "foot", "N": "MN", "rad": "rad"})
DEGREE = 180.0 / math.pi


USUAL = [
    *(("", "", 1.0), ("1", "", 1.0), ("s", "s", 1.0), ("m/m", "m/m", 1.0), ("share", "%", 100.0)),
    *(("N", "kN", 1e-3), ("N m", "kN m", 1e-3), ("N s/m", "kN s/m", 1e-3)),
    *(("kg", "t", 1e-3), ("kg m^2", "t m^2", 1e-3), ("kg/m^3", "t/m^3", 1e-3)),
    *(("rad", "deg", DEGREE), ("rad/s", "deg/s", DEGREE), ("rad/m", "deg/m", DEGREE)),
    *(("N m s/rad", "kN m s/deg", 1e-3 / DEGREE), ("J", "MJ", 1e-6), ("kg/s", "t/hour", 3.6)),
    ("furlong", "furlong", 1.0),
]
IN_TONNES = [
    *(("N", "tf", 1.0 / 9810.0), ("N m", "tf m", 1.0 / 9810.0), ("kg", "kg", 1.0)),
    *(("kg m^2", "kg m^2", 1.0), ("rad", "deg", DEGREE)),
]
IN_FEET = [
    *(("m^3", "foot^3", 0.3048**-3), ("N m", "MN foot", 1e-6 / 0.3048)),
    *(("N/m", "MN/foot", 1e-6 * 0.3048), ("rad", "rad", 1.0), ("share", "%", 100.0)),
]


@pytest.mark.parametrize(
    ("units", "unit", "read", "factor"),
    [
        (units, *row)
        for units, table in ((DEFAULT, USUAL), (TONNES, IN_TONNES), (FEET, IN_FEET))
        for row in table
    ],
)
def test_usual_and_chosen_units(units: Units, unit: str, read: str, factor: float) -> None:
    shown = units.display_unit(unit)
    assert shown.unit == read
    assert shown.factor == pytest.approx(factor, rel=1e-12)


def test_the_unit_written_most_often_is_chosen() -> None:
    """The first of those written equally often; units of products choose nothing."""
    written = [("N", "MN"), ("N", "kN"), ("N", "kN"), ("m", "foot"), ("m", "m"), ("N/m", "MN/m")]
    assert chosen_units(written) == {"N": "kN", "m": "foot"}
    assert chosen_units([]) == {}


def test_the_choice_is_kept_in_results() -> None:
    attributes = as_attribute({"N": "MN"})
    assert json.loads(attributes[UNITS_ATTRIBUTE]) == {"N": "MN"}
    assert units_of(attributes).display_unit("N").unit == "MN"
    assert as_attribute({}) == {}
    assert units_of({}) is DEFAULT


CASE = """
title: A block
duration: 1 s
bodies:
  block: {mass: 2000 kg, radii_of_gyration: [1 m, 1 m, 1 m], dofs: [surge]}
forces:
  push: {type: applied_force, body: block, force: {surge: 3 MN}}
  line: {type: linear_mooring, body: block, stiffness: {surge: 4 kN/m}}
"""


def test_a_case_is_answered_in_its_units(tmp_path) -> None:
    """Of forces and masses; not of stiffness, which is no force."""
    path = tmp_path / "case.yaml"
    path.write_text(CASE)
    run = hs.simulate(hs.load_case(path).scene())
    units = units_of(run.attrs)
    assert units.display_unit("N").unit == "MN"
    assert units.display_unit("kg").unit == "kg"
    assert units.display_unit("rad").unit == "deg"
    assert run.hydrosim.summary().units == units
