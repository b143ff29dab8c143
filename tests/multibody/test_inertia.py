"""Accelerations in two steps against numpy's solution of S^T M S q'' = S^T (F - M S' q')."""

from __future__ import annotations

import numpy as np
import pytest
from scenes import INERTIA, block, scene
from scipy import linalg

import hydrosim as hs
from hydrosim.dofs import DOFS
from hydrosim.multibody.kinematics import new_motion, place_bodies
from hydrosim.multibody.mass import accelerate_freely, constant_inertia, new_turning
from hydrosim.scene import Kinematics

RNG = np.random.default_rng(11)
MASSES = (2.0, 5.0)
FREE = {
    "all": (DOFS, DOFS),
    "in the plane": (("surge", "heave", "pitch"), ("surge", "heave", "pitch")),
    "some": (("heave", "yaw", "roll"), ("surge",)),
    "no angles": (("surge", "heave"), ("sway",)),
    "angles alone": (("pitch", "yaw"), ("roll",)),
}


def by_numpy(model, motion, added, F):
    """q'' of the free coordinates, from the whole matrix."""
    S = linalg.block_diag(*(x for E in motion.rate_map for x in (np.eye(3), E)))
    turned = motion.rotation if model.bodies.exact else [np.eye(3)] * 2
    both = zip(MASSES, turned, strict=True)
    blocks = (x for m, R in both for x in (m * np.eye(3), m * R @ INERTIA @ R.T))
    M, S = added + linalg.block_diag(*blocks), S[:, model.bodies.active]
    return np.linalg.solve(S.T @ M @ S, S.T @ (F - M @ motion.bias))


@pytest.mark.parametrize("free", FREE.values(), ids=FREE)
@pytest.mark.parametrize("kinematics", Kinematics)
@pytest.mark.parametrize("coupled", [True, False])
def test_accelerations_are_those_of_the_whole_matrix(free, kinematics, coupled):
    bodies = [block(m, dofs, name) for m, dofs, name in zip(MASSES, free, "ab", strict=True)]
    model = hs.compile_scene(scene(bodies, {}, 1.0, 0.5, kinematics=kinematics)).model
    root = RNG.normal(size=(12, 12))
    added, F, n = root @ root.T, RNG.normal(size=12), model.bodies.active.size
    if not coupled:
        added[:6, 6:] = added[6:, :6] = 0.0
    motion, x = new_motion(model.bodies), np.full(n, np.nan)
    place_bodies(RNG.normal(size=n), RNG.normal(size=n), model.bodies, motion)
    inertia = constant_inertia(model.bodies, added)
    assert inertia.alone == (not coupled and n == 12)
    accelerate_freely(inertia, model.bodies, motion, F, new_turning(inertia), x)
    assert x == pytest.approx(by_numpy(model, motion, added, F), rel=1e-9, abs=1e-10)


def test_a_body_without_mass_has_no_acceleration():
    bodies = [block(m, name=name) for m, name in zip(MASSES, "ab", strict=True)]
    model = hs.compile_scene(scene(bodies, {}, 1.0, 0.5)).model
    assert np.isnan(constant_inertia(model.bodies, -10.0 * np.eye(12)).inverse).all()
