"""Natural modes by their shapes: free ones, two bodies, and closed forms."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from markers import few
from scenes import block

import hydrosim as hs
from hydrosim.errors import InputError
from hydrosim.linear.linearise import Linear, linearise, nullspace_of
from hydrosim.linear.modes import ModeKind, NaturalMode, modes_of_stiffness, natural_modes

CASES = Path(__file__).parents[2] / "cases"
HYDRO_DB = Path(__file__).parents[2] / "hydro_db"


def modes_of(*bodies: hs.Body, **forces: hs.LinearMooring | hs.Spring) -> list[NaturalMode]:
    scene = hs.Scene("modes", 1.0, bodies, forces=forces)
    return natural_modes(linearise(*hs.compile_scene(scene)))


def held(body: str, k: float, c: float = 0.0) -> hs.LinearMooring:
    along = np.diag([1.0, 0, 0, 0, 0, 0])
    return hs.LinearMooring(body, k * along, damping=c * along)


def test_free_modes_are_free_whatever_damps_them() -> None:
    """Surge on a spring; sway free, heave free in a damper: neither has a period or a damping."""
    body = block(3.0, ["surge", "sway", "heave"])
    mooring = replace(held("block", 12.0), damping=np.diag([0.0, 0.0, 5.0, 0.0, 0.0, 0.0]))
    surge, sway, heave = modes_of(body, mooring=mooring)
    assert surge.kind == ModeKind.OSCILLATING
    assert surge.natural_period == pytest.approx(2 * np.pi / 2.0)
    for mode, dof in ((sway, "sway"), (heave, "heave")):
        assert (mode.kind, mode.dof) == (ModeKind.FREE, dof)
        assert mode.natural_period == np.inf


def test_a_body_that_friction_holds_has_no_modes() -> None:
    """Its one coordinate is held by the floor; `hydrosim check` says so."""
    case = hs.load_case(CASES / "friction_block" / "held.yaml")
    assert natural_modes(linearise(*hs.compile_scene(case.scene()))) == []


def test_kinds_of_motion() -> None:
    """x'' + c x' + k x = 0: critical is c = 2 sqrt(k); a negative stiffness falls away."""
    body = block(1.0, ["surge"])
    for k, c, kind in (
        (4.0, 1.0, ModeKind.OSCILLATING),
        (4.0, 9.0, ModeKind.OVERDAMPED),
        (-4.0, 1.0, ModeKind.UNSTABLE),
        (4.0, -1.0, ModeKind.UNSTABLE),
    ):
        (mode,) = modes_of(body, mooring=held("block", k, c))
        assert mode.kind == kind
        roots = np.roots([1.0, c, k])
        assert np.abs(roots - mode.eigenvalue).min() < 1e-6


@pytest.mark.parametrize("start", few(["roll: 5 deg, yaw: 30 deg", "heave: 1 m", "roll: 1 deg"], 1))
def test_a_body_of_revolution_rolls_as_it_pitches(tmp_path: Path, start: str) -> None:
    """Wherever it is, afloat and free: the modes of one period are told apart."""
    case = tmp_path / "case.yaml"
    case.write_text(
        "{title: free, duration: 10 s, environment: {water_density: 1000 kg/m^3}, bodies: {sphere:"
        f" {{hydrodynamics: {HYDRO_DB}/sphere.nc, mass: 261.8e3 kg, centre_of_gravity: [0, 0, -2],"
        f" radii_of_gyration: [2.54, 2.54, 3.16], initial: {{position: {{{start}}}}}}}}}}}"
    )
    scene = hs.load_case(case).scene()
    modes = {mode.dof: mode for mode in natural_modes(linearise(*hs.compile_scene(scene)))}
    assert {mode.kind for mode in modes.values()} == {ModeKind.OSCILLATING, ModeKind.FREE}
    roll, pitch = modes["roll"], modes["pitch"]
    tilt = np.cos(np.radians(5.0))  # the stiffness of a hull without walls, linear as it is
    assert roll.natural_period == pytest.approx(pitch.natural_period, rel=1.0 - tilt)
    assert roll.eigenvalue == pytest.approx(pitch.eigenvalue, rel=3.0 * (1.0 - tilt))


def test_modes_of_two_bodies_are_kept_apart() -> None:
    """Two blocks on springs, joined by a third one: (K, M) by hand. Equal blocks move half and half
    in both modes, and each mode is named after another of them."""
    K, M = np.array([[7.0, -3.0], [-3.0, 7.0]]), np.eye(2)
    joint = hs.Strut("a", (0, 0, 0), (0, 0, 0), stiffness=3.0, anchor_body="b")
    for mass in (1.0, 2.5):
        M[1, 1] = mass
        bodies = (block(1.0, ["surge"], "a"), block(mass, ["surge"], "b", location=(20.0, 0.0)))
        modes = modes_of(*bodies, one=held("a", 4.0), other=held("b", 4.0), joint=joint)
        squares, shapes = np.linalg.eig(np.linalg.solve(M, K))
        assert sorted(mode.coordinate for mode in modes) == [0, 6]
        for mode in modes:
            k = np.argmin(np.abs(squares - (2 * np.pi / mode.natural_period) ** 2))
            assert mode.natural_period == pytest.approx(2 * np.pi / np.sqrt(squares[k]), rel=1e-6)
            energy = np.diag(M) * shapes[:, k] ** 2
            np.testing.assert_allclose(mode.share, energy / energy.sum(), atol=1e-6)
        ratio = shapes[1, k] / shapes[0, k]
        assert mode.shape[1] / mode.shape[0] == pytest.approx(ratio, rel=1e-6)


def random_linear(seed: int, n: int, others: int) -> Linear:
    """A stable system with other states; two pairs have nearly parallel eigenvectors."""
    random = np.random.default_rng(seed).standard_normal
    M, K = (x @ x.T + n * np.eye(n) for x in random((2, n, n)))
    A = np.zeros((2 * n + others, 2 * n + others))
    A[:n, n : 2 * n] = np.eye(n)
    felt, driven = random((n, others)), random((others, n))
    A[n : 2 * n, :n] = -np.linalg.solve(M, K)
    A[n : 2 * n, 2 * n :] = -0.1 * np.linalg.solve(M, felt)
    A[2 * n :, n : 2 * n] = 0.1 * driven
    A[2 * n :, 2 * n :] = np.triu(random((others, others))) * 0.2 - np.eye(others)
    return Linear(A, np.arange(len(A)), np.arange(n), nullspace_of(np.zeros((0, n)), M))


@pytest.mark.parametrize("defective", [False, True])
def test_dynamic_stiffness_by_diagonalising_is_that_by_solving(defective: bool) -> None:
    """D q = M G^-1 q, G the top right block of (i w - J)^-1; with a Jordan block too."""
    n, linear = 3, random_linear(1, 3, 8)
    if defective:
        linear.jacobian[2 * n :, 2 * n :] = -np.eye(8) + np.eye(8, k=1)
    omega = np.array([0.2, 1.0, 4.0])
    found = linear.dynamic_stiffness(omega)
    for w, D in zip(omega, found, strict=True):
        whole = np.linalg.inv(1j * w * np.eye(len(linear.jacobian)) - linear.jacobian)
        expected = linear.inertia @ np.linalg.inv(whole[:n, n : 2 * n])
        np.testing.assert_allclose(D, expected, rtol=1e-10)
        np.testing.assert_allclose(linear.dynamic_stiffness(w), D, rtol=1e-12)


def test_modes_from_the_stiffness_alone() -> None:
    """Without a memory both ways are exact: the same periods, decays and shapes."""
    linear = random_linear(2, 4, 0)
    linear.jacobian[4:, 4:] = -0.2 * np.linalg.inv(linear.inertia)
    others = modes_of_stiffness(linear.dynamic_stiffness, linear)
    for one, other in zip(natural_modes(linear), others, strict=True):
        assert one.coordinate == other.coordinate
        assert one.natural_period == pytest.approx(other.natural_period, rel=1e-9)
        assert one.eigenvalue == pytest.approx(other.eigenvalue, rel=1e-8)


@pytest.mark.parametrize("count", [4, 5, 8])
def test_equal_bodies_in_a_row_share_out_their_coordinates(count: int) -> None:
    """Many modes are as much of one body as of another, and still each has a name of its own."""
    inertia = np.diag([9e6, 25e6, 25e6])
    bodies = [hs.Body(f"b{i}", 1e6, inertia, location=(40.0 * i, 0.0)) for i in range(count)]
    stiffness = np.diag([1e5, 1e5, 1e5, 9e5, 25e5, 25e5])
    forces: dict[str, hs.LinearMooring | hs.Spring] = {}
    forces |= {f"m{i}": hs.LinearMooring(f"b{i}", stiffness) for i in range(count)}
    pull = np.array([0.0, 100.0]), np.array([0.0, 1e7])
    for i in range(count - 1):
        joint = hs.Spring(f"b{i}", (5.0, 0, 0), (-5.0, 0, 0), 29.0, curve=hs.TensionCurve(*pull))
        forces[f"s{i}"] = replace(joint, anchor_body=f"b{i + 1}")
    modes = modes_of(*bodies, **forces)
    assert sorted(mode.coordinate for mode in modes) == list(range(6 * count))
    assert all(mode.kind == ModeKind.OSCILLATING for mode in modes)


def test_motions_without_inertia_are_told_in_words() -> None:
    """A stiffness that is the same at all frequencies leaves no mass."""
    linear = random_linear(0, 2, 0)
    K = np.diag([2.0, 3.0]).astype(complex)
    with pytest.raises(InputError, match="natural modes: there is a motion without inertia"):
        modes_of_stiffness(lambda w: np.broadcast_to(K, (w.size, 2, 2)), linear)
