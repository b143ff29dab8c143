"""Difference-frequency QTF by pressure integration: hydrostatics of a turned box, closed forms of
a vertical cylinder, WAMIT's hemisphere, limits of short and long waves, symmetries."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import h1vp, hankel1, jv, jvp
from validation_data import unpacked

pytest.importorskip("capytaine", reason="capytaine is not installed (pip install .[bem])")

from hydrosim.database import load
from hydrosim.database.build import barge as hull
from hydrosim.database.build import bem, drift, near_field, second_order
from hydrosim.database.build.assemble import Floating
from hydrosim.database.build.drift import Water
from hydrosim.errors import InputError
from hydrosim.report.evidence import Feature, Kind

pytestmark = pytest.mark.bem
RHO, G = 1025.0, 9.81
WATER = Water(RHO, G)
SIDES, CENTRE = (60.0, 20.0, 6.0), np.array([0.0, 0.0, 1.5])  # a box and its centre of gravity


def box(length: float, beam: float, draught: float, centre, fine: int = 1):
    """A box, amidships at x = 0."""
    third = length / 3
    shape = hull.Barge(length, beam, draught, beam, third, third, draught, third / 2)
    along = tuple(fine * n for n in (4, 4, 8, 4, 4))
    down, across, lid = 4 * fine, 4 * fine, (3 * fine, 4 * fine, 3 * fine)
    mesh = hull.Resolution(along, across, down, 2 * across, down, lid, 2 * fine)
    shift = [-length / 2, 0.0, 0.0]
    half, inside = hull.half_hull(shape, mesh) + shift, hull.half_lid(shape, mesh) + shift
    return bem.Hull(half, inside, True, (tuple(centre),))


def shell(profile: np.ndarray, around: int, lid: int):
    """Body of revolution about z, ``profile`` (n, 2) of (r, z) from the bottom's middle to the
    waterline; moments about the origin."""
    turn = np.linspace(0, np.pi, around + 1)

    def swept(line):
        r, z = line[:, 0, None], line[:, 1, None]
        grid = np.stack(np.broadcast_arrays(r * np.cos(turn), r * np.sin(turn), z), axis=-1)
        rings = [grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1]]
        return np.stack(rings, axis=2).reshape(-1, 4, 3)

    disc = np.stack([np.linspace(0, profile[-1, 0], lid + 1), np.zeros(lid + 1)], axis=-1)
    return bem.Hull(swept(profile), swept(disc), True, ((0.0, 0.0, 0.0),))


def hemisphere(down: int, around: int):
    """Radius 1 m, a little more for the panels to hold the true volume."""
    angle = np.linspace(0, np.pi / 2, down + 1)
    return shell(np.stack([np.sin(angle), -np.cos(angle)], axis=-1), around, max(2, down // 2))


def floating(mass: float, area: float, gyration: float = 0.4) -> Floating:
    """A hemisphere of radius 1 m round its centre of gravity, where all pressure points to."""
    inertia = mass * np.diag([1, 1, 1, *[gyration**2] * 3])
    stiffness = RHO * G * np.diag([0, 0, area, 0, 0, 0])
    return Floating(np.zeros(3), np.zeros(3), mass / RHO, inertia, stiffness)


def flows(wet, afloat, frequencies, headings=(0.0,)):
    """The wetted surface and the flow round it."""
    heading = np.array(headings)
    found = [near_field.first_order(wet.body, afloat, WATER, w, heading) for w in frequencies]
    return near_field.wetted_surface(near_field.whole(wet.body)), found


def mean(transfer):
    return np.real(np.einsum("iic->ic", transfer))


@pytest.fixture
def water():
    """The water alone."""
    return Water(RHO, G)


@pytest.fixture(scope="module")
def waves():
    """A floating hemisphere in three pairs of close waves to two headings."""
    frequencies = np.array([2.4, 2.45, 2.475, 2.525, 2.55, 2.6])
    afloat = floating(RHO * 2 / 3 * np.pi, np.pi)
    return flows(hemisphere(6, 8), afloat, frequencies, np.radians([0.0, 40.0]))


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


@pytest.fixture(scope="module")
def wetted_box():
    return near_field.wetted_surface(near_field.whole(box(*SIDES, CENTRE, fine=2).body))


@pytest.mark.parametrize("motion", ["heave", "roll", "pitch and heave", "all"])
def test_a_turned_box_in_still_water(water, wetted_box, motion):
    """Terms of the waterline, of rotation and of its second order, against exact hydrostatics:
    the second difference of the load on a wall-sided box. The error is that of the midpoint
    rule along the waterline."""
    moved = {"heave": [2], "roll": [3], "pitch and heave": [2, 4], "all": [0, 1, 2, 3, 4, 5]}
    xi = np.zeros(6)
    xi[moved[motion]] = np.array([0.3, -0.5, 0.7, 1.1, -0.8, 0.6])[moved[motion]]
    wetted, step = wetted_box, 1e-3
    loads = [turned_load(SIDES, CENTRE, s * step * xi) for s in (-1, 0, 1)]
    first, second = (loads[2] - loads[0]) / (2 * step), (loads[2] - 2 * loads[1] + loads[0]) / 2
    rise = -near_field.displacement(xi[None], wetted.edge_arm)[..., 2]
    still = np.zeros((1, *wetted.arm.shape))
    flow = near_field.Flow(0.0, xi[None] + 0j, first[None] + 0j, still + 0j, rise + 0j)
    load = (
        2 * mean(second_order.quadratic(water, wetted, [flow], 0, 0))[0]
    )  # the mean is half the square
    scale = RHO * G * 1200.0 * np.array([1, 1, 1, 20, 20, 20])
    np.testing.assert_allclose(load / scale, second / step**2 / scale, atol=1e-2)


# ------------------------------------------------------------------ closed forms


def cylinder_qtf(radius: float, waves, headings) -> np.ndarray:
    """Surge and sway (2,) on a fixed vertical cylinder by two waves (MacCamy and Fuchs 1954):

    rho g / 4 int (-eta_1 eta_2* + g / (w_1 w_2) (eta_1' eta_2*' / R^2 + k_1 k_2 eta_1 eta_2*)
    / (k_1 + k_2)) n R dt, the depth having been integrated by hand.
    """
    t, n = np.arange(360) * 2 * np.pi / 360, np.arange(-20, 21)
    eta, slope = [], []
    for w, heading in zip(waves, headings, strict=True):
        ka = w**2 / G * radius
        radial = jv(n, ka) - jvp(n, ka) / h1vp(n, ka) * hankel1(n, ka)
        parts = 1j**n * radial * np.exp(1j * (t - heading)[:, None] * n)
        eta.append(np.conj(parts.sum(axis=1)))
        slope.append(np.conj((1j * n * parts).sum(axis=1)))
    k = np.square(waves) / G
    level = eta[0] * np.conj(eta[1])
    speed = slope[0] * np.conj(slope[1]) / radius**2 + k[0] * k[1] * level
    load = -level + G / (waves[0] * waves[1] * k.sum()) * speed
    return RHO * G / 4 * radius * t[1] * np.array([load @ np.cos(t), load @ np.sin(t)])


def test_fixed_cylinder(water, validated):
    """30 m of it are there, which is deep for these waves, in panels of 2.2 m: within 3 per cent of
    the largest, in magnitude and phase, of waves to the same and to two headings."""
    radius, frequencies, to = 10.0, (0.9, 1.15), np.radians([0.0, 50.0])
    depth = 30 * np.linspace(1, 0, 13) ** 1.5
    bottom = np.stack([np.linspace(0, radius, 5)[:-1], np.full(4, -30.0)], axis=-1)
    side = np.stack([np.full(13, radius), -depth], axis=-1)
    body = shell(np.concatenate([bottom, side]), 14, 4)
    wetted, found = flows(body, None, frequencies, to)
    for headings in ((0, 0), (0, 1)):
        directions = to[list(headings)]
        exact = np.array(
            [[cylinder_qtf(radius, (v, w), directions) for w in frequencies] for v in frequencies]
        )
        computed = second_order.quadratic(water, wetted, found, *headings)[..., :2]
        error = np.abs(computed - exact).max() / np.abs(exact).max()
        claim = "QTF of a fixed cylinder in crossing waves, of the largest"
        validated(Kind.CLOSED_FORM, claim, "its known flow", error, 0.03, Feature.RECIPES)


def test_beam_seas_on_a_wall(water):
    """Short waves push a held, wall-sided barge with rho g / 2 per length; its 100 m are 4 wave
    lengths, and the far field of this mesh has 0.6 per cent more. The near field has 6 per cent
    more, 2 with four times as many panels."""
    body = box(100.0, 20.0, 8.0, (0.0, 0.0, 0.0))
    load = mean(second_order.quadratic(water, *flows(body, None, [1.6], [np.pi / 2]), 0, 0))[0]
    assert load[1] == pytest.approx(RHO * G / 2 * 100, rel=0.07)
    assert abs(load[0]) < 0.001 * load[1]


def test_long_waves_carry_the_body(water):
    """It moves as the water would without it, at a speed w: the square of the speed is worth
    -rho w^2 A / 2 in heave, A the waterplane, and the displacement times the gradient of the
    pressure twice as much upwards. Nothing is left in surge. The next order is k R = 0.004."""
    wetted, found = flows(hemisphere(6, 8), floating(RHO * 2 / 3 * np.pi, np.pi), [0.2])
    load = mean(second_order.quadratic(water, wetted, found, 0, 0))[0]
    lift = RHO * 0.2**2 * -wetted.area[:, 2].sum() / 2
    assert load[2] == pytest.approx(lift, rel=0.03)
    assert abs(load[0]) < 1e-3 * lift


# ------------------------------------------------------------------ against the far field


def far_field(body, afloat, w):
    """Surge drift of the same mesh by Maruo's formula."""
    s = bem.solve(body, WATER, w, np.zeros(1))
    impedance = afloat.stiffness - w**2 * (afloat.inertia + s.added_mass) + 1j * w * s.damping
    motion = np.linalg.solve(impedance, s.excitation.T).T
    kochin = s.kochin_diffraction + np.conj(motion) @ s.kochin_radiation
    return drift.mean_drift(kochin, w, np.zeros(1), WATER).force[0, 0]


def test_near_field_comes_to_the_far_field(water, figure):
    """Both are the same for the exact solution; the near field's error falls with the panels."""
    afloat, frequencies = floating(RHO * 2 / 3 * np.pi, np.pi), [2.5, 3.5, 4.5]
    errors = []
    for mesh in ((4, 6), (10, 14)):
        body = hemisphere(*mesh)
        near = mean(second_order.quadratic(water, *flows(body, afloat, frequencies), 0, 0))[:, 0]
        far = [far_field(body, afloat, w) for w in frequencies]
        errors.append(np.abs(near / far - 1).max())
    figure("near field against far field, 48 panels", errors[0])
    figure("near field against far field, 280 panels", errors[1])
    assert errors[1] < 0.06
    assert errors[1] < 0.7 * errors[0]


def egg(down: int, around: int) -> bem.Hull:
    """A hemisphere four times as long before its middle and twice as long behind it, with its
    centre of gravity 1 m before the middle."""
    round_hull = hemisphere(down, around)

    def lengthened(panels):
        stretch = np.where(panels[..., :1] > 0, 4.0, 2.0)
        return np.concatenate([panels[..., :1] * stretch, panels[..., 1:]], axis=-1)

    panels, lid = lengthened(round_hull.panels), lengthened(round_hull.lid)
    return replace(round_hull, panels=panels, lid=lid, centres=((1.0, 0.0, 0.0),))


def test_yaw_drift_by_pressures_and_by_momentum(water, figure):
    """Both are about the centre of gravity of a held hull that is not the same fore and aft. About
    the middle, sway drift would turn the moment round at 45 deg. The error of the
    pressures falls with the size of the panels."""
    to, frequencies = np.radians([45.0, 90.0, 135.0]), (2.0, 2.5, 3.0)
    errors = []
    for panels in ((6, 10), (10, 16)):
        body = egg(*panels)
        wetted, found = flows(body, None, frequencies, to)
        near = np.array([second_order.mean_load(water, wetted, flow)[:, 5] for flow in found])
        waves = [bem.solve(body, WATER, w, to).kochin_diffraction for w in frequencies]
        pairs = list(zip(waves, frequencies, strict=True))
        far = np.array(
            [drift.mean_drift(h, w, to, water, (1.0, 0.0)).force[:, 5] for h, w in pairs]
        )
        errors.append(np.abs(near - far).max() / np.abs(far).max())
    about_middle = drift.mean_drift(*pairs[-1], to, water).force[0, 5]
    assert far[-1, 0] * about_middle < 0
    assert errors[1] < 0.6 * errors[0]
    figure("yaw drift by pressures against the far field, of the largest", errors[1])
    assert errors[1] < 0.1


def test_hemisphere_against_wamit(water, validated):
    """Its surge drift by momentum, with its mass and waterplane; from where waves are scattered to
    its first irregular frequency (k R = 2.55), but for the resonance in heave, whose height its
    coarser sphere changes."""
    text = unpacked("hemisphere/hemisphere.8").read_text()
    lines = [line.split() for line in text.splitlines()[1:]]
    table = {2 * np.pi / float(c[0]): float(c[6]) for c in lines if c[3] == "1"}
    known = np.array(sorted(table))
    frequencies = [3.5, 3.75, 4.0, 4.25, 4.5]
    given = np.interp(frequencies, known, [table[w] for w in known])
    afloat = floating(RHO * 2.07293, 3.128583)
    wetted, found = flows(hemisphere(10, 14), afloat, frequencies)
    load = mean(second_order.quadratic(water, wetted, found, 0, 0))[:, 0] / (RHO * G)
    error = np.abs(load / given - 1).max()
    claim = "mean drift of a hemisphere by pressures"
    validated(Kind.PROGRAM, claim, "WAMIT, by momentum", error, 0.06, Feature.RECIPES)


# ------------------------------------------------------------------ pairs of waves


def test_near_the_diagonal(water, waves):
    """T(w + d/2, w - d/2) is the mean drift at w (Newman 1974) but for an imaginary part in d and a
    real one in d squared."""
    wetted, found = waves
    T = second_order.quadratic(water, wetted, found, 0, 0)[..., 0]
    d = {0.2: T[5, 0], 0.1: T[4, 1], 0.05: T[3, 2]}
    assert d[0.2].imag / d[0.1].imag == pytest.approx(2, rel=0.05)
    assert d[0.1].imag / d[0.05].imag == pytest.approx(2, rel=0.02)
    assert (d[0.2] - d[0.1]).real / (d[0.1] - d[0.05]).real == pytest.approx(4, rel=0.1)
    mean_drift = (T[3, 3] + T[2, 2]).real / 2
    assert d[0.05].real == pytest.approx(mean_drift, rel=0.01)


def test_hermitian_with_the_far_field_on_its_diagonal(made_up, waves):
    """Also where the far field is any number, so that no ratio fits."""
    wetted, found = waves
    headings = np.radians([0.0, 40.0])
    db = made_up(frequency=np.linspace(0.1, 6.0, 4), heading=np.radians([0.0, 40.0, 180.0]))
    pairs, T = second_order.difference_qtf(db, wetted, found, headings, crossing=True)
    np.testing.assert_allclose(pairs, [[a, b] for a in headings for b in headings])
    T = T.reshape(2, 2, *T.shape[1:])
    other = np.conj(T.transpose(1, 0, 3, 2, 4))
    assert np.abs(T - other).max() <= 1e-12 * np.abs(T).max()
    single = second_order.difference_qtf(db, wetted, found, headings)
    np.testing.assert_array_equal(single[1], T[[0, 1], [0, 1]])
    for heading in (0, 1):
        for dof in (0, 1, 5):
            expected = np.interp(
                [f.frequency for f in found], db.frequency, db.mean_drift[:, heading, dof]
            )
            if heading == 0 and dof:
                expected = 0.0
            np.testing.assert_allclose(mean(T[heading, heading])[:, dof], expected, atol=1e-12)


def test_second_order_potential_of_one_pair(made_up):
    """-(w_1 / 2) (dw / g) X(w'), w' being a frequency of the database."""
    w_2, w_1 = 0.5, 0.9
    db = made_up(frequency=np.array([0.2, 0.5, np.sqrt(w_1**2 - w_2**2), 1.0]), gravity=G)
    T = second_order.second_order_potential(db, np.array([w_2, w_1]), np.pi / 2, np.pi / 2)
    expected = -0.45 * 0.4 / G * db.excitation[2, 1]
    np.testing.assert_allclose(T[1, 0], expected)
    np.testing.assert_allclose(T[0, 1], np.conj(expected))
    assert not T[[0, 1], [0, 1]].any()


def test_second_order_potential_of_crossing_waves(made_up):
    """P exp(|K| z) obeys P_tt + g P_z = -d/dt |grad phi|^2 at z = 0, the gradients of both waves
    multiplied as vectors; X is read in the direction of k_1 - k_2, on the starboard side here."""
    w_2, w_1, to = 0.5, 0.9, np.array([0.0, np.pi / 2])
    k = np.array([[w_1**2, 0.0], [0.0, w_2**2]]) / G
    K = k[0] - k[1]
    size, aside = np.hypot(*K), -np.arctan2(K[1], K[0])
    db = made_up(
        frequency=np.array([0.2, 0.5, np.sqrt(G * size), 1.0]),
        heading=np.array([0.0, aside, np.pi]),
        gravity=G,
    )
    T = second_order.second_order_potential(db, np.array([w_2, w_1]), *to)[1, 0]
    v_1, v_2 = (
        1j * G / w * np.array([-1j * a, -1j * b, np.hypot(a, b)])
        for w, (a, b) in zip((w_1, w_2), k, strict=True)
    )
    dw = w_1 - w_2
    P = -1j * dw * (v_1 @ np.conj(v_2)) / 2 / (G * size - dw**2)
    X = db.excitation[2, 1] * [1, -1, 1, -1, 1, -1]
    np.testing.assert_allclose(T, P * dw / (1j * G) * X)


def test_a_diagonal_through_zero_leaves_its_row_alone():
    """Pairs beside a vanishing diagonal are as large as their neighbours; the ratio of two small
    numbers, here -3, is not theirs."""
    near, far = np.array([100.0, 1.0, -100.0]), np.array([90.0, -3.0, -90.0])
    both = [np.repeat(row[None, :, None], 2, axis=0) for row in (near, far)]
    transfer = np.full((3, 3, 1), 50.0 + 20.0j)
    transfer[[0, 1, 2], [0, 1, 2], 0] = near
    result = second_order.correct_to_diagonals(transfer, *both)
    np.testing.assert_allclose(mean(result)[:, 0], far)
    assert abs(result[0, 1, 0] / transfer[0, 1, 0] - np.sqrt(0.9)) < 0.05


def test_the_barge():
    """The database that is shipped: Hermitian, its mean drift on the diagonal."""
    db = load(Path(__file__).parents[2] / "hydro_db" / "h851.nc")
    T = db.qtf_difference
    assert np.abs(T - np.conj(np.swapaxes(T, 1, 2))).max() <= 1e-12 * np.abs(T).max()
    rows = [int(np.argmin(np.abs(db.frequency - w))) for w in db.qtf_frequency]
    np.testing.assert_allclose(db.frequency[rows], db.qtf_frequency)
    for own, (heading, _) in zip(T, db.qtf_heading, strict=True):
        column = int(np.argmin(np.abs(db.heading - heading)))
        for dof in (0, 1, 5):
            expected = db.mean_drift[rows, column, dof]
            np.testing.assert_allclose(mean(own)[:, dof], expected, rtol=1e-12, atol=1e-6)


def test_what_the_database_must_have(made_up, waves):
    wetted, found = waves
    headings = np.radians([0.0, 40.0])
    with pytest.raises(InputError, match="expected it for all headings of the QTF"):
        second_order.difference_qtf(
            made_up(frequency=np.linspace(0.1, 6.0, 4)), wetted, found, headings
        )
    with pytest.raises(InputError, match=r"covers 0\.2 to 1\.4 rad/s"):
        second_order.difference_qtf(made_up(), wetted, found, headings)
