"""A flap on a hinge at its foot that decays from 40 deg, against an equation of one coordinate.

With h from the hinge up to the centre of gravity, the velocity of the body (6,) is v = s(a) a',
s = (h cos a, 0, -h sin a, 0, 1, 0). Its heading stays, so that A_inf and the memory act on v:

    s (M + A_inf) s a'' + s (M + A_inf) s_a a'^2 = s F,    x' = L x + B v
    F = (rho g V - m g) e_z - C d - K x,   d = (h sin a, 0, h (cos a - 1), 0, a, 0)

Weight and buoyancy are forces at the centre of gravity; C acts on displacement and angle. A_inf, L,
B and K are those of hydrosim's fit, C and V those of the database. The dimensions are spelled out.
"""

from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

import hydrosim as hs
from hydrosim.compile.compile import compile_scene
from hydrosim.report.evidence import Feature, Kind

ROOT = Path(__file__).parents[3]
MASS, RADII, HEIGHT = 164e3, np.array([5.8, 3.5, 4.7]), 4.0
ANGLE = np.radians(40.0)
DURATION = 40.0


def flap(**settings: object) -> hs.Scene:
    """The case by states of radiation, with other settings: keys have __ for dots."""
    changes = {"bodies.flap.radiation": "state_space", "duration": DURATION}
    changes |= {key.replace("__", "."): value for key, value in settings.items()}
    return hs.load_case(ROOT / "cases" / "flap" / "decay.yaml", changes).scene()


@cache
def expected() -> np.ndarray:
    """Angle (nt,) every 0.1 s."""
    (group,) = compile_scene(flap()).wet
    with xr.open_dataset(ROOT / "hydro_db" / "flap.nc") as db:
        C, weight = db.hydrostatic_stiffness.values, float(db.water_density * db.gravity)
        lift = weight * float(db.volume[0]) - MASS * float(db.gravity)
    M = np.diag(np.append(np.full(3, MASS), MASS * RADII**2)) + group.added_mass
    ends = np.cumsum([2, *(fit.order for fit in group.fits)])

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        a, rate = y[:2]
        up, out = HEIGHT * np.cos(a), HEIGHT * np.sin(a)
        s, s_a = np.array([up, 0, -out, 0, 1, 0]), np.array([-out, 0, -up, 0, 0, 0])
        F = np.array([0, 0, lift, 0, 0, 0]) - C @ [out, 0, up - HEIGHT, 0, a, 0]
        slopes = [np.array([rate, 0.0])]
        for fit, begin, end in zip(group.fits, ends[:-1], ends[1:], strict=True):
            x = y[begin:end]
            F[fit.dofs] -= fit.C @ x
            slopes.append(fit.matrix @ x + fit.B @ (s * rate)[fit.dofs])
        slopes[0][1] = (s @ F - s @ M @ s_a * rate**2) / (s @ M @ s)
        return np.concatenate(slopes)

    start = np.zeros(ends[-1])
    start[0] = ANGLE
    times = np.linspace(0.0, DURATION, round(DURATION / 0.1) + 1)
    given = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-12, "t_eval": times}
    found = solve_ivp(rates, (0.0, DURATION), start, **given)
    assert found.success
    return np.asarray(found.y[0])


def error_of(scene: hs.Scene) -> float:
    """Largest difference of the angle, of its range, and that the pitch is the joint's angle."""
    run = hs.simulate(scene)
    angle = run.joint_position.sel(joint_motion="hinge angle").values
    pitch = run.position.sel(body="flap", dof="pitch").values
    np.testing.assert_allclose(pitch, angle, atol=1e-15)
    return float(np.abs(angle - expected()).max() / np.ptp(expected()))


def test_decay_from_a_large_angle(validated) -> None:
    """It swings back beyond 30 deg: a linear stiffness would miss 8 per cent of the moment."""
    assert np.degrees(expected().min()) < -30.0
    tight = {"solver__method": "dopri5", "solver__tolerance": {"relative": 1e-10}}
    claim = "flap on a hinge, decay from 40 deg, of its range"
    against, features = "DOP853 of its own equation", (Feature.JOINTS, Feature.ROTATIONS)
    error, features = error_of(flap(**tight)), (*features, Feature.RADIATION)
    validated(Kind.INDEPENDENT, claim, against, error, 1e-8, *features)


def test_order_of_rk4() -> None:
    errors = [error_of(flap(solver__step=step)) for step in (0.1, 0.05)]
    assert errors[0] < 1e-5
    assert np.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.2)
