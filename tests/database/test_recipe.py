"""The recipe's use of Capytaine, on few panels. The first run ever tabulates a Green function."""

from __future__ import annotations

import numpy as np
import pytest

from hydrosim.database.build import barge as hull

pytest.importorskip("capytaine", reason="capytaine is not installed (pip install .[bem])")

import h851

from hydrosim.database.build import assemble, bem

COARSE = hull.Resolution((5, 4, 11, 8, 5), 6, 3, 6, 2, (7, 14, 12), 5)


@pytest.fixture(scope="module")
def body():
    shape = h851.hull()
    shift = [-hull.hydrostatics(shape).centre_of_buoyancy[0], 0.0, 0.0]
    half, lid = hull.half_hull(shape, COARSE) + shift, hull.half_lid(shape, COARSE) + shift
    return bem.floating_body(half, lid, h851.floating(shape).centre_of_gravity)


def test_few_panels_come_near_the_database(barge, body):
    """Some 700 panels: the study finds 5, 8 and 6 per cent of the largest value for added mass,
    damping and loads with 550."""
    rows = [29, 39, 49]
    frequencies, headings = barge.frequency[rows], barge.heading[[0, 4, 12]]
    solutions = bem.solve_all(body, bem.Water(), frequencies, headings, jobs=1)
    db = assemble.assemble(
        h851.floating(h851.hull()),
        bem.Water(),
        headings,
        solutions,
        (barge.added_mass_zero, barge.added_mass_infinite),
        {},
    )
    for name, limit in (("added_mass", 0.05), ("radiation_damping", 0.08)):
        fine, coarse = getattr(barge, name), getattr(db, name)
        scale = np.sqrt(np.abs(np.diagonal(fine, axis1=1, axis2=2)).max(axis=0))
        assert np.max(np.abs(coarse - fine[rows]) / np.outer(scale, scale)) < limit
    fine = barge.excitation[:, [0, 4, 12]]
    error = np.abs(db.excitation - fine[rows]).max(axis=(0, 1))
    assert (error <= 0.06 * np.abs(fine).max(axis=(0, 1))).all()


def test_froude_krylov_of_a_box():
    """-2 i rho g B (1 - exp(-k T)) / k sin(k L / 2) for exp(-i w t), so its conjugate here."""
    length, beam, draught, w = 100.0, 20.0, 5.0, 0.6
    shape = hull.Barge(length, beam, draught, beam, 30.0, 40.0, draught, 10.0)
    mesh = hull.Resolution((4, 8, 8, 5, 4), 4, 4, 4, 4, (5, 5, 5), 3)
    shift = [-length / 2, 0.0, 0.0]
    box = bem.floating_body(
        hull.half_hull(shape, mesh) + shift, hull.half_lid(shape, mesh) + shift, (0.0, 0.0, 0.0)
    )
    solution = bem.solve(box, bem.Water(), w, np.zeros(1))
    k, rho_g = w**2 / 9.81, 1025 * 9.81
    exact = 2j * rho_g * beam * (1 - np.exp(-k * draught)) / k * np.sin(k * length / 2)
    assert solution.froude_krylov[0, 0] == pytest.approx(exact, rel=2e-3)
