"""Questions about hulls and tanks beside the centre of gravity, and about drag beside a hull."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.questions.extents import extents
from hydrosim.compiling.questions.query import Query, SceneContext, text_beyond, text_outside
from hydrosim.dofs import DOFS
from hydrosim.forces.damping.quadratic_damping import QuadraticDamping
from hydrosim.scene.tanks import Box

# drag over 0.5 rho times the projected area under water: surge, sway, heave. A ship in surge has
# little more than friction; a flat plate has about 2, edges and bilge keels more
# in yaw, of cross flow over the length: T L^4 / 32 in place of the area
LEAST_DRAG = {"surge": 0.001, "sway": 0.02, "heave": 0.02, "yaw": 0.005}
MOST_DRAG = 30.0
TANK_MARGIN = 0.5  # of the half length and breadth of the water plane


def hulls(about: SceneContext) -> Iterator[Query]:
    """Ask about hulls aside of the centre of gravity, and about tanks far outside a hull."""
    for body in about.scene.bodies:
        if body.hydrostatics is None:
            continue
        corners = body.hydrostatics.corners.reshape(-1, 3)[:, :2]
        low, high = corners.min(axis=0), corners.max(axis=0)
        centre = np.array(body.centre_of_gravity[:2])
        off = float(np.linalg.norm(np.maximum(np.maximum(low - centre, centre - high), 0.0)))
        size = float(np.linalg.norm(high - low))
        if off > 0.5 * size:
            yield Query(
                f"bodies.{body.name}.hydrostatics",
                f"a hull {text_beyond(off, 0.5 * size)} m aside of the centre of gravity of"
                f" {body.name}",
                "usual is a centre of gravity above or within the hull",
                "Its file is in the frame of centre_of_gravity; location moves both.",
            )
    for _, body, db in about.floating_bodies():
        size_of = extents(body, db)
        for tank in body.tanks:
            if size_of is None or not isinstance(tank.shape, Box):
                continue
            middle = np.mean([tank.shape.low, tank.shape.high], axis=0) - body.centre_of_gravity
            aside = np.abs(middle - size_of.centre)[:2] / size_of.half
            if aside.max() > 1.0 + TANK_MARGIN:
                axis = int(aside.argmax())
                found_text = (
                    f"a tank whose middle is {aside[axis] * size_of.half[axis]:.3g} m from the"
                    f" middle of the water plane along {'xy'[axis]}"
                )
                usual = f"usual is up to {size_of.half[axis]:.3g} m, half of its size"
                yield Query(f"bodies.{body.name}.tanks.{tank.name}", found_text, usual)


def drag(about: SceneContext) -> Iterator[Query]:
    """Ask about quadratic damping that is not that of a hull of this size."""
    density = about.scene.environment.water_density
    wet = {body.name: (body, db) for _, body, db in about.floating_bodies()}
    for name, of in about.scene.forces.items():
        if not isinstance(of, QuadraticDamping) or of.body not in wet:
            continue
        size = extents(*wet[of.body])
        if size is None:
            continue
        length, breadth = 2.0 * size.half
        areas = {
            "surge": (breadth * size.draught, "m^2"),
            "sway": (length * size.draught, "m^2"),
            "heave": (length * breadth, "m^2"),
            "yaw": (size.draught * max(length, breadth) ** 4 / 32.0, "m^5"),
        }
        for dof, (area, unit) in areas.items():
            least = LEAST_DRAG[dof]
            k = DOFS.index(dof)
            found = float(of.damping[k, k])
            coefficient = found / (0.5 * density * area)
            if found > 0.0 and not least <= coefficient <= MOST_DRAG:
                text = text_outside(coefficient, least, MOST_DRAG, ".2g")
                yield Query(
                    f"forces.{name}.damping.{dof}",
                    f"{found:.3g}, a drag coefficient of {text} on {area:.3g} {unit}",
                    f"usual is {least:g} to {MOST_DRAG:g}",
                    "Is it in kN?",
                )
