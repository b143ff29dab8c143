"""Winches in case files: what is refused, by message, and what becomes of the keys."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

import hydrosim as hs
from hydrosim.elements import Harmonic, Winch
from hydrosim.errors import InputError

DRUM = {"shortest": "5 m", "longest": "80 m"}
ENDS = {"body": "load", "point": [0, 0, 0], "anchor": [0, 0, "60 m"]}
WIRE: dict[str, Any] = {"type": "winch", **ENDS, "stiffness": "500 MN"}
TUGGER = {**WIRE, "tension": "1000 kN", "speed": "0.3 m/s", "dead_band": "5 %", "drum": DRUM}
TABLE = {"time": ["0 s", "10 s"], "length": ["50 m", "40 m"]}


def case(**forces: dict[str, Any]) -> dict[str, Any]:
    """A load without water."""
    load = {"mass": "100 tonne", "centre_of_gravity": [0, 0, "10 m"], "weight": "carried"}
    load |= {"radii_of_gyration": ["2 m"] * 3, "dofs": ["heave"], "points": {"top": [0, 0, 1]}}
    return {"title": "Hoist", "duration": "5 s", "bodies": {"load": load}, "forces": forces}


def loaded(folder: Path, element: dict[str, Any]) -> Any:
    """The element of a case file."""
    path = folder / "case.yaml"
    path.write_text(yaml.safe_dump(case(line=element)))
    return hs.load_case(path).scene().forces["line"]


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "nothing that drives": ({**WIRE, "length": "50 m"}, "nothing drives"),
    "two controls": ({**TUGGER, "compensation": {"point": "top of load"}}, "one of tension"),
    "tension without a drum": ({k: v for k, v in TUGGER.items() if k != "drum"}, "no drum"),
    "speed without a drum": ({**WIRE, "length": "50 m", "speed": "1 m/s"}, "no drum"),
    "speed of 0": ({**WIRE, "length": "50 m", "speed": 0, "drum": DRUM}, "a speed of 0"),
    "tension without a speed": ({**TUGGER, "speed": None}, "no speed"),
    "tension with a speed of 0": ({**TUGGER, "speed": 0}, "not above 0"),
    "length of 0": ({**TUGGER, "length": 0}, "length"),
    "length that falls to 0": (
        {**WIRE, "length": {"time": ["0 s", "9 s"], "length": ["9 m", "-1 m"]}},
        "length",
    ),
    "length beyond the drum": ({**TUGGER, "length": "90 m"}, "a length within"),
    "drum the wrong way": ({**TUGGER, "drum": {"shortest": 9, "longest": 5}}, "above the shortest"),
    "friction that is too much": ({**TUGGER, "friction": {"in": 0.99}}, "never heaves in"),
    "acceleration without a band": (
        {**TUGGER, "dead_band": 0, "acceleration": "0.1 m/s^2"},
        "a dead_band",
    ),
    "rated load below the tension": ({**TUGGER, "rated_load": "900 kN"}, "rated_load"),
    "no length at the start": ({**WIRE, "speed": "1 m/s", "drum": DRUM}, "no length"),
    "friction with a length": ({**WIRE, "length": TABLE, "dead_band": 0.1}, "tension alone"),
    "gas that is used up": (
        {
            **{k: v for k, v in WIRE.items() if k != "stiffness"},
            "type": "compensator",
            "length": "50 m",
            "tension": "1 MN",
            "stroke": "6 m",
            "gas_length": "2 m",
            "stiffness": "9 MN/m",
        },
        "gas_length",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_no_winch_can_do_is_refused_by_message(name: str, tmp_path: Path) -> None:
    element, said = REFUSED[name]
    given = {k: v for k, v in element.items() if v is not None}
    with pytest.raises(InputError, match=rf"case\.yaml:\d+: forces\.line.*{said}"):
        loaded(tmp_path, given)


def test_a_point_that_no_body_has_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "case.yaml"
    line = {**WIRE, "length": "50 m", "compensation": {"point": "tip of load"}}
    path.write_text(yaml.safe_dump(case(line=line)))
    with pytest.raises(InputError, match=r"found tip of load; expected a named point: top of load"):
        hs.compile_scene(hs.load_case(path).scene())


def test_keys_become_the_winch(tmp_path: Path) -> None:
    tugger = loaded(tmp_path, {**TUGGER, "friction": {"in": 0.3, "out": 0.1}, "rated_load": 2e6})
    assert isinstance(tugger, Winch)
    assert (tugger.tension, tugger.speed, tugger.dead_band) == (1e6, 0.3, 0.05)
    assert tugger.friction == hs.DrumFriction(0.3, 0.1)
    assert (tugger.length, tugger.ends, tugger.capacity) == (None, (5.0, 80.0), 2e6)
    hoist = loaded(tmp_path, {**WIRE, "length": TABLE, "breaks_at": "3 MN"})
    np.testing.assert_array_equal(hoist.length.value, [50.0, 40.0])
    assert hoist.active.until == hs.When(0.0, "winch_tension.line", above=3e6)
    speed = {"amplitude": "0.5 m/s", "period": "20 s"}
    driven = loaded(tmp_path, {**WIRE, "length": "50 m", "speed": speed, "drum": DRUM})
    assert isinstance(driven.speed, Harmonic)
    follows = {"point": "top of load", "gain": 0.9, "delay": "0.2 s", "stroke": "6 m"}
    active = loaded(tmp_path, {**WIRE, "length": "50 m", "compensation": follows})
    assert active.compensation == hs.Compensation("top of load", 0.9, 0.2, stroke=6.0)
    assert active.ends == (47.0, 53.0)


def test_corners_of_a_damped_line_are_told(tmp_path: Path) -> None:
    """c = 2 kN s/m and a rate that jumps by 1 m/s, at the corner and after the last point."""
    spring = {**WIRE, "type": "spring", "stiffness": "1 MN/m", "damping": "2 kN*s/m"}
    path = tmp_path / "case.yaml"
    path.write_text(yaml.safe_dump(case(line={**spring, "length": TABLE})))
    notes = hs.compile_scene(hs.load_case(path).scene()).notes.records
    assert [text for text in notes if "forces.line.length" in text and "2e+03 N" in text]


def test_a_winch_at_rest_is_stuck_with_the_weight(tmp_path: Path) -> None:
    """With `initial: at_rest`: the drum does not turn, and the load hangs by its weight."""
    path = tmp_path / "case.yaml"
    line = {**TUGGER, "tension": "981 kN", "friction": {"in": 0.1, "out": 0.1}}
    solver = {"method": "rk4", "step": "0.05 s"}
    path.write_text(yaml.safe_dump({**case(line=line), "initial": "at_rest", "solver": solver}))
    run = hs.simulate(hs.load_case(path))
    np.testing.assert_allclose(run.winch_tension, 981e3, rtol=1e-9)
    assert not run.winch_mode.values.any()
    assert np.ptp(run.position.values) <= 1e-9
