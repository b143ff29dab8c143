"""Limits to the other side of a scene that is its own mirror image about y = 0.

Waves to -b move such a scene as waves to b do, with sway, roll and yaw reversed. Its limits are the
same if its criteria do not tell the sides apart and its swells run along the x axis.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import xarray as xr

from hydrosim.compiling.compile import compile_scene
from hydrosim.compiling.mirror import without_image
from hydrosim.compiling.symmetry import not_mirrored, plane_of
from hydrosim.dofs import DOFS, MIRROR_SIGN
from hydrosim.errors import HydrosimError
from hydrosim.scene import Scene
from hydrosim.statistics.headings import (
    MIRROR_REASON,
    MIRRORED_ATTRIBUTE,
    SAME_HEADING_RAD,
    images_of,
)

if TYPE_CHECKING:
    from hydrosim.statistics.figures import RequestedStatistic
    from hydrosim.studies.operability.seas import Swell

EVEN_STATISTICS = ("end_absolute", "change_absolute", "std", "largest_absolute")
"""Statistics that do not know the sign of what they are of."""
MOTION_CHANNELS = ("position", "velocity", "acceleration")


def add_mirrored_limits(
    found: xr.Dataset,
    scene: Scene,
    figures: Sequence[RequestedStatistic],
    swells: Sequence[Swell | None],
) -> xr.Dataset:
    """The limits ``found`` with those to the other side, if these are the same; attributes say
    which they are, or why there are none."""
    headings = found.heading.values
    images = images_of(headings)
    if not images:
        return found
    reasons = [*_criteria_asymmetries(figures, swells, scene), *_scene_asymmetries(scene, headings)]
    if reasons:
        text = f"Limits are not mirrored to the other side: {'; '.join(reasons)}."
        return found.assign_attrs({MIRROR_REASON: text})
    mirrored = found.sel(heading=[heading for heading, _ in images])
    mirrored = mirrored.assign_coords(
        heading=("heading", [at for _, at in images], found.heading.attrs)
    )
    for name in ("runs", "inferred", "otherwise"):
        mirrored[name] = xr.zeros_like(mirrored[name])
    both = xr.concat([found, mirrored], "heading", combine_attrs="override").sortby("heading")
    text = (
        "Scene and criteria are symmetric about the x axis. Limits to the other side are the same,"
        " without runs of their own."
    )
    return both.assign_attrs(
        {MIRROR_REASON: text, MIRRORED_ATTRIBUTE: np.sort([at for _, at in images])}
    )


def _criteria_asymmetries(
    figures: Sequence[RequestedStatistic], swells: Sequence[Swell | None], scene: Scene
) -> list[str]:
    """Criteria and swells that are others to the other side."""
    names = [str(figure) for figure in figures if not _is_even(figure)]
    names += [name for figure in figures for name in figure.elements if _is_asymmetric(name, scene)]
    oblique_swells = [
        s for s in swells if s is not None and abs(np.sin(s.heading)) > SAME_HEADING_RAD
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
