"""Difference-frequency QTF by pressure integration: hydrostatics of a turned box, closed forms of
a vertical cylinder, WAMIT's hemisphere, limits of short and long waves, symmetries."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import h1vp, hankel1, jv, jvp

pytest.importorskip("capytaine", reason="capytaine is not installed (pip install .[bem])")

from hydrosim.database.build import barge as hull
from hydrosim.database.build import bem, drift, near_field, qtf
from hydrosim.database.build.assemble import Floating

RHO, G = 1025.0, 9.81
WATER = bem.Water(RHO, G)
WAMIT = Path(__file__).parents[2] / ".." / "shared" / "validation" / "hemisphere"


def box(length: float, beam: float, draught: float, centre, fine: int = 1):
    """A box and its hydrostatics, amidships at x = 0."""
    third = length / 3
    shape = hull.Barge(length, beam, draught, beam, third, third, draught, third / 2)
    along = tuple(fine * n for n in (4, 4, 8, 4, 4))
    down, across, lid = 4 * fine, 4 * fine, (3 * fine, 4 * fine, 3 * fine)
    mesh = hull.Resolution(along, across, down, 2 * across, down, lid, 2 * fine)
    shift = [-length / 2, 0.0, 0.0]
    half, inside = hull.half_hull(shape, mesh) + shift, hull.half_lid(shape, mesh) + shift
    return bem.floating_body(half, inside, centre), hull.hydrostatics(shape)


def shell(profile: np.ndarray, around: int, lid: int):
    """Body of revolution about z, ``profile`` (n, 2) of (r, z) from the bottom's middle to the
    waterline; moments about the origin."""
    turn = np.linspace(0, np.pi, around + 1)

    def swept(line):
        r, z = line[:, 0, None], line[:, 1, None]
        grid = np.stack(np.broadcast_arrays(r * np.cos(turn), r * np.sin(turn), z), axis=-1)
        rings = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
        return np.stack(rings, axis=2).reshape(-1, 4, 3)[:, ::-1]

    disc = np.stack([np.linspace(0, profile[-1, 0], lid + 1), np.zeros(lid + 1)], axis=-1)
    return bem.floating_body(swept(profile), swept(disc), (0.0, 0.0, 0.0))


def hemisphere(down: int, around: int):
    """Radius 1 m, a little more for the panels to hold the true volume."""
    angle = np.linspace(0, np.pi / 2, down + 1)
    return shell(np.stack([np.sin(angle), -np.cos(angle)], axis=-1), around, max(2, down // 2))


def mean(transfer):
    return np.real(np.einsum("iic->ic", transfer))


# ------------------------------------------------------------------ hydrostatics


def turned_load(sides, centre, motion) -> np.ndarray:
    """Buoyancy and weight (6,) on a wall-sided box moved by ``motion``, about its moved centre of
    gravity: columns of water under a plane, integrated exactly."""
    length, beam, draught = sides
    R = Rotation.from_rotvec(motion[3:]).as_matrix()
    nodes, weights = np.polynomial.legendre.leggauss(4)
    x, y = np.meshgrid(length / 2 * nodes - centre[0], beam / 2 * nodes - centre[1], indexing="ij")
    area = np.outer(weights, weights) * length * beam / 4
    top = -(centre[2] + motion[2] + R[2, 0] * x + R[2, 1] * y) / R[2, 2]
    bottom = -draught - centre[2]
    volume = np.sum(area * (top - bottom))
    moment = np.array([np.sum(area * (top - bottom) * a) for a in (x, y)])
    arm = R @ [*moment, np.sum(area * (top**2 - bottom**2)) / 2]
    weight = length * beam * draught
    return RHO * G * np.concatenate([[0, 0, volume - weight], np.cross(arm, [0, 0, 1.0])])


@pytest.mark.parametrize("motion", ["heave", "roll", "pitch and heave", "all"])
def test_a_turned_box_in_still_water(made_up, motion):
    """Terms of the waterline, of rotation and of its second order, against exact hydrostatics:
    the second difference of the load on a wall-sided box. Panels are exact here."""
    moved = {"heave": [2], "roll": [3], "pitch and heave": [2, 4], "all": [0, 1, 2, 3, 4, 5]}
    xi = np.zeros(6)
    xi[moved[motion]] = np.array([0.3, -0.5, 0.7, 1.1, -0.8, 0.6])[moved[motion]]
    sides, centre = (60.0, 20.0, 6.0), np.array([0.0, 0.0, 1.5])
    wetted = near_field.wetted_surface(box(*sides, centre, fine=4)[0])
    step = 1e-3
    loads = [turned_load(sides, centre, s * step * xi) for s in (-1, 0, 1)]
    first, second = (loads[2] - loads[0]) / (2 * step), (loads[2] - 2 * loads[1] + loads[0]) / 2
    rise = -near_field.displacement(xi[None], wetted.edge_arm)[..., 2]
    still = np.zeros((1, *wetted.arm.shape))
    flow = near_field.Flow(0.0, xi[None] + 0j, first[None] + 0j, still + 0j, rise + 0j)
    db = made_up(water_density=RHO, gravity=G)
    load = 2 * mean(qtf.quadratic(db, wetted, [flow], 0, 0))[0]  # the mean is half the square
    scale = RHO * G * 1200.0 * np.array([1, 1, 1, 20, 20, 20])
    np.testing.assert_allclose(load / scale, second / step**2 / scale, atol=2e-3)
