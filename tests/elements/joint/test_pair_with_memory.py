"""Two barges on a vertical hinge that drift and turn, with the memory of the waves they radiate."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from math import radians
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from jointed import FRAME, completed, joint, moved, scene
from turning import points, turned, turned_back

import hydrosim as hs
from hydrosim.scene import ConvolutionRadiation, Method, Radiation, RadiationModel, Symmetry

Figure = Callable[[str, float], None]
BOX = Path(__file__).parents[3] / "hydro_db" / "box.nc"  # 100 m by 20 m, 5 m deep
MASS, RADII = 1.025e7, (7.0, 26.0, 26.0)
APART = 104.0  # m between centres
LAUNCH = (1.5, 0.6, 0.2, 0.01, 0.005, 0.04)
MEMORIES: dict[str, RadiationModel | Radiation] = {
    "states": RadiationModel.STATE_SPACE,
    "convolution": ConvolutionRadiation(length=40.0),
}
CURRENT = hs.Stream(0.8, 1.1)


PIN = (APART / 2, 0.0, 0.0)
JOINTS = {
    "hinge": joint("hinge", "aft", "fore", moved(0.2, -0.09), point=PIN, axis=(0, 0, 1)),
    "ball": joint("ball", "aft", "fore", moved(), moved(), moved(0.2, -0.09), point=PIN),
    "universal": joint(
        *("universal", "aft", "fore", moved(0.2, -0.09), moved()),
        point=PIN,
        axis=(0, 0, 1),
        second=(0, 1, 0),
    ),
}


def barges(memory: str, current: hs.Stream = CURRENT, held: str = "hinge") -> hs.Scene:
    """Two barges end to end; each makes waves by itself."""
    fore = hs.Body(
        "fore",
        MASS,
        MASS * np.diag(np.square(RADII)),
        BOX,
        radiation=MEMORIES[memory],
        velocity=LAUNCH,
        points={"centre": FRAME["centre"], "bow": (50.0, 0.0, 0.0), "mast": (0.0, 0.0, 20.0)},
    )
    aft = replace(fore, name="aft", location=(-APART, 0.0), velocity=(0.0,) * 6)
    pin = {"pin": JOINTS[held]}
    found = scene([fore, aft], pin, 60.0, output_step=0.5, method=Method.RK4, step=0.1)
    return replace(
        found,
        environment=hs.Environment(current=current),
        solver=replace(found.solver, symmetry=Symmetry.IGNORE),
    )


@cache
def the_run(memory: str) -> xr.Dataset:
    """The run in a current."""
    return completed(barges(memory))


@pytest.mark.parametrize("memory", list(MEMORIES))
@pytest.mark.parametrize("held", list(JOINTS))
def test_with_memory_a_pair_never_gains_energy(held: str, memory: str, figure: Figure) -> None:
    """In still water: the waves have taken energy at any time, though the pair folds and turns."""
    run = completed(barges(memory, hs.Stream(), held))
    lost = run.energy_dissipated_radiation.values
    figure("lost", lost[-1] / run.energy_kinetic.values[0])
    assert np.ptp(run.joint_position.values, axis=0).max() > 1.0
    assert lost.min() >= 0.0
    assert lost[-1] > 0.1 * run.energy_kinetic.values[0]
    assert run.attrs["energy_residual_relative"] < 1e-6


@pytest.mark.parametrize("memory", list(MEMORIES))
def test_a_pair_with_memory_turns_with_the_scene(memory: str, figure: Figure) -> None:
    by, shift = radians(37.0), (30.0, -20.0)
    whole = barges(memory)
    found = turned_back(points(completed(turned(whole, by, shift)), whole), by, shift)
    exact = points(the_run(memory), whole)
    error = np.abs(found - exact).max() / np.ptp(exact, axis=0).max()
    figure("error", error)
    assert error <= 1e-9
