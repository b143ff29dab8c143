"""The H-851 of the thesis' cases, moored, free floating or pressed against the topside."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from dry_scenes import steady

from hydrosim import load_case
from hydrosim.database import HydroDatabase, load
from hydrosim.forces import Fender, NormalCurve, StickSlip
from hydrosim.scene import Jonswap, Scene, Solver, WaveTrain

ROOT = Path(__file__).parents[1]
CASES = ROOT / "cases" / "reverse_float_over"
SEA = Jonswap(significant_height=1.5, peak_period=8.0, peak_enhancement=3.3)


@lru_cache
def hull() -> HydroDatabase:
    """The barge's database, about the centre of gravity of the cases."""
    return load(ROOT / "hydro_db" / "h851.nc")


@lru_cache
def scene_of(case: str) -> Scene:
    """The scene of one of the reverse float-over cases, with the database read once for all."""
    return with_body(load_case(CASES / f"{case}.yaml").scene(), hydrodynamics=hull())


def with_body(scene: Scene, **changes: Any) -> Scene:
    """The scene with its one body changed."""
    (body,) = scene.bodies
    return replace(scene, bodies=(replace(body, **changes),))


def in_waves(scene: Scene, *trains: WaveTrain) -> Scene:
    """The scene in other waves; in calm water if there are none."""
    return replace(scene, environment=replace(scene.environment, waves=trains))


def in_contact(duration: float, step: float = 0.1, points: np.ndarray | None = None) -> Scene:
    """The base case lifted at once until the barge knocks against the topside in every wave.

    The fenders are those of the base case or others at ``points`` (n, 3) with the same totals.
    """
    base = scene_of("base")
    fender = base.forces["interface"]
    assert isinstance(fender, Fender)
    lift = steady("barge", heave=160e6)
    interface = fender if points is None else _shared(fender, np.asarray(points, dtype=float))
    scene = with_body(in_waves(base, WaveTrain(SEA)), position=(0.0, 0.0, 1.05, 0.0, 0.0, 0.0))
    return replace(
        scene,
        duration=duration,
        forces={"mooring": base.forces["mooring"], "lift": lift, "interface": interface},
        solver=Solver(step=step),
    )


def _shared(fender: Fender, points: np.ndarray) -> Fender:
    """The fender with its total stiffness, damping and friction on other points."""
    share = len(fender.points) / len(points)
    curve, law = fender.normal, fender.friction
    assert isinstance(law, StickSlip)
    return replace(
        fender,
        points=points,
        normal=NormalCurve(curve.compression, share * curve.force, share * curve.damping),
        friction=replace(
            law,
            stiffness=share * law.stiffness,
            damping=share * law.damping,
            slip_damping=share * law.slip_damping,
        ),
    )


def motion(run: xr.Dataset, body: int = 0) -> np.ndarray:
    """Position (nt, 6) of a body."""
    return run.position.values[:, body]
