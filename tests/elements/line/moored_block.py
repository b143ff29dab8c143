"""A dry block on catenaries, as scenes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scenes import block, moving, scene

from hydrosim.elements import Catenary, LinearMooring
from hydrosim.scene import Environment, Method, Scene

DEPTH = 50.0
AFLOAT = LinearMooring("block", np.diag([0.0, 0.0, 4e5, 4e7, 4e7, 0.0]))


def line(
    point: Sequence[float],
    anchor: Sequence[float],
    length: Sequence[float],
    weight: Sequence[float],
    stiffness: Sequence[float],
    hung: Sequence[float] | None = None,
    width: Sequence[float] | None = None,
    friction: float | None = 0.0,
    **more: Any,
) -> Catenary:
    """A catenary from the block."""
    nothing = np.zeros(len(length))
    arrays = [np.array(x, float) for x in (length, weight, stiffness)]
    arrays += [nothing if x is None else np.array(x, float) for x in (hung, width)]
    return Catenary("block", tuple(point), tuple(anchor), *arrays, friction, **more)


def lines(friction: float = 0.0) -> dict[str, Catenary]:
    """Three lines, the first of two segments with a clump between them."""
    return {
        "ahead": line(
            (10.0, 1.0, -2.0),
            (110.0, 0.0, -DEPTH),
            (58.0, 56.0),
            (1200.0, 800.0),
            (3e7, 2e7),
            (2e4, 0.0),
            friction=friction,
        ),
        "astern": line(
            (-10.0, 1.0, -2.0), (-100.0, 20.0, -DEPTH), (100.0,), (1e3,), (4e7,), friction=friction
        ),
        "abeam": line(
            (0.0, -5.0, -2.0), (0.0, -90.0, -DEPTH), (100.0,), (1e3,), (4e7,), friction=friction
        ),
    }


def moored(
    friction: float = 0.0, step: float = 0.1, duration: float = 10.0, **solver: Any
) -> Scene:
    """The block on three lines, thrown so that touch-downs pass the clump and the anchors."""
    thrown = block(
        4e5,
        position=moving(heave=-5.0),
        velocity=moving(surge=1.5, sway=0.5, heave=1.0, pitch=0.02),
    )
    forces = {"afloat": AFLOAT, **lines(friction)}
    solver = {"method": Method.RK4, "step": step, **solver}
    found = scene(thrown, forces, duration, 0.2, **solver)
    return replace(found, environment=Environment(water_depth=DEPTH))
