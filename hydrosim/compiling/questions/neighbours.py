"""Questions about hulls close to each other."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.questions.extents import Extents, extents
from hydrosim.compiling.questions.query import Query, SceneContext
from hydrosim.compiling.questions.seas import peak_wavelength

if TYPE_CHECKING:
    from hydrosim.scene import Body

NEIGHBOUR_BREADTHS = 2.0  # times the larger breadth
DIRECTIONS = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
DIRECTION_VECTORS = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)], axis=1)


def shielding(about: SceneContext) -> Iterator[Query]:
    """Ask about hulls close to each other in waves whose databases do not include each other."""
    if not about.sea:
        return
    sizes = {
        body.name: extents(body, db)
        for body in about.scene.bodies
        if (db := about.facts.databases.get(body.name)) is not None and db.heading.size
    }
    known = [body for body in about.scene.bodies if sizes.get(body.name)]
    for one, other in combinations(known, 2):
        first, second = sizes[one.name], sizes[other.name]
        if (
            first is None
            or second is None
            or _share_database(one, other)
            or not (one.dofs or other.dofs)
        ):
            continue
        breadth = 2.0 * max(first.half.min(), second.half.min())
        gap = _gap(about, (one, first), (other, second))
        if gap < NEIGHBOUR_BREADTHS * breadth:
            length = peak_wavelength(about.sea)
            yield Query(
                f"bodies.{one.name}, bodies.{other.name}",
                f"hulls with separate databases that are {_gap_text(gap)}, with a breadth of"
                f" {breadth:.3g} m and waves of {length:.3g} m",
                f"usual is more than {NEIGHBOUR_BREADTHS:g} breadths",
                "Neither hull shields the other from waves, and neither feels the waves radiated"
                " by the other. Compute one database of both with `hydrosim db build` (bodies:"
                " in the recipe).",
            )


def _gap_text(gap: float) -> str:
    return f"about {gap:.3g} m apart" if gap > 0.0 else "overlapping in plan"


def _share_database(one: Body, other: Body) -> bool:
    """Whether two bodies belong to one database."""
    places = ((tuple(body.location), body.heading, body.hydrodynamics) for body in (one, other))
    first, second = places
    return first == second and one.database_body != other.database_body


def _gap(about: SceneContext, one: tuple[Body, Extents], other: tuple[Body, Extents]) -> float:
    """Distance of the rectangles of two hulls at the start [m]; 0 if they overlap."""
    middles, reaches = zip(
        *(_projected_extents(about, *each) for each in (one, other)), strict=True
    )
    apart = DIRECTION_VECTORS @ (middles[1] - middles[0]) - reaches[0] - reaches[1]
    return max(float(apart.max()), 0.0)


def _projected_extents(
    about: SceneContext, body: Body, size: Extents
) -> tuple[np.ndarray, np.ndarray]:
    """Centre of a hull's rectangle (2,), and its extent from there in all directions
    `DIRECTION_VECTORS`."""
    b = about.index[body.name]
    R = about.motion.rotation[b]
    middle = (about.centre(b) + R @ size.centre)[:2]
    return middle, np.abs(DIRECTION_VECTORS @ R[:2, :2]) @ size.half
