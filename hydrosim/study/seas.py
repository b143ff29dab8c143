"""The seas of a study of limits: a scene in other waves and swells; limits by mirror images.

Waves to -b move a scene that is its own mirror image about y = 0 as waves to b do, with sway, roll
and yaw reversed. Its limits are the same if its criteria do not tell the sides apart and its swells
run along the x axis."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from hydrosim.compile.compile import compile_scene
from hydrosim.compile.symmetry import not_mirrored, plane_of, without_image
from hydrosim.dofs import DOFS, MIRROR_SIGN
from hydrosim.errors import HydrosimError, InputError
from hydrosim.scene import Jonswap, Scene, Tma, Torsethaugen, WaveTrain
from hydrosim.statistics import weather

if TYPE_CHECKING:
    from hydrosim.statistics.figures import RequestedStatistic

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


def scene_in_sea(scene: Scene, sea: Sea, height: float, seed: int) -> Scene:
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


# Limits by mirror images.

EVEN_STATISTICS = ("end_absolute", "change_absolute", "std", "largest_absolute")
"""Statistics that do not know the sign of what they are of."""
MOTION_CHANNELS = ("position", "velocity", "acceleration")


def add_mirrored_limits(
    limits: xr.Dataset,
    scene: Scene,
    figures: Sequence[RequestedStatistic],
    swells: Sequence[Swell | None],
) -> xr.Dataset:
    """The ``limits`` with those to the other side, if these are the same; attributes say
    which they are, or why there are none."""
    headings = limits.heading.values
    images = weather.images_of(headings)
    if not images:
        return limits
    reasons = [*_criteria_asymmetries(figures, swells, scene), *_scene_asymmetries(scene, headings)]
    if reasons:
        text = f"Limits are not mirrored to the other side: {'; '.join(reasons)}."
        return limits.assign_attrs({weather.MIRROR_REASON: text})
    mirrored = limits.sel(heading=[heading for heading, _ in images])
    mirrored = mirrored.assign_coords(
        heading=("heading", [at for _, at in images], limits.heading.attrs)
    )
    for name in ("runs", "inferred", "otherwise"):
        mirrored[name] = xr.zeros_like(mirrored[name])
    both = xr.concat([limits, mirrored], "heading", combine_attrs="override").sortby("heading")
    text = (
        "Scene and criteria are symmetric about the x axis. Limits to the other side are the same,"
        " without runs of their own."
    )
    return both.assign_attrs(
        {weather.MIRROR_REASON: text, weather.MIRRORED_ATTRIBUTE: np.sort([at for _, at in images])}
    )


def _criteria_asymmetries(
    figures: Sequence[RequestedStatistic], swells: Sequence[Swell | None], scene: Scene
) -> list[str]:
    """Criteria and swells that are others to the other side."""
    names = [str(figure) for figure in figures if not _is_even(figure)]
    names += [name for figure in figures for name in figure.elements if _is_asymmetric(name, scene)]
    oblique_swells = [
        s for s in swells if s is not None and abs(np.sin(s.heading)) > weather.SAME_HEADING_RAD
    ]
    return names + [f"swell to {np.degrees(swell.heading):g} deg" for swell in oblique_swells]


def _is_asymmetric(name: str, scene: Scene) -> bool:
    """Whether an element, or a group of contacts, is not its own mirror image."""
    elements = {
        element: of
        for element, of in scene.forces.items()
        if name in (element, getattr(of, "group", None))
    }
    return bool(list(without_image(elements, plane_of(scene))))


def _is_even(figure: RequestedStatistic) -> bool:
    """Whether a figure is the same of a motion and of its mirror image."""
    if not figure.channel:
        return figure.is_even
    name, _, of = figure.channel.partition(".")
    if name in ("offset", "speed") or figure.channel in ("wave_elevation", "wind_speed"):
        return True
    dof = of.rpartition(".")[2]
    if name not in MOTION_CHANNELS or dof not in DOFS:
        return False
    return bool(MIRROR_SIGN[DOFS.index(dof)] > 0.0) or figure.statistic in EVEN_STATISTICS


def _scene_asymmetries(scene: Scene, headings: np.ndarray) -> list[str]:
    try:
        return not_mirrored(compile_scene(scene), headings)
    except HydrosimError as error:
        return [str(error)]
