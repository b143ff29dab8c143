"""Two wet bodies on a vertical hinge that drift and turn in a current: impulse, energy, Hamilton.

Each body i moves water with T_i = w^T A_i(psi_i) w / 2, w = v - U, A_i(psi) = P(psi) A_i P(psi)^T
(Kirchhoff; U: current, psi_i: its heading). Seen from the water, x - U t, nothing acts from outside
but a restoring energy V in heave, roll and pitch. So T + V does not depend on horizontal shifts and
on a common turn about the vertical, in which all psi_i grow alike. By Noether these are kept:

    P   = sum of m w_t + p                              in x and y,  (p, G) = A(psi) w
    L   = sum of x_rel x (m w_t + p) + R I R^T omega + G   about z,  x_rel = x - U t
    E   = sum of m w_t^2 / 2 + omega R I R^T omega / 2 + w^T A(psi) w / 2  + V

The water's impulse p acts at the centre of gravity, about which A is. With the hinge's axis
vertical at rest, the heading of the second body is that of the first and the angle of the hinge.

Hamilton's equations of the same T and V are the independent model. Its coordinates q are place and
angles of the first body, seen from the water, and the angle of the hinge:

    q' = M(q)^-1 s,   s' = q'^T M_q q' / 2 - V_q,   T = q'^T M(q) q' / 2;  M_q by the complex step.
"""

from dataclasses import replace
from functools import cache
from math import radians

import numpy as np
import pytest
import xarray as xr
from jointed import apart, carried, completed, joint, moved, places, rotations, scene
from scenes import stream_of, turned_scene
from scipy.spatial.transform import Rotation
from solutions import about, skew, solved
from turning import points, turned_back

from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Coefficients, Environment, Joint, Scene, Symmetry, Weight

KEPT = 1e-10  # of impulses and energies
WITHIN = 1e-9  # of the range
TINY = 1e-30  # complex step
DURATION = 14.0
TIME = np.linspace(0.0, DURATION, 71)
CURRENT = np.array([0.9, -0.6, 0.0])
MASS = (4.0, 3.0)
INERTIA = (
    np.array([[5.0, -0.4, 0.2], [-0.4, 9.0, 0.3], [0.2, 0.3, 12.0]]),
    np.array([[3.0, 0.2, 0.1], [0.2, 4.0, -0.2], [0.1, -0.2, 6.0]]),
)
ARM = (np.array([1.5, 0.2, 0.1]), np.array([-1.2, 0.1, 0.3]))  # from each centre to the hinge
STIFFNESS = np.diag([0.0, 0.0, 60.0, 90.0, 110.0, 0.0])  # of the first body
RATES = (0.5, -0.3, 0.1, 0.1, -0.08, 0.35)  # of the first body, seen from the water
HINGE = (0.3, -0.9)  # angle and rate
Z = np.array([0.0, 0.0, 1.0])


def added_mass(seed: int, mass: float) -> np.ndarray:
    """A positive definite added mass, all of whose couplings are there."""
    root = np.random.default_rng(seed).normal(size=(6, 6)) * 0.35 * np.sqrt(mass)
    return root @ root.T + mass * np.diag([0.1, 0.6, 0.8, 0.5, 0.7, 0.6])


ADDED = (added_mass(1, MASS[0]), added_mass(2, MASS[1]))


def hinged() -> Joint:
    """The vertical hinge of the pair."""
    return joint("hinge", "aft", "fore", moved(*HINGE), point=tuple(ARM[1]), axis=tuple(Z))


def pair(current: np.ndarray = CURRENT, held: Joint | None = None) -> Scene:
    """The pair, launched in a current; on its vertical hinge, or ``held`` by another joint."""
    zero = np.zeros((6, 6))
    place = (ARM[0] - ARM[1]).tolist()
    bodies = []
    for i, (name, centre) in enumerate((("fore", (0.0, 0.0, 0.0)), ("aft", place))):
        water = Coefficients(ADDED[i], zero, STIFFNESS if i == 0 else zero)
        wet = {"weight": Weight.BALANCED, "hydrodynamics": water}
        bodies.append(carried(name, MASS[i], INERTIA[i], centre, **wet))
    first, second = bodies
    first = replace(first, velocity=(*(RATES[:3] + current), *RATES[3:]))
    joints = {"pin": held or hinged()}
    found = scene([first, second], joints, DURATION, output_step=0.2)
    solver = replace(found.solver, symmetry=Symmetry.IGNORE)
    return replace(found, environment=Environment(current=stream_of(current)), solver=solver)


@cache
def the_run() -> xr.Dataset:
    """The run of the pair."""
    return completed(pair())


def impulses_and_energy(run: xr.Dataset) -> np.ndarray:
    """P in x and y, L about z, and E over time, (nt, 4)."""
    heading = _headings(run)
    kept = np.zeros((run.time.size, 4))
    for i, name in enumerate(("fore", "aft")):
        R, velocity = rotations(run, name), run.velocity.sel(body=name).values
        place = places(run, name) - CURRENT * run.time.values[:, None]
        w = velocity - [*CURRENT, 0.0, 0.0, 0.0]
        P = np.zeros((run.time.size, 6, 6))
        P[:, :3, :3] = P[:, 3:, 3:] = about(2, heading[i])
        water = np.einsum("tij,jk,tlk,tl->ti", P, ADDED[i], P, w)
        linear = MASS[i] * w[:, :3] + water[:, :3]
        spin = np.einsum("tij,jk,tlk,tl->ti", R, INERTIA[i], R, w[:, 3:])
        kept[:, :2] += linear[:, :2]
        kept[:, 2] += (np.cross(place, linear) + spin + water[:, 3:])[:, 2]
        body = MASS[i] * np.sum(w[:, :3] ** 2, axis=1) + np.sum(w[:, 3:] * spin, axis=1)
        kept[:, 3] += 0.5 * (body + np.sum(w * water, axis=1))
    q = run.position.sel(body="fore").values
    kept[:, 3] += 0.5 * np.einsum("ti,ij,tj->t", q, STIFFNESS, q)
    return kept


def _headings(run: xr.Dataset) -> tuple[np.ndarray, np.ndarray]:
    """Yaw of the first body, and that with the joint's turn: the twist of its rotation about z."""
    first = run.position.sel(body="fore", dof="yaw").values
    R = np.einsum("tji,tjk->tik", rotations(run, "fore"), rotations(run, "aft"))
    quaternion = Rotation.from_matrix(R).as_quat()
    return first, first + np.unwrap(2.0 * np.arctan2(quaternion[:, 2], quaternion[:, 3]))


def changed(run: xr.Dataset) -> float:
    """Largest change of impulse, angular impulse and energy over a run, of each."""
    kept = impulses_and_energy(run)
    return float((np.ptp(kept, axis=0) / np.abs(kept).max(axis=0)).max())


def test_impulse_and_energy_are_kept(validated) -> None:
    run = the_run()
    assert np.ptp(run.position.sel(body="fore", dof="yaw").values) > np.pi
    claim, against = "hinged pair adrift in a current, change of impulse and energy", "0"
    features = (Feature.JOINTS, Feature.CURRENT)
    validated(Kind.CLOSED_FORM, claim, against, changed(run), KEPT, *features)
    assert run.attrs["energy_residual_relative"] <= KEPT


def other_joint(kind: str, *motions: tuple[float, float], **axes: tuple[float, ...]) -> Joint:
    """Another joint in the place of the hinge."""
    each = [moved(*motion) for motion in motions]
    return joint(kind, "aft", "fore", *each, point=tuple(ARM[1]), **axes)


X, Y = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)
OTHERS = {
    "level hinge": other_joint("hinge", (0.3, -0.4), axis=Y),
    "slanted hinge": other_joint("hinge", (0.2, -0.5), axis=(0.5, 0.2, 1.0)),
    "ball": other_joint("ball", (0.2, 0.1), (-0.3, 0.2), (0.4, -0.5)),
    "universal": other_joint("universal", (0.2, 0.3), (-0.3, 0.2), axis=X, second_axis=Y),
    "vertical universal": other_joint(
        "universal", (0.2, 0.5), (0.1, 0.2), axis=tuple(Z), second_axis=Y
    ),
    "slider": other_joint("slider", (0.1, 0.2), axis=(1.0, 0.3, 0.2)),
    "cylindrical": other_joint("cylindrical", (0.1, -0.1), (0.3, 0.4), axis=(0.2, 0.1, 1.0)),
    "planar": other_joint("planar", (0.1, 0.1), (0.0, -0.1), (0.2, 0.3), axis=(0.1, 0.2, 1.0)),
    "fixed": other_joint("fixed"),
}


@pytest.mark.parametrize("held", OTHERS.values(), ids=list(OTHERS))
def test_impulse_and_energy_are_kept_on_any_joint(held: Joint, figure) -> None:
    """The heading of the second body has a gradient in all turns of the joint that tilt it."""
    run = completed(replace(pair(held=held), duration=6.0))
    error = changed(run)
    figure("change", error)
    assert error <= KEPT
    assert run.attrs["energy_residual_relative"] <= KEPT


class Pair:
    """Hamilton's equations of the pair seen from the water."""

    def jacobians(self, q: np.ndarray) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Of both bodies: the map from q' to velocity and angular velocity (6, 7), R, and P."""
        roll, pitch, yaw, hinge = q[3:]
        turn = about(2, yaw)
        tilt = about(1, pitch)
        R = turn @ tilt @ about(0, roll)
        E = np.stack([turn @ tilt @ np.eye(3)[0], turn @ np.eye(3)[1], Z], axis=1)
        fore = np.zeros((6, 7), dtype=complex)
        fore[:3, :3], fore[3:, 3:6] = np.eye(3), E
        R_aft = R @ about(2, hinge)
        aft = np.zeros((6, 7), dtype=complex)
        aft[3:] = fore[3:]
        aft[3:, 6] = R @ Z
        aft[:3] = fore[:3] - skew(R @ ARM[0]) @ fore[3:]
        aft[:3] += skew(R_aft @ ARM[1]) @ aft[3:]
        return [(fore, R, turn), (aft, R_aft, about(2, yaw + hinge))]

    def mass(self, q: np.ndarray) -> np.ndarray:
        """M(q)."""
        M = np.zeros((7, 7), dtype=complex)
        for i, (S, R, turn) in enumerate(self.jacobians(q)):
            P = np.kron(np.eye(2), turn)
            own = P @ ADDED[i] @ P.T
            own[:3, :3] += MASS[i] * np.eye(3)
            own[3:, 3:] += R @ INERTIA[i] @ R.T
            M += S.T @ own @ S
        return M

    def __call__(self, t: float, y: np.ndarray) -> np.ndarray:
        q, s = y[:7], y[7:]
        rate = np.linalg.solve(self.mass(q).real, s)
        force = np.zeros(7)
        for k in range(3, 7):  # M does not depend on the place
            shifted = q + 1j * TINY * (np.arange(7) == k)
            force[k] = 0.5 * rate @ self.mass(shifted).imag @ rate / TINY
        force[:6] -= STIFFNESS @ q[:6]
        return np.concatenate([rate, force])

    def motion(self) -> tuple[np.ndarray, np.ndarray]:
        """Centres of both bodies (nt, 3), in the earth frame."""
        q0 = np.array([0.0] * 6 + [HINGE[0]])
        roll, pitch, yaw = RATES[3:]  # at zero angles the rates are the angular velocity
        rate = np.array([*RATES[:3], roll, pitch, yaw, HINGE[1]])
        y = solved(self, [*q0, *(self.mass(q0).real @ rate)], TIME).T
        drift = CURRENT * TIME[:, None]
        fore = y[:, :3] + drift
        aft = []
        for q in y[:, :7]:
            (_, R, _), (_, R_aft, _) = self.jacobians(q)
            aft.append((R @ ARM[0] - R_aft @ ARM[1]).real)
        return fore, fore + np.array(aft)


def test_motions_by_hamilton(validated) -> None:
    fore, aft = Pair().motion()
    run = the_run()
    error = max(apart(places(run, "fore"), fore), apart(places(run, "aft"), aft))
    claim, against = "hinged pair adrift in a current", "Hamilton's equations by DOP853"
    features = (Feature.JOINTS, Feature.CURRENT)
    validated(Kind.INDEPENDENT, claim, against, error, WITHIN, *features)


@pytest.mark.parametrize("by", [radians(37.0), radians(123.0)])
def test_the_pair_turned(by: float, figure) -> None:
    shift = (3.0, 5.0)
    run = completed(turned_scene(pair(), by, shift))
    before, after = points(the_run(), pair()), turned_back(points(run, pair()), by, shift)
    error = np.abs(after - before).max() / np.ptp(before, axis=0).max()
    figure("error", error)
    assert error <= WITHIN


def test_a_current_carries_the_pair_along(figure) -> None:
    """Seen from the water, the motion is that in still water."""
    still = completed(pair(np.zeros(3)))
    drift = CURRENT * TIME[:, None]
    error = apart(places(the_run(), "aft") - drift, places(still, "aft"))
    figure("error", error)
    assert error <= WITHIN
