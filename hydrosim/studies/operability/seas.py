"""The seas of a study of limits: a scene in waves of another height, period and heading, and with
a swell beside them."""

from __future__ import annotations

from dataclasses import dataclass, replace

from hydrosim.errors import InputError
from hydrosim.scene import Jonswap, Scene, Tma, Torsethaugen, WaveTrain

SINGLE_PEAK_SPECTRUM = Jonswap | Tma | Torsethaugen
"""Spectra that have one significant height and one peak period."""


@dataclass(frozen=True)
class Swell:
    """Waves besides the wind sea: significant height [m], peak period [s], heading [rad]."""

    significant_height: float
    peak_period: float
    heading: float


@dataclass(frozen=True)
class Sea:
    """Peak period [s] and heading [rad] of the sea whose height is looked for; a swell with it."""

    peak_period: float
    heading: float
    swell: Swell | None = None


def wind_sea(scene: Scene) -> WaveTrain:
    """The one wave train of a scene whose height is varied; InputError if there is no such one."""
    trains = scene.environment.waves
    if len(trains) != 1 or not isinstance(trains[0].spectrum, SINGLE_PEAK_SPECTRUM):
        raise InputError(
            f"environment.waves: found {len(trains)} wave trains"
            f"{', of another spectrum' if len(trains) == 1 else ''}; expected one, jonswap,"
            " pierson_moskowitz, tma or torsethaugen; swell comes from the study."
        )
    return trains[0]


def in_sea(scene: Scene, sea: Sea, height: float, seed: int) -> Scene:
    """The scene in this sea of a significant ``height`` [m]; wind sea and swell have one seed, and
    are told apart by their number."""
    train = wind_sea(scene)
    assert isinstance(train.spectrum, SINGLE_PEAK_SPECTRUM)
    spectrum = replace(train.spectrum, significant_height=height, peak_period=sea.peak_period)
    trains = [replace(train, spectrum=spectrum, heading=sea.heading, seed=seed)]
    if sea.swell is not None:
        s = sea.swell
        other = Jonswap(s.significant_height, s.peak_period)
        trains.append(replace(train, spectrum=other, heading=s.heading, seed=seed, spreading=None))
    water = scene.environment.with_seed(seed)
    return replace(scene, environment=replace(water, waves=tuple(trains)))
