"""Bodies on fixed joints move as one body: in waves and current, with memory, tanks, families of
databases, hulls and contacts.

A dry lump carries the wet body, so that all forces on that pass the joint; the wet body carries a
second lump, so that the common centre of gravity is its own. One body with the mass properties of
all three is the reference.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import straight_curve

import hydrosim as hs
from hydrosim import simulate
from hydrosim.database.build.barge import box
from hydrosim.database.build.recipe import barge_with_deck
from hydrosim.scene import (
    AtDraught,
    Box,
    ConstantRadiation,
    ConvolutionRadiation,
    Family,
    Hull,
    Kinematics,
    Place,
    StateSpaceRadiation,
    Symmetry,
    Weight,
)

DATA = Path(__file__).parents[2] / "data" / "draughts"
DRAUGHT = 4.4
MASS = 1025.0 * 60.0 * 20.0 * DRAUGHT
CENTRE = np.array([0.0, 0.0, 4.0 - DRAUGHT])  # of gravity, of the wet body and of all together
LUMP = 0.1 * MASS
ASIDE = np.array([9.0, 3.0, 4.0])  # the lump's centre of gravity from the common one
OWN = LUMP * np.diag([2.0, 3.0, 4.0]) ** 2
TOTAL = MASS * np.diag([7.0, 16.0, 16.0]) ** 2
MARKS = {"fore": (28.0, 3.0, 2.0), "aft": (-25.0, -4.0, 1.0), "side": (2.0, 9.0, -1.0)}
KEYS = {
    "hydrodynamics": DATA / "4m4.nc",
    "hydrostatics": Hull(barge_with_deck(box(60.0, 20.0, DRAUGHT), 8.0)),
    "radiation": ConstantRadiation(7.0),
    "weight": Weight.CARRIED,
    "heading": 0.4,
}

pytestmark = pytest.mark.filterwarnings("ignore")  # of coarse databases


def point_mass(mass: float, arm: np.ndarray) -> np.ndarray:
    """Its inertia (3, 3)."""
    return mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))


def barge(mass: float, inertia: np.ndarray, keys: Mapping[str, Any]) -> hs.Body:
    """The wet body with these mass properties."""
    given = KEYS | dict(keys)
    return hs.Body("barge", mass, inertia, centre_of_gravity=tuple(CENTRE), points=MARKS, **given)


def one(**keys: Any) -> tuple[hs.Body, ...]:
    """All in one body."""
    return (barge(MASS, TOTAL, keys),)


def three(**keys: Any) -> tuple[hs.Body, ...]:
    """The wet body, and lumps on both sides."""
    wet = barge(MASS - 2.0 * LUMP, TOTAL - 2.0 * (OWN + point_mass(LUMP, ASIDE)), keys)
    places = {"carrier": tuple(CENTRE + ASIDE), "load": tuple(CENTRE - ASIDE)}
    alike = {"heading": wet.heading, "weight": wet.weight}
    lumps = (hs.Body(n, LUMP, OWN, centre_of_gravity=at, **alike) for n, at in places.items())
    return wet, *lumps


LOWER = hs.Fixed("barge", "carrier", point=(1.0, 2.0, 3.0))
WELDS = {"lower": LOWER, "upper": hs.Fixed("load", "barge")}


def lines() -> Mapping[str, hs.Spring]:
    """Two lines that hold the hull."""
    bow = hs.Spring("barge", (30.0, 0.0, 0.0), (92.0, 30.0, 1.0), 60.0, stiffness=2e5, damping=5e4)
    stern = replace(bow, point=(-30.0, 0.0, 0.0), anchor=(-91.0, -30.0, 2.0))
    return {"bow": bow, "stern": stern}


def apart(
    forces: Mapping[str, Any] | None = None,
    current: float = 0.8,
    solver: Mapping[str, Any] | None = None,
    **keys: Any,
) -> float:
    """Largest difference of the marks [m], of the largest motion of one, of both scenes."""
    waves = hs.WaveTrain(hs.RegularWave(amplitude=0.6, period=6.5), heading=1.1, ramp=5.0)
    settings = {"step": 0.025, "symmetry": Symmetry.IGNORE} | dict(solver or {})
    found = []
    for bodies, joints in ((one(**keys), {}), (three(**keys), WELDS)):
        water = hs.Environment(waves=(waves,), current=hs.Stream(current, 2.0))
        parts = {"forces": lines() if forces is None else forces, "joints": joints}
        scene = hs.Scene("fixed", 15.0, bodies, water, **parts, solver=hs.Solver(**settings))
        scene = scene.with_output(step=0.5)
        found.append(simulate(scene).point_position.values)
    return float(np.abs(found[0] - found[1]).max() / np.ptp(found[0], axis=0).max())


def test_a_hull_in_waves_and_current_that_turns() -> None:
    assert apart() < 1e-9


def test_a_memory_by_convolution() -> None:
    """Steps interpolate velocities between them, in other coordinates."""
    assert apart(radiation=ConvolutionRadiation()) < 2e-4


def test_a_memory_in_states() -> None:
    """The fit knows the masses: both fits are within their tolerance."""
    assert apart(radiation=StateSpaceRadiation(3e-3)) < 1e-3


def test_waves_that_follow_the_body() -> None:
    met = hs.WaveForces(position=Place.INSTANTANEOUS, headings=Place.INSTANTANEOUS)
    assert apart(wave_forces=met) < 1e-9


def test_small_angles_and_a_stiffness_matrix() -> None:
    small = {"kinematics": Kinematics.LINEAR}
    keys = {"hydrostatics": None, "heading": 0.0, "weight": Weight.BALANCED}
    assert apart({}, 0.0, small, **keys) < 1e-9


def test_a_family_of_databases() -> None:
    members = AtDraught(4.4, DATA / "4m4.nc"), AtDraught(3.6, DATA / "3m6.nc")
    assert apart(current=0.0, hydrodynamics=Family(members)) < 1e-9


def test_contacts() -> None:
    law = hs.StickSlip(0.4, 0.3, stiffness=4e6, damping=4e5, slip_damping=1e4)
    wall = hs.Plane((0.0, 12.0, 0.0), (0.0, -1.0, 0.0))
    points = np.array([(20.0, 10.0, 1.0), (-20.0, 10.0, 1.0)])
    curve = straight_curve(4e6)
    fenders = {**lines(), "quay": hs.Fender("barge", points, wall, curve, law)}
    assert apart(fenders, heading=0.05) < 1e-9


def test_a_landing_with_a_loop_and_a_wall() -> None:
    """Two legs of the barge that waves bring down on seats of the earth."""
    loading, x = (np.array([0.0, 0.5]), np.array([0.0, 4e6])), np.array([0.0, 0.1, 0.5])
    loop = hs.NormalLoop(*loading, x, np.array([0.0, 1e5, 4e6]), 2e7)
    legs = np.array([(15.0, 8.0, -3.5), (-15.0, -8.0, -3.5)])
    seats = legs + np.array([0.0, 0.0, CENTRE[2] - 0.15])
    wall = hs.Wall(0.2, stiffness=3e6, angle=np.arctan(0.3), depth=1.0)
    seated = ("barge", legs, hs.Seats(seats, extent=6.0), loop, hs.Frictionless())
    landing = hs.Landing(*seated, wall=wall)
    assert apart({**lines(), "legs": landing}, current=0.0, heading=0.0) < 1e-9


def test_tanks_that_are_pumped() -> None:
    shape = Box((-10.0, -6.0, -3.0), (10.0, 6.0, 1.0))
    level = hs.Plan(np.array([0.0, 25.0]), np.array([2.0, 0.5]))
    tank = hs.Tank("hold", shape, 2.0, plan=level)
    assert apart(tanks=(tank,)) < 1e-9
