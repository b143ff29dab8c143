"""The base case of the reverse float-over, in the variants that the benchmarks need."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from benchmarks.report import ROOT
from hydrosim import load_case, load_database
from hydrosim.forces import Fender, NormalCurve, StickSlip
from hydrosim.scene import LinearScenes, Method, Scene, Unstable

SHORT = 700.0  # s: the first contact, at 534 s, and a few dozen events after it
RECORDED = 0.4  # s
FINEST = RECORDED / 128  # s: the step of the reference


@lru_cache
def base_case() -> Scene:
    """The base case, its database read once for all."""
    return with_database_read(ROOT / "cases" / "reverse_float_over" / "base.yaml")


def with_database_read(case: Path) -> Scene:
    """The scene of a case of one body, its database in memory."""
    scene = load_case(case).scene()
    (body,) = scene.bodies
    assert isinstance(body.hydrodynamics, Path)
    read = replace(body, hydrodynamics=load_database(body.hydrodynamics))
    return replace(scene, bodies=(read,))


def short_case(step: float, method: Method = Method.RK4, events: bool = True) -> Scene:
    """The base case until `SHORT`, recorded every `RECORDED`, with this solver, stable or not."""
    settings: dict[str, Any] = {
        "step": step,
        "method": method,
        "events": events,
        "unstable": Unstable.WARN,
    }
    solver = replace(base_case().solver, **settings)
    return replace(base_case(), duration=SHORT, output_step=RECORDED, solver=solver)


def free_barge() -> Scene:
    """The moored barge in its sea, without lift and fenders, stepped."""
    scene = base_case()
    solver = replace(scene.solver, linear=LinearScenes.STEP)
    return replace(scene, forces={"mooring": scene.forces["mooring"]}, solver=solver)


def with_fenders(count: int) -> Scene:
    """The base case with ``count`` fenders, a square number, over the area of its four; together
    they are as stiff, and hold as much."""
    scene, side = base_case(), np.linspace(-20.0, 20.0, round(count**0.5))
    fender, share = scene.forces["interface"], 4.0 / count
    assert isinstance(fender, Fender)
    assert isinstance(fender.normal, NormalCurve)
    assert isinstance(fender.friction, StickSlip)
    x, y = np.meshgrid(side, side)
    law = fender.friction
    spread = replace(
        fender,
        points=np.column_stack([x.ravel(), y.ravel(), np.full(count, fender.points[0, 2])]),
        normal=replace(fender.normal, force=share * fender.normal.force),
        friction=replace(
            law,
            stiffness=share * law.stiffness,
            damping=share * law.damping,
            slip_damping=share * law.slip_damping,
        ),
    )
    return replace(scene, forces={**scene.forces, "interface": spread})


def barges(count: int) -> Scene:
    """``count`` moored barges 500 m apart, which do not feel each other."""
    scene = free_barge()
    (barge,), mooring = scene.bodies, scene.forces["mooring"]
    names = [f"barge {k + 1}" for k in range(count)]
    return replace(
        scene,
        bodies=tuple(
            replace(barge, name=name, location=(0.0, 500.0 * k)) for k, name in enumerate(names)
        ),
        forces={f"mooring of {name}": replace(mooring, body=name) for name in names},
    )


def motions(run: xr.Dataset) -> np.ndarray:
    """Displacements and angles (nt, 6) of the one body."""
    return run.position.isel(body=0).values


def touches(run: xr.Dataset) -> np.ndarray:
    """True (nt,) from the first record with contact on."""
    return np.logical_or.accumulate((run.fender_mode > 0).any("fender").values)
