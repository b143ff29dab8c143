"""Damping, current and wind in case files."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from text_tables import rows

import hydrosim as hs
from hydrosim.elements import CurrentLoad, LinearDamping, QuadraticDamping, WindLoad
from hydrosim.errors import InputError
from hydrosim.scene import CurrentTable, GustSpectrum, WindPower
from hydrosim.water.current import current_table

CASE = """
title: streams
duration: 10 s
environment: {current: {speed: 2 knot, heading: 180 deg}, wind: {speed: 20 m/s}}
bodies: {hull: {mass: 1, radii_of_gyration: [1, 1, 1]}}
forces:
  element:
    body: hull
"""


def with_keys(keys: str) -> str:
    return CASE + "".join(f"    {line}\n" for line in keys.splitlines())


def test_streams_and_damping(load: Callable) -> None:
    scene = load(with_keys("type: linear_damping\ndamping_ratio: {roll: 5 %}")).scene()
    assert scene.environment.current == hs.Current(2 * 1852 / 3600, np.pi)
    assert scene.environment.wind == hs.Wind(20.0)
    element = scene.forces["element"]
    assert isinstance(element, LinearDamping)
    assert_allclose(element.damping_ratio, [0, 0, 0, 0.05, 0, 0])
    assert element.damping is None
    keys = "type: linear_damping\ndamping: {sway: 2 kN*s/m}\nrelative_to_current: true"
    element = load(with_keys(keys)).scene().forces["element"]
    assert_array_equal(element.damping, np.diag([0, 2e3, 0, 0, 0, 0]))
    assert element.relative_to_current


def test_quadratic_damping_per_dof_or_as_a_matrix(load: Callable) -> None:
    keys = "type: quadratic_damping\ndamping: {surge: 1 kN*s^2/m^2, yaw: 1 kN*m*s^2/deg^2}"
    element = load(with_keys(keys)).scene().forces["element"]
    assert isinstance(element, QuadraticDamping)
    assert_allclose(np.diag(element.damping), [1e3, 0, 0, 0, 0, 1e3 * (180 / np.pi) ** 2])
    rows = np.diag(np.arange(1.0, 7.0)).tolist()
    rows[5][1], rows[1][5] = "3 kN*s^2/m", "2 N*s^2/rad^2"
    keys = f"type: quadratic_damping\ndamping: {rows}".replace("'", '"')
    damping = load(with_keys(keys)).scene().forces["element"].damping
    assert (damping[5, 1], damping[1, 5], damping[3, 3]) == (3e3, 2.0, 4.0)


def test_half_a_circle_is_mirrored(load: Callable) -> None:
    keys = (
        "type: wind_load\npoint: [0, 0, 15 m]\nheadings: [0 deg, 60 deg, 120 deg, 180 deg]\n"
        "surge: [4 kN*s^2/m^2, 1, -2, -3]\nsway: [0, 5, 6, 0]\nyaw: [0, 7, 8 N*m*s^2/m^2, 0]"
    )
    load_ = load(with_keys(keys)).scene().forces["element"]
    assert isinstance(load_, WindLoad)
    assert_allclose(np.degrees(load_.headings), [0, 60, 120, 180, 240, 300])
    assert_array_equal(load_.surge, [4e3, 1, -2, -3, -2, 1])
    assert_array_equal(load_.sway, [0, 5, 6, 0, -6, -5])
    assert_array_equal(load_.yaw, [0, 7, 8, 0, -8, -7])


def test_all_round(load: Callable) -> None:
    keys = "type: current_load\nheadings: [0 deg, 90 deg, 180 deg, 270 deg]\nsway: [1, 2, 3, 4]"
    load_ = load(with_keys(keys)).scene().forces["element"]
    assert isinstance(load_, CurrentLoad)
    assert load_.headings.size == load_.sway.size == 4
    assert not load_.surge.any()


@pytest.mark.parametrize(
    ("keys", "key", "found"),
    rows(r"""
    type: linear_damping | element | none; expected either damping or damping_ratio
    type: linear_damping\ndamping: {surge: 1}\ndamping_ratio: {surge: 1} | element | \
      damping and damping_ratio
    type: linear_damping\ndamping: {surge: -1} | element.damping | -1 for surge
    type: quadratic_damping\ndamping: {surge: -1} | element.damping | -1 for surge
    type: quadratic_damping\ndamping: {surge: 1 kN} | damping.surge | "1 kN"
    type: wind_load\nheadings: [0, 180 deg]\nsurge: [1, 1] | headings | a gap of 180 deg
    type: wind_load\nheadings: [0, 90 deg]\nsurge: [1, 1] | headings | \
      headings from 0 to 90 deg; expected 0 to 180 deg
    type: wind_load\nheadings: [0, 90 deg, 180 deg, 270 deg, 360 deg]\nsurge: [1] | headings | \
      headings from 0 to 360 deg; expected each direction once
    type: wind_load\nheadings: [0, 90 deg, 180 deg]\nsurge: [1, 1] | element | \
      2 values in surge and 3 in headings
    type: wind_load\nheadings: [0, 90 deg, 180 deg] | element | no coefficients
    type: wind_load\nheadings: [0, 90 deg, 180 deg]\nsway: [0, 1, 2] | element | \
      0 at 0 and 2 at 180 deg in sway
    """),
)
def test_refusals(refusal: Callable, keys: str, key: str, found: str) -> None:
    assert f"{key}: found {found}" in refusal(with_keys(keys))


WIND = "wind: {speed: 20 m/s}"
CURRENT = "current: {speed: 2 knot, heading: 180 deg}"
LOADS = "type: wind_load\nheadings: [0, 90 deg, 180 deg]\nsurge: [1, 0, -1]\nheight: 12 m"


def test_gusts_and_profile_of_the_wind(load: Callable) -> None:
    wind = "wind: {speed: 20 m/s, height: 30 m, profile: npd, gusts: {spectrum: iso, seed: 5,"
    keys = f"{wind} lowest_frequency: 0.01 Hz, averaging: 10 min, repeat_period: 1 hour}}}}"
    case = load(with_keys(LOADS).replace(WIND, keys))
    water = case.scene().environment
    assert (water.wind.profile, water.wind.height) == ("npd", 30.0)
    assert water.gusts == hs.Gusts(
        GustSpectrum.NPD, 5, 0.02 * np.pi, averaging=600.0, repeat_period=3600.0
    )
    assert water.gusts.highest_frequency == np.pi
    assert case.scene().forces["element"].height == 12.0
    power = with_keys(LOADS).replace(WIND, "wind: {speed: 9, profile: {exponent: 0.12}}")
    assert load(power).scene().environment.wind.profile == WindPower(0.12)


@pytest.mark.parametrize("stream", ["wind", "current"])
def test_exponents_of_profiles_are_bounded(load: Callable, stream: str) -> None:
    """With 1000 the speed overflows at twice the height."""
    keys = "{speed: 9, heading: 0, profile: {exponent: 1e3}}"
    body = "bodies:\n  b: {mass: 1, dofs: [surge]}\n"
    text = f"title: t\nduration: 1 s\n{body}environment: {{{stream}: {keys}}}\n"
    with pytest.raises(InputError, match=r"exponent: found 1000.0; expected.*2 or less"):
        load(text)


def test_profiles_of_the_current(load: Callable) -> None:
    """Speeds are relative to the largest, headings to the first; a power law ends at the bottom."""

    def profile(keys: str) -> hs.Environment:
        text = with_keys("type: quadratic_damping\ndamping: {surge: 1}")
        return load(text.replace(CURRENT, f"water_depth: 80 m, current: {{{keys}}}"))

    table = "depth: [0 m, 20 m], speed: [1 m/s, 2 m/s]"
    water = profile(f"heading: 90 deg, profile: {{{table}}}").scene().environment
    assert water.current.top_speed == 2.0
    assert water.current.direction == np.pi / 2
    assert water.current.profile == CurrentTable((0.0, 20.0), (1.0, 2.0))
    assert_allclose(current_table(water).velocity, [[0.0, 1.0], [0.0, 2.0]], atol=1e-15)
    turning = f"profile: {{{table}, heading: [10 deg, 40 deg]}}"
    water = profile(turning).scene().environment
    x, y = current_table(water).velocity.T
    assert_allclose(np.degrees([water.current.direction, *np.arctan2(y, x)]), [10, 10, 40])
    water = profile("speed: 1 m/s, profile: {exponent: 0.143}").scene().environment
    assert current_table(water).depth[-1] == 80.0
    assert current_table(water).velocity[0, 0] == 1.0


@pytest.mark.parametrize(
    ("stream", "keys", "found"),
    rows("""
    wind | speed: 0, gusts: {spectrum: npd} | gusts and a speed of 0
    wind | speed: 9, height: 20 m | a height of 20 m and no profile
    wind | speed: 9, gusts: {spectrum: kaimal} | "kaimal"
    wind | speed: 9, gusts: {spectrum: npd, averaging: 2 hour} | an averaging time of 7200 s
    wind | speed: 9, gusts: {spectrum: npd, lowest_frequency: 1 Hz} | \
      a band from 6.28319 to 3.14159 rad/s
    wind | speed: 9, gusts: {spectrum: npd, repeat_period: 5 s} | 5 s; expected the duration or more
    current | heading: 0 | no speed
    current | speed: 1, profile: {depth: [0, 9], speed: [1, 0]} | a speed and a table of speeds
    current | profile: {depth: [0, 9], speed: [1]} | 1 values in speed and 2 in depth
    current | profile: {depth: [1, 9], speed: [1, 0]} | [1, 9]
    current | heading: 1, profile: {depth: [0, 9], speed: [1, 0], heading: [0, 1]} | \
      a heading and a table of headings
    current | speed: 1, profile: {exponent: 0.143} | a power law in water of infinite depth
    """),
)
def test_refused_streams(refusal: Callable, stream: str, keys: str, found: str) -> None:
    before = {"wind": WIND, "current": CURRENT}[stream]
    text = with_keys(LOADS).replace(before, f"{stream}: {{{keys}}}")
    assert f"found {found}" in refusal(text)


def test_a_load_needs_its_stream(refusal: Callable) -> None:
    text = with_keys(LOADS).replace(f", {WIND}", "")
    assert "found a wind_load and no environment.wind" in refusal(text)
