"""Hulls in forced oscillation: the force of a drive over one steady period gives added mass and
damping.

    F = (M + A) q'' + B q' + C q,    q = a sin(w t)

A follows from the part of F in phase with q, B from the part in phase with q', and B once more from
the booked work, pi w B a^2 in a period.

The reference is what the model of radiation promises at this frequency: the transfer function of
the fitted states, or of the table of retardation functions. That of the constant model is the row
of the database. States and tables miss the database itself by its own error: A(w) and B(w) of a
panel method do not obey the relation of Kramers and Kronig exactly (`LIMITS`).
"""

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import xarray as xr

import hydrosim as hs
from hydrosim.compile.compiled import Compiled
from hydrosim.compile.hydrodynamic_groups import each_alone
from hydrosim.dofs import DOFS
from hydrosim.elements import Drive, Harmonic
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import (
    ConstantRadiation,
    ConvolutionRadiation,
    Kinematics,
    Method,
    StateSpaceRadiation,
)
from hydrosim.water.radiation.retardation import transfer_function

Validated = Callable[..., None]
DATABASES = Path(__file__).parents[3] / "hydro_db"
WITHIN = 1e-5
STEPS = 100  # in a period
SETTLED = {"states": 200.0, "convolution": 130.0, "constant": 20.0}  # s, without transients
HULLS = {
    "sphere": (261.8e3, (2.54, 2.54, 3.16), -2.0, 1000.0),
    "h851": (1.4e8, (20.0, 75.0, 75.0), 5.0, 1025.0),
}
"""Mass, radii of gyration, height of the centre of gravity, density of the water."""
FREQUENCIES = {"sphere": (1.2, 2.0), "h851": (0.5, 0.7)}
"""Two frequencies [rad/s] of the databases, about where the hulls radiate most."""
LIMITS = {"sphere": 1.5e-3, "h851": 5e-3}
"""Largest difference from the database itself, by its own error: of A, and of B over the
largest."""
CASES = [(hull, dof) for hull in HULLS for dof in ("heave", "sway", "roll")]


class Coefficients(NamedTuple):
    """Added mass, damping, and damping by the booked work."""

    added_mass: float
    damping: float
    by_work: float

    def largest_error(self, A: float, B: float, largest: float) -> float:
        """Of A, and of B over the ``largest``."""
        missed = abs(self.damping - B), abs(self.by_work - B)
        return max(abs(self.added_mass / A - 1.0), *(error / largest for error in missed))


def forced(hull: str, dof: str, model: str, w: float) -> tuple[Compiled, xr.Dataset]:
    """A hull that moves in one degree of freedom alone, by a sine of unit amplitude."""
    period = 2.0 * np.pi / w
    mass, radii, height, density = HULLS[hull]
    radiation: dict[str, Any] = {
        "states": StateSpaceRadiation(),
        "convolution": ConvolutionRadiation(),
        "constant": ConstantRadiation(period),
    }
    body = hs.Body(
        "hull",
        mass,
        mass * np.diag(np.square(radii)),
        hydrodynamics=DATABASES / f"{hull}.nc",
        centre_of_gravity=(0.0, 0.0, height),
        dofs=(dof,),
        radiation=radiation[model],
    )
    key = "angle" if dof in DOFS[3:] else "offset"
    scene = hs.Scene(
        "forced oscillation",
        (int(SETTLED[model] / period) + 1) * period,
        (body,),
        hs.Environment(water_density=density),
        forces={"shake": Drive("hull", dof=dof, **{key: Harmonic(1.0, period)})},
        solver=hs.Solver(method=Method.RK4, step=period / STEPS, kinematics=Kinematics.LINEAR),
        output={"step": period / STEPS},
    )
    return hs.compile_scene(scene), hs.simulate(scene)


@cache
def measured(hull: str, dof: str, model: str, w: float) -> tuple[Compiled, Coefficients]:
    """What the last period gives."""
    compiled, run = forced(hull, dof, model, w)
    time = run.time.values[-STEPS:]
    force = run.drive_force.values[-STEPS:, 0]
    in_phase = 2.0 * np.mean(force * np.sin(w * time))
    ahead = 2.0 * np.mean(force * np.cos(w * time))
    work = run.energy_work_shake.values
    i = DOFS.index(dof)
    body = compiled.model.bodies.each[0]
    mass = body["mass"] if i < 3 else body["inertia"][i - 3, i - 3]
    stiffness = _database(compiled).hydrostatic_stiffness[i, i]
    A = (stiffness - in_phase) / w**2 - mass
    return compiled, Coefficients(A, ahead / w, (work[-1] - work[-1 - STEPS]) / (np.pi * w))


def _database(compiled: Compiled) -> Any:
    return each_alone(compiled.wet)["hull"]


def promised(compiled: Compiled, dof: str, model: str, w: float) -> tuple[float, float]:
    """A and B of the model of radiation at a frequency of the database."""
    i = DOFS.index(dof)
    (wet,) = compiled.wet
    infinite = compiled.model.added_mass[i, i]
    if model == "states":
        fit = next(fit for fit in wet.fits if i in wet.dofs[fit.dofs])
        j = [*wet.dofs[fit.dofs]].index(i)
        K = fit.C[j] @ np.linalg.solve(1j * w * np.eye(fit.order) - fit.matrix, fit.B[:, j])
    else:
        kernel = wet.memory.kernel[:, i, i][:, None, None]
        K = transfer_function(wet.memory.time, kernel, np.array([w]))[0, 0, 0]
    return infinite + K.imag / w, K.real


def of_database(compiled: Compiled, dof: str, w: float) -> tuple[float, float, float]:
    """A and B of the database, and its largest B."""
    db = _database(compiled)
    i = DOFS.index(dof)
    k = int(np.abs(db.frequency - w).argmin())
    assert db.frequency[k] == pytest.approx(w, rel=1e-9)
    B = db.radiation_damping[:, i, i]
    return float(db.added_mass[k, i, i]), float(B[k]), float(B.max())


@pytest.mark.parametrize("model", ["states", "convolution"])
@pytest.mark.parametrize(("hull", "dof"), CASES)
def test_the_force_gives_added_mass_and_damping_of_the_model(
    hull: str, dof: str, model: str, validated: Validated
) -> None:
    for w in FREQUENCIES[hull]:
        compiled, found = measured(hull, dof, model, w)
        A, B = promised(compiled, dof, model, w)
        _, _, largest = of_database(compiled, dof, w)
        claim = f"forced oscillation with {model}: A, B and work"
        against = "transfer functions of fits and retardation functions"
        features = (Feature.RADIATION, Feature.DRIVES)
        error = found.largest_error(A, B, largest)
        validated(Kind.CLOSED_FORM, claim, against, error, WITHIN, *features)


@pytest.mark.parametrize(("hull", "dof"), CASES)
def test_the_constant_model_gives_the_row_of_the_database(
    hull: str, dof: str, validated: Validated
) -> None:
    for w in FREQUENCIES[hull]:
        compiled, found = measured(hull, dof, "constant", w)
        claim, against = "forced oscillation with constant radiation: A, B and work", "database"
        error = found.largest_error(*of_database(compiled, dof, w))
        validated(Kind.CLOSED_FORM, claim, against, error, WITHIN, Feature.DRIVES)


@pytest.mark.parametrize("model", ["states", "convolution"])
@pytest.mark.parametrize(("hull", "dof"), CASES)
def test_the_database_is_met_to_its_own_error(
    hull: str, dof: str, model: str, figure: Callable[[str, float], None]
) -> None:
    worst = 0.0
    for w in FREQUENCIES[hull]:
        compiled, found = measured(hull, dof, model, w)
        A, B, largest = of_database(compiled, dof, w)
        worst = max(worst, abs(found.added_mass / A - 1.0), abs(found.damping - B) / largest)
    figure("of A, and of the largest B", worst)
    assert worst < LIMITS[hull]
