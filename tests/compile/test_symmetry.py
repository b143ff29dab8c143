"""Scenes that are their own mirror image: what is skipped changes nothing, what is not symmetric is
not skipped.

Where a scene is symmetric, the full computation stays in the plane to rounding and does the same
sums, with zeros added. So the two agree to rounding, `ROUNDING` of a coordinate's range: what
contacts make of 1e-16 in minutes.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import product
from typing import Any

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_array_equal
from reading import rows, texts
from scenes import (
    CASES,
    SEA,
    central_force,
    hull,
    in_contact,
    in_waves,
    moving,
    on_floor,
    scene_of,
    steady,
    straight_curve,
    table,
    with_body,
)
from scenes import scene as dry
from scipy.linalg import block_diag

import hydrosim as hs
from hydrosim.compile.symmetry import joints_without_image
from hydrosim.database import HydroDatabase
from hydrosim.dofs import DOFS, LATERAL, SYMMETRY_RTOL
from hydrosim.elements import Harmonic
from hydrosim.report.evidence import Feature, Kind
from hydrosim.report.sentences.check import check_document
from hydrosim.results.dataset import write_run
from hydrosim.scene import (
    ConstantRadiation,
    ConvolutionRadiation,
    ForceElement,
    GivenComponents,
    Method,
    Place,
    SecondOrder,
    Symmetry,
)

ROUNDING = 1e-10
IN_PLANE = [dof for dof in DOFS if dof not in LATERAL]
ALONG = np.radians([0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0])


def with_solver(scene: hs.Scene, **changes: Any) -> hs.Scene:
    return replace(scene, solver=replace(scene.solver, **changes))


def full(scene: hs.Scene) -> hs.Scene:
    """With sway, roll and yaw; waves meet bodies at rest: by default they would follow a yaw."""
    return with_solver(met_at_rest(scene), symmetry=Symmetry.IGNORE)


def met_at_rest(scene: hs.Scene) -> hs.Scene:
    """The scene with waves that meet its bodies at rest, whatever their default."""
    loads = {b.name: replace(b.wave_forces, headings=Place.MEAN) for b in scene.bodies}
    bodies = tuple(replace(b, wave_forces=loads[b.name]) for b in scene.bodies)
    return replace(scene, bodies=bodies)


def reduced(scene: hs.Scene) -> bool:
    return hs.compile_scene(scene, in_plane=True).whole is not None


def reasons(scene: hs.Scene) -> str:
    """Why a scene is not reduced."""
    found = hs.compile_scene(scene, in_plane=True)
    assert found.whole is None
    assert found.notes.zero == ()
    return found.notes.symmetry


def difference(found: xr.Dataset, expected: xr.Dataset) -> float:
    """Largest difference in the plane over its range; out of it ``found`` has zeros."""
    assert not found.position.sel(dof=list(LATERAL)).any()
    assert not found.velocity.sel(dof=list(LATERAL)).any()
    here, there = (run.position.sel(dof=IN_PLANE) for run in (found, expected))
    span = there.max("time") - there.min("time")
    assert (span > 0.0).all()
    return float((np.abs(here - there).max("time") / span).max())


def agrees(scene: hs.Scene, figure, bound: float = ROUNDING) -> tuple[xr.Dataset, xr.Dataset]:
    """The runs of a scene, reduced and in full."""
    found, expected = hs.simulate(scene), hs.simulate(full(scene))
    assert found.attrs["solver_symmetry"].startswith("in the plane y = ")
    assert "as solver.symmetry asks" in expected.attrs["solver_symmetry"]
    assert "sway, roll, yaw zero by symmetry" in found.attrs["skipped"]
    lateral = np.abs(expected.position.sel(dof=list(LATERAL))).max()
    figure("difference", difference(found, expected))
    figure("out of the plane, in full", float(lateral))
    assert difference(found, expected) <= bound
    assert lateral <= 1e-9
    for name in (str(name) for name in expected if str(name).startswith("force_")):
        size = float(np.abs(expected[name]).max())
        assert np.abs(found[name] - expected[name]).max() <= 1e3 * bound * size, name
    return found, expected


def moored(**changes: Any) -> hs.Scene:
    """The free-floating barge, which is moored, in waves from ahead for 200 s, stepped."""
    sea = hs.WaveTrain(SEA, heading=np.pi, ramp=20.0)
    scene = in_waves(scene_of("free_floating"), sea)
    solver = hs.Solver(step=0.1, linear=hs.scene.LinearScenes.STEP)
    return with_body(replace(scene, duration=200.0, solver=solver), **changes)


class TestAgreement:
    def test_the_base_case(self, base_run: xr.Dataset, validated) -> None:
        """Through contact, stick and slip; without the states of sway, roll and yaw."""
        expected = hs.simulate(full(scene_of("base")))
        error = difference(base_run, expected)
        claim, against = "base case in its plane, of its range", "six degrees of freedom"
        validated(Kind.SELF, claim, against, error, ROUNDING, Feature.PLANE)
        assert base_run.attrs["solver_events"] == expected.attrs["solver_events"] > 1000
        assert_array_equal(base_run.fender_mode, expected.fender_mode)
        memory = [str(name) for name in expected.state.values if "of sway, roll, yaw" in str(name)]
        assert len(memory) > 20
        assert base_run.sizes["state"] == expected.sizes["state"] - len(memory) - 2 * 3
        assert list(base_run.dof.values) == list(DOFS)

    @pytest.mark.parametrize("second", [SecondOrder.QTF, SecondOrder.NEWMAN])
    def test_waves_from_ahead_with_loads_of_second_order(self, second, figure):
        agrees(moored(wave_forces=hs.WaveForces(second_order=second)), figure)

    def test_waves_that_follow_the_body(self, figure) -> None:
        parts = np.array([[0.5, 0.7, 0.9], [0.5, 0.7, 0.3], [0.0, 1.0, 2.0], [0.0, np.pi, 0.0]])
        lines = GivenComponents(*parts)
        wanted = hs.WaveForces(position=Place.INSTANTANEOUS, headings=Place.INSTANTANEOUS)
        agrees(in_waves(moored(wave_forces=wanted), hs.WaveTrain(lines, ramp=20.0)), figure)

    @pytest.mark.parametrize("method", [Method.RK4, Method.DOPRI5])
    def test_convolution_through_contact(self, method: Method, figure) -> None:
        """Lateral functions are not summed. Zeros have no error: adaptive steps are the same."""
        memory = ConvolutionRadiation(length=40.0)
        scene = with_solver(with_body(in_contact(40.0), radiation=memory), method=method)
        found, expected = agrees(scene, figure)
        assert set(found.memory_dof.values) == {f"{dof} of barge" for dof in IN_PLANE}
        assert found.attrs["solver_events"] == expected.attrs["solver_events"] > 10

    def test_constant_radiation(self, figure) -> None:
        agrees(moored(radiation=ConstantRadiation(8.0)), figure)

    def test_lines_and_fenders_in_pairs_off_the_earths_origin(self, figure) -> None:
        """Mirror images are so to rounding there; fenders are two elements on oblique walls."""
        y = 37.3
        scene = moored(location=(0.0, y))
        lines, curve = {}, np.array([[0.0, 50.0], [0.0, 5e7]])
        for x, side in product((-110.0, 110.0), (-1.0, 1.0)):
            ends = (x, side * 25.0, 5.0), (2.5 * x, y + side * 120.0, -3.0)
            lines[f"line_{x}_{side}"] = hs.Spring(
                "barge", *ends, 190.0, curve=hs.TensionCurve(*curve), damping=10000.0
            )
        curve = straight_curve(2e7)
        law = hs.StickSlip(0.4, 0.3, 5e6, 1e6, 1e5)
        walls = {}
        for side in (-1.0, 1.0):
            points = np.array([[60.0, side * 31.5, 0.0], [-60.0, side * 31.5, 0.0]])
            wall = hs.Plane((side, y + side * 31.51, -4.9), (0.0, -side, -0.2))
            walls[f"wall_{side}"] = hs.Fender("barge", points, wall, curve, law)
        found, _ = agrees(replace(scene, forces={**lines, **walls}), figure)
        assert found.attrs["solver_events"] > 0
        assert float(found.spring_tension.max()) > 0.0
        assert float(np.abs(found.fender_friction.sel(axis="y")).max()) > 0.0

    def test_streams_and_drag_along_the_plane(self, figure) -> None:
        """Coefficients of a hull that is symmetric, two loads beside the plane, all dampings."""
        surge, sway, yaw = 2e4 * np.cos(ALONG), 1e5 * np.sin(ALONG), 1e6 * np.sin(2 * ALONG)
        coefficients = (ALONG, surge, sway, yaw)
        damping = np.diag([1e5, 2e5, 3e5, 1e8, 2e8, 3e8])
        damping[0, 4] = damping[4, 0] = 1e6
        water = {
            "current": hs.CurrentLoad("barge", (0.0, 0.0, -3.0), *coefficients),
            "port": hs.WindLoad("barge", (30.0, 12.0, 15.0), *coefficients),
            "starboard": hs.WindLoad("barge", (30.0, -12.0, 15.0), *coefficients),
            "drag": hs.QuadraticDamping("barge", damping),
            "skin": hs.LinearDamping("barge", 1e-2 * damping, relative_to_current=True),
        }
        scene = moored()
        streams = {"current": hs.Stream(1.0, np.pi), "wind": hs.Stream(20.0, 0.0)}
        environment = replace(scene.environment, **streams)
        agrees(replace(scene, environment=environment, forces={**scene.forces, **water}), figure)

    @pytest.mark.slow
    def test_two_bodies_in_line(self, figure) -> None:
        """One database with all couplings, a hawser, and a fender between them."""
        found, _ = agrees(in_line(), figure)
        assert found.sizes["body"] == 2
        assert {0, 1, 2} == set(np.unique(found.fender_mode))
        assert float(found.spring_tension.max()) > 0.0

    def test_a_scene_that_is_linear_in_its_plane_is_not_stepped(self, figure) -> None:
        """With one rotation left, exact kinematics are linear; the full scene is stepped, with an
        error that falls with the fourth power of the step: the reduced one is its limit."""
        scene = with_solver(moored(), linear=hs.scene.LinearScenes.EXACT)
        found = hs.simulate(scene)
        assert found.attrs["solver_linear"] == "propagated exactly: linear"
        coarse, fine = (
            difference(found, hs.simulate(full(with_solver(scene, step=step))))
            for step in (0.125, 0.0625)  # stable up to 0.24 s
        )
        figure("difference at 0.0625 s", fine)
        assert fine < 1e-5
        assert coarse / fine == pytest.approx(16.0, rel=0.3)

    def test_dry_bodies(self, figure) -> None:
        """A block that falls on its corners and is pushed, by forces in mirrored pairs. Each knock
        enlarges roundings; the bound is what they make of a start from the next numbers."""
        inertia = np.array([[3.0, 0.0, 0.2], [0.0, 4.0, 0.0], [0.2, 0.0, 6.0]])
        corners = [(x, y, -1.0) for x in (-1.0, 1.0) for y in (-0.5, 0.5)]
        ground = on_floor(1e6, hs.StickSlip(0.5, 0.4, 2e5, 1e4, 1e3), corners)
        size, mirror = np.array([300.0, 40.0, 0.0, 3.0, 20.0, 2.0]), [1, -1, 1, -1, 1, -1]
        push, pull = (table([0.0, 0.5, 1.0], [0.0 * f, f, -f]) for f in (size, mirror * size))
        elements: Mapping[str, ForceElement] = {
            "floor": replace(ground, plane=hs.Plane((0.0, 0.0, -1.0), (0.0, 0.0, 1.0))),
            "weight": steady(heave=-9.81e2),
            "left": hs.AppliedForce("block", (0.0, 0.5, -0.8), push),
            "right": hs.AppliedForce("block", (0.0, -0.5, -0.8), pull),
        }
        heaves = 0.02 + np.spacing(0.02) * np.array([0, -2, -1, 1, 2])
        body = hs.Body("block", 100.0, 100.0 * inertia)
        bodies = [replace(body, position=moving(heave=heave)) for heave in heaves]
        scene, *others = (dry(body, elements, 2.0, 0.01, step=5e-4) for body in bodies)
        middle = hs.simulate(scene)
        rounding = max(difference(hs.simulate(other), middle) for other in others)
        figure("difference of a rounding at the start", rounding)
        assert rounding < 1e-6
        found, _ = agrees(scene, figure, bound=rounding)
        assert {0, 1, 2} == set(np.unique(found.fender_mode))


@lru_cache
def pair() -> HydroDatabase:
    """Two hulls in line, 300 m apart, that feel a fifth of what each feels of itself."""
    one, shares, gap = hull(), np.array([[1.0, 0.2], [0.2, 1.0]]), 300.0
    k = one.frequency[:, None, None] ** 2 / one.gravity
    late = np.exp(1j * k * gap * np.cos(one.heading)[:, None])
    apart = np.array([[0.0, 0.0, 0.0], [-gap, 0.0, 0.0]])
    assert one.mean_drift is not None
    return replace(
        one,
        source="two barges in line",
        **{
            name: np.kron(shares, getattr(one, name))
            for name in ("added_mass", "radiation_damping")
        },
        **dict.fromkeys(("added_mass_zero", "added_mass_infinite", "froude_krylov")),
        **dict.fromkeys(("mean_drift_held", "inertia_matrix", "drift_imbalance")),
        **dict.fromkeys(("qtf_frequency", "qtf_heading", "qtf_difference")),
        hydrostatic_stiffness=block_diag(*2 * [one.hydrostatic_stiffness]),
        excitation=np.concatenate([one.excitation, late * one.excitation], axis=-1),
        mean_drift=np.concatenate([one.mean_drift, one.mean_drift], axis=-1),
        volume=np.tile(one.volume, 2),
        **{
            name: np.tile(getattr(one, name), (2, 1)) + apart
            for name in ("reference_point", "centre_of_gravity", "centre_of_buoyancy")
        },
    )


def in_line() -> hs.Scene:
    base = moored(radiation=ConstantRadiation(8.0))
    (barge,) = base.bodies
    centre, second = barge.centre_of_gravity, hs.WaveForces(second_order=SecondOrder.NEWMAN)
    front = replace(barge, name="front", hydrodynamics=pair(), wave_forces=second)
    x = float(pair().reference_point[1, 0])
    rear = replace(front, name="rear", database_body=2, centre_of_gravity=(x, *centre[1:]))
    mooring = base.forces["mooring"]
    stretch, tension = np.array([[0.0, 10.0], [0.0, 2e7]])
    points = np.array([[169.8, 10.0, 5.0], [169.8, -10.0, 5.0]])
    stern = hs.Plane((-130.0, 0.0, 0.0), (-1.0, 0.0, 0.0), "front")
    law = hs.StickSlip(0.4, 0.3, 5e6, 1e6, 1e5)
    ends = ("rear", (130.0, 0.0, 5.0), (-130.0, 0.0, 5.0))
    forces = {
        "mooring": replace(mooring, body="front"),
        "hawser": hs.Spring(
            *ends, 39.5, curve=hs.TensionCurve(stretch, tension), anchor_body="front"
        ),
        "bumper": hs.Fender("rear", points, stern, straight_curve(2e7), law),
    }
    return replace(base, bodies=(front, rear), forces=forces)


def shifted(name: str, index: tuple[int, ...], share: float) -> HydroDatabase:
    """The hull's database with a share of a coupling, or of a load, out of the plane."""
    values = getattr(hull(), name).copy()
    if values.shape[-2:] == (6, 6):
        i, j = index
        size = np.sqrt(values[..., i, i].max() * values[..., j, j].max())
        values[..., i, j] = values[..., j, i] = share * size
    else:
        (i,) = index
        forces = slice(3 * (i // 3), 3 * (i // 3) + 3)
        values[..., i] += share * np.abs(values[..., forces]).max()
    return replace(hull(), **{name: values})


def fenders(points: Any) -> hs.Scene:
    interface = scene_of("base").forces["interface"]
    return with_force(replace(interface, points=np.array(points, dtype=float)), "interface")


def with_force(element: ForceElement, name: str = "extra") -> hs.Scene:
    base = scene_of("base")
    return replace(base, forces={**base.forces, name: element})


def sea_of(**changes: Any) -> hs.Scene:
    return in_waves(scene_of("base"), replace(hs.WaveTrain(SEA), **changes))


def barge(**changes: Any) -> hs.Scene:
    return with_body(scene_of("base"), **changes)


def unfitted(**changes: Any) -> hs.Scene:
    """With radiation left out: another database would be fitted first."""
    return barge(radiation="none", **changes)


def loaded(name: str, index: tuple[int, ...], **changes: Any) -> hs.Scene:
    return unfitted(hydrodynamics=shifted(name, index, 1e-3), **changes)


def in_current(heading: float) -> hs.Scene:
    base = scene_of("base")
    environment = replace(base.environment, current=hs.Stream(1.0, heading))
    return replace(base, environment=environment)


def rigid(points: Any) -> ForceElement:
    return replace(fenders(points).forces["interface"], friction=hs.Coulomb(0.3, 0.2))


def matrix(i: int, j: int, value: float) -> np.ndarray:
    values = np.diag([1e6, 1e6, 0.0, 0.0, 0.0, 1e9])
    values[i, j] = values[j, i] = value
    return values


POINTS = [[20.0, 20.0, 7.5], [20.0, -20.0, 7.5], [-20.0, 20.0, 7.5], [-20.0, -20.0, 7.5]]
PRODUCTS = np.array([[5.0, 1e-3, 0.0], [1e-3, 50.0, 0.0], [0.0, 0.0, 50.0]])
WIND = hs.WindLoad("barge", (0.0, 3.0, 15.0), ALONG, np.cos(ALONG), np.sin(ALONG), 0.0 * ALONG)
LINE = hs.Spring(
    "barge",
    (0.0, 20.0, 5.0),
    (0.0, 90.0, 0.0),
    80.0,
    curve=hs.TensionCurve(*np.array([[0, 9], [0, 9]])),
)
PUSH = replace(steady("barge", surge=1.0), point=(0.0, 1.0, 0.0))
TUMBLING = hs.Body("b", 1.0, np.diag([3.0, 4.0, 6.0]), velocity=moving(pitch=1.0))
LEVEL = ("surge", "sway", "heave")
QTF = hs.WaveForces(second_order=SecondOrder.QTF)
CHANGED = "interface has no mirror image"
ADDED = "extra has no mirror image"
COUPLES = " couples surge, heave, pitch with sway, roll, yaw"
UNSTABLE = "sway, roll, yaw are not stable"
ASYMMETRIC: dict[str, tuple[Callable[[], hs.Scene], str]] = {
    "oblique waves": (lambda: sea_of(heading=np.radians(1e-3)), "waves to 0.001 deg"),
    "waves from abeam": (lambda: sea_of(heading=np.pi / 2), "waves to 90 deg"),
    "spread sea": (lambda: sea_of(spreading=10.0), "deg and others"),
    "one fender less": (lambda: fenders(POINTS[:3]), CHANGED),
    "two fenders on one side": (lambda: fenders([*POINTS, POINTS[0]]), CHANGED),
    "one fender off": (lambda: fenders([[20.0, 20.01, 7.5], *POINTS[1:]]), CHANGED),
    "line to one side": (lambda: with_force(LINE), ADDED),
    "push aside": (lambda: with_force(steady("barge", sway=1.0)), ADDED),
    "moment": (lambda: with_force(steady("barge", yaw=1.0)), ADDED),
    "push beside the plane": (lambda: with_force(PUSH), ADDED),
    "wind load beside the plane": (lambda: with_force(WIND), ADDED),
    "mooring": (
        lambda: with_force(hs.LinearMooring("barge", matrix(0, 5, 1e4))),
        "extra" + COUPLES,
    ),
    "drag": (
        lambda: with_force(hs.QuadraticDamping("barge", matrix(1, 0, 1e4))),
        "extra" + COUPLES,
    ),
    "centre off the plane": (lambda: unfitted(centre_of_gravity=(0, 0.1, -4.9)), "added mass of "),
    "products": (lambda: barge(inertia=1.6e9 * PRODUCTS), "the products of inertia of barge"),
    "sway at the start": (lambda: barge(velocity=moving(sway=0.1)), "rate of sway of barge at the"),
    "roll at the start": (lambda: barge(position=moving(roll=1e-3)), "roll of barge at the start"),
    "locked": (lambda: barge(position=moving(yaw=0.1), dofs=LEVEL), "are locked out of the plane"),
    "added mass": (lambda: loaded("added_mass", (0, 1)), COUPLES),
    "radiation damping": (lambda: loaded("radiation_damping", (2, 3)), COUPLES),
    "stiffness": (lambda: loaded("hydrostatic_stiffness", (2, 3)), "hydrostatic stiffness of "),
    "excitation": (lambda: loaded("excitation", (5,)), "first-order loads of "),
    "mean drift": (lambda: loaded("mean_drift", (1,)), "mean drift of "),
    "qtf": (
        lambda: loaded("qtf_difference", (3,), wave_forces=QTF),
        "difference-frequency loads of ",
    ),
    "current": (lambda: in_current(0.1), "current to 5.72958 deg"),
    "tumbling about the axis of the middle inertia": (lambda: dry(TUMBLING, {}, 1, 1), UNSTABLE),
    "capsizing": (lambda: unfitted(centre_of_gravity=(0.0, 0.0, 25.0)), UNSTABLE),
    "rigid": (lambda: with_force(rigid(POINTS[:1])), "extra has rigid friction beside the plane"),
}


@pytest.mark.parametrize("what", ASYMMETRIC)
def test_what_is_not_symmetric_is_not_reduced(what: str) -> None:
    make, word = ASYMMETRIC[what]
    text = reasons(make())
    assert text.startswith("in all degrees of freedom: ")
    assert word in text


def test_bodies_side_by_side_are_not_in_one_plane() -> None:
    base = moored()
    (one,) = base.bodies
    other = replace(one, name="other", location=(0.0, 100.0))
    assert "other is beside barge" in reasons(replace(base, bodies=(one, other)))


@pytest.mark.parametrize(
    ("turns", "axis", "symmetric"),
    [
        *((True, (0.0, 1.0, 0.0), True), (True, (1.0, 0.0, 0.0), False)),
        *((False, (1.0, 0.0, 2.0), True), (False, (0.0, 1.0, 0.0), False)),
    ],
)
def test_a_ratchet_goes_in_the_plane_or_turns_across_it(turns, axis, symmetric):
    """A mirror turns a rotation about its normal into itself, and one about a line in it back."""
    holds = {"turn": hs.TurningPawl()} if turns else {"slide": hs.SlidingPawl()}
    pawl = hs.Ratchet("block", axis=axis, **holds)
    told = [] if symmetric else ["pawl has no mirror image"]
    assert list(joints_without_image({"pawl": pawl}, 0.0)) == told


def test_joints_in_pairs_share_their_load() -> None:
    """In the plane the first of the rods would carry the load of both."""
    base = moored()
    rods = {
        name: hs.Rod(base.bodies[0].name, point=(0.0, y, 0.0), to_point=(40.0, y, 0.0))
        for name, y in (("port", 5.0), ("starboard", -5.0))
    }
    scene = replace(base, joints=rods)
    assert "port shares its load with its mirror image" in reasons(scene)
    force = hs.simulate(scene).joint_force
    port, starboard = (force.sel(joint=name, dof=["surge", "heave"]) for name in rods)
    assert np.abs(port).max() > 1.0
    assert np.allclose(port, starboard, rtol=1e-6, atol=1e-6 * float(np.abs(port).max()))
    middle = replace(rods["port"], point=(0.0, 0.0, 0.0), to_point=(40.0, 0.0, 0.0))
    assert reduced(replace(base, joints={"middle": middle}))


def test_the_key_of_a_case_file() -> None:
    path = CASES / "base.yaml"
    assert reduced(hs.load_case(path).scene())
    scene = hs.load_case(path, ["solver.symmetry=ignore"]).scene()
    assert reasons(scene) == "in all degrees of freedom: as solver.symmetry asks"


def test_all_reasons_are_told() -> None:
    text = reasons(in_waves(fenders(POINTS[:3]), hs.WaveTrain(SEA, heading=0.5)))
    assert "interface has no mirror image; waves to 28.6479 deg" in text


@pytest.mark.parametrize(
    ("name", "index"), [("added_mass", (0, 1)), ("excitation", (5,)), ("mean_drift", (1,))]
)
def test_the_last_digits_of_a_table_are_no_asymmetry(name: str, index: tuple[int, ...]) -> None:
    """WAMIT prints six digits; what leads aside is then less than the tolerance of the skip, and so
    is what the skip makes of the motions, but for the resonances it may meet."""
    databases = [shifted(name, index, share * SYMMETRY_RTOL) for share in (0.5, 2.0)]
    below, above = (unfitted(hydrodynamics=database) for database in databases)
    assert reduced(below)
    assert not reduced(above)


@pytest.mark.slow
def test_a_small_asymmetry_moves_the_full_scene_by_as_much(figure) -> None:
    """In the plane nothing is seen (the square of it), aside motions of about its size."""
    loads = shifted("excitation", (1,), 0.9 * SYMMETRY_RTOL)
    scene = moored(hydrodynamics=loads)
    found, expected = hs.simulate(scene), hs.simulate(full(scene))
    sway = float(np.abs(expected.position.sel(dof="sway")).max())
    figure("sway over surge", sway / float(np.abs(expected.position.sel(dof="surge")).max()))
    assert difference(found, expected) <= 1e-9
    assert 1e-8 < sway < 1e-5


def test_waves_that_load_nothing_may_come_from_anywhere() -> None:
    calm = hs.WaveForces(first_order=False)
    assert reduced(with_body(sea_of(heading=1.0), wave_forces=calm))
    assert not reduced(sea_of(heading=1.0))


def test_what_has_no_motions_aside_is_left_alone() -> None:
    for dofs in (("surge", "heave", "pitch"), ("sway", "roll", "yaw")):
        assert reasons(barge(dofs=dofs)) == ""


def test_a_point_of_rigid_friction_in_the_plane(figure) -> None:
    law = hs.Coulomb(0.3, 0.2)
    inertia = np.diag([3.0, 6.0, 4.0])
    elements = {
        "floor": on_floor(1e6, law, [(0.0, 0.0, 0.0)]),
        "weight": steady(heave=-9.81e2),
        "push": central_force(surge=Harmonic(500.0, 1.5)),
    }
    body = hs.Body("block", 100.0, 100.0 * inertia, velocity=moving(pitch=0.1))
    found, _ = agrees(dry(body, elements, 2.0, 0.01), figure)
    assert {1, 2} <= set(np.unique(found.fender_mode))


BREAK, END = 30.0, 60.0  # s


@pytest.fixture(scope="module")
def whole() -> xr.Dataset:
    return hs.simulate(full(in_contact(END)))


@pytest.mark.parametrize(
    ("first", "second", "memory"),
    [
        *((True, True, None), (True, False, None), (False, True, None)),
        *((True, False, 20.0), (False, True, 20.0)),
    ],
)
def test_a_restart_reduced_or_in_full_goes_on_as_one_in_full_from_0(
    whole: xr.Dataset, first: bool, second: bool, memory: float | None, figure, tmp_path
) -> None:
    """With radiation by states, and by a convolution of that ``memory`` [s]."""
    scene, path = in_contact(END), tmp_path / "before.nc"
    if memory is not None:
        scene = with_body(scene, radiation=ConvolutionRadiation(length=memory))
        whole = hs.simulate(full(scene))
    write_run(hs.simulate(replace(scene if first else full(scene), duration=BREAK)), path)
    rest = replace(scene, duration=END - BREAK, initial=hs.Start(path))
    after = hs.simulate(rest if second else full(rest))
    assert after.attrs["initial_run"] == str(path)
    assert after.attrs["solver_symmetry"].startswith("in the plane") == second
    expected = whole.sel(time=slice(BREAK - 1e-9, None))
    figure("difference", difference(after, expected))
    assert difference(after, expected) <= ROUNDING
    slipped = np.abs(after.fender_slip_distance - expected.fender_slip_distance)
    assert slipped.max() <= ROUNDING


class TestRestart:
    def test_in_other_waves(self) -> None:
        """From a reduced run into oblique waves, as from a full one, and from there on in full."""
        scene = met_at_rest(replace(in_contact(END), duration=BREAK))
        oblique = in_waves(scene, hs.WaveTrain(SEA, heading=0.5))
        before = [hs.simulate(scene), hs.simulate(full(scene))]
        turned = [hs.simulate(replace(oblique, initial=hs.Start(run))) for run in before]
        for run in turned:
            assert "waves to 28.6479 deg" in run.attrs["solver_symmetry"]
            assert float(np.abs(run.position.sel(dof="sway")).max()) > 1e-3
        np.testing.assert_allclose(turned[0].position, turned[1].position, rtol=0.0, atol=1e-9)
        back = replace(scene, initial=hs.Start(turned[0]))
        assert "sway of barge at the start and others" in reasons(back)

    @pytest.mark.parametrize(
        ("direction", "sides", "symmetric"),
        [(1, (1, 1), True), (1, (1, 0), False), (2, (1, -1), True), (2, (1, 1), False)],
    )
    def test_contacts_that_are_stretched_before(self, direction, sides, symmetric):
        """The first two points a pair: stretches along the plane are equal, across it opposite."""
        scene = replace(in_contact(BREAK), duration=BREAK)
        before = hs.simulate(full(scene))
        value = before.state_value.copy()
        for point, side in enumerate(sides, start=1):
            value.loc[{"state": f"stretch {direction} of interface {point}"}] += 1e-3 * side
        start = replace(scene, initial=hs.Start(before.assign(state_value=value)))
        if symmetric:
            assert reduced(start)
        else:
            assert "the contacts at the start" in reasons(start)

    def test_waves_that_are_left_from_before(self) -> None:
        """Bodies in the plane, with the memory of other waves."""
        before = hs.simulate(full(replace(scene_of("base"), duration=10.0)))
        value = before.state_value.copy()
        value.loc[{"state": "radiation 1 of sway, roll, yaw of barge"}] = 1.0
        start = replace(scene_of("base"), initial=hs.Start(before.assign(state_value=value)))
        assert "radiation 1 of sway, roll, yaw of barge at the start" in reasons(start)
        memory = ConvolutionRadiation(length=20.0)
        scene = with_body(replace(scene_of("base"), duration=10.0), radiation=memory)
        before = hs.simulate(full(scene))
        past = before.memory_past.copy()
        past.loc[{"memory_dof": "yaw of barge", "memory_row": "velocity"}] = 1e-6
        start = replace(scene, initial=hs.Start(before.assign(memory_past=past)))
        assert "the motions before the start" in reasons(start)

    def test_a_run_with_fewer_degrees_of_freedom_is_refused_as_ever(self) -> None:
        """Locked is not zero by symmetry."""
        locked = hs.simulate(replace(barge(dofs=("surge", "heave", "pitch")), duration=10.0))
        scene = replace(scene_of("base"), duration=10.0, initial=hs.Start(locked))
        with pytest.raises(hs.InputError, match="that run lacks sway of barge"):
            hs.simulate(scene)


class TestMany:
    @pytest.mark.slow
    def test_runs_are_as_alone_whatever_their_waves(self) -> None:
        """Seeds of one sea are reduced, and share their model; oblique waves are not."""
        seas = ((0.0, 1), (0.0, 2), (0.3, 1), (0.3, 2), (np.pi, 1), (0.0, 3))
        trains = [hs.WaveTrain(SEA, heading=heading, seed=seed) for heading, seed in seas]
        scenes = [replace(in_waves(in_contact(20.0), train)) for train in trains]
        runs = hs.simulate_many(scenes, workers=2)
        assert list(runs.status) == ["complete"] * 6
        for k, scene in enumerate(scenes):
            alone = hs.simulate(scene)
            assert_array_equal(runs.position.isel(run=k), alone.position)
            expected = "in all" if k in (2, 3) else "in the plane"
            assert alone.attrs["solver_symmetry"].startswith(expected)
        assert "solver_symmetry" not in runs.attrs
        same = hs.simulate_many(scenes[:2], workers=2)
        assert same.attrs["solver_symmetry"] == hs.simulate(scenes[0]).attrs["solver_symmetry"]


class TestCheck:
    def test_says_what_is_skipped_and_lists_all_periods(self) -> None:
        nodes = check_document(scene_of("base")).nodes
        text = "\n".join(texts(nodes))
        assert "1 bodies, 3 free coordinates" in text
        assert "in the plane y = 0 m, its plane of symmetry" in text
        assert "Skipped\nbarge: sway, roll, yaw zero by symmetry, not in the state" in text
        assert {row["mode"] for row in rows(nodes, "body", "mode")} == {*DOFS}

    def test_says_why_not(self) -> None:
        lines = texts(check_document(sea_of(heading=0.1)).nodes)
        assert "solved in all degrees of freedom: waves to 5.72958 deg" in lines
        assert any("6 free coordinates" in line for line in lines)

    def test_of_a_restart(self) -> None:
        run = hs.simulate(replace(full(scene_of("base")), duration=10.0))
        text = texts(check_document(replace(scene_of("base"), initial=hs.Start(run))).nodes)
        assert any("in the plane" in line for line in text)
