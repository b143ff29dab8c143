"""Damping, current and wind in case files."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

from hydrosim.forces import CurrentLoad, LinearDamping, QuadraticDamping, WindLoad
from hydrosim.scene import Stream

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
    assert scene.environment.current == Stream(2 * 1852 / 3600, np.pi)
    assert scene.environment.wind == Stream(20.0)
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
    [
        ("type: linear_damping", "element", "none; expected either damping or damping_ratio"),
        (
            "type: linear_damping\ndamping: {surge: 1}\ndamping_ratio: {surge: 1}",
            "element",
            "damping and damping_ratio",
        ),
        ("type: linear_damping\ndamping: {surge: -1}", "element.damping", "-1 for surge"),
        ("type: quadratic_damping\ndamping: {surge: -1}", "element.damping", "-1 for surge"),
        ("type: quadratic_damping\ndamping: {surge: 1 kN}", "damping.surge", '"1 kN"'),
        ("type: wind_load\nheadings: [0, 180 deg]\nsurge: [1, 1]", "headings", "a gap of 180 deg"),
        (
            "type: wind_load\nheadings: [0, 90 deg]\nsurge: [1, 1]",
            "headings",
            "headings from 0 to 90 deg; expected 0 to 180 deg",
        ),
        (
            "type: wind_load\nheadings: [0, 90 deg, 180 deg, 270 deg, 360 deg]\nsurge: [1]",
            "headings",
            "headings from 0 to 360 deg; expected each direction once",
        ),
        (
            "type: wind_load\nheadings: [0, 90 deg, 180 deg]\nsurge: [1, 1]",
            "element",
            "2 values in surge and 3 in headings",
        ),
        ("type: wind_load\nheadings: [0, 90 deg, 180 deg]", "element", "no coefficients"),
        (
            "type: wind_load\nheadings: [0, 90 deg, 180 deg]\nsway: [0, 1, 2]",
            "element",
            "0 at 0 and 2 at 180 deg in sway",
        ),
    ],
)
def test_refusals(refusal: Callable, keys: str, key: str, found: str) -> None:
    message = refusal(with_keys(keys))
    assert f"{key}: found {found}" in message


def test_a_load_needs_its_stream(refusal: Callable) -> None:
    keys = "type: wind_load\nheadings: [0, 90 deg, 180 deg]\nsurge: [1, 0, -1]"
    text = with_keys(keys).replace(", wind: {speed: 20 m/s}", "")
    assert "found a wind_load and no environment.wind" in refusal(text)
