"""The battery that every force element must pass: zero state, action = reaction, invariance, power,
absence."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from examples import all_examples
from scenes import block, moving, scene, steady, table
from scipy.linalg import block_diag
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim.elements import Catenary, Drive, Stop, Table, Winch
from hydrosim.elements.contact.fender import CONTACT_STATES, DISSIPATED
from hydrosim.elements.contact.law import OPEN, SLIP, STICK
from hydrosim.elements.kind import BODY_ROWS, HYDROSTATIC
from hydrosim.elements.line.hang import pieces_of_segments
from hydrosim.integrate.dynamics import Model, new_work, rhs, stored_energies
from hydrosim.integrate.state import State
from hydrosim.multibody.kinematics import Motion
from hydrosim.scene import Body, Environment, Kinematics, Scene, Stream

RNG = np.random.default_rng(5)
ELEMENT = len(BODY_ROWS)  # the row of the one element of a scene
NOW = 3.0  # s
STRETCH = np.array([[0.02, -0.03], [-0.01, 0.04]])  # of the two points of the fenders [m]


def positive_definite(n: int) -> np.ndarray:
    root = RNG.normal(size=(n, n))
    return 1e3 * (root @ root.T + np.eye(n))


STIFFNESS, DAMPING = positive_definite(6), positive_definite(6)
KNEES = hs.NormalCurve(np.array([0.0, 0.2, 0.5, 1.0]), np.array([0.0, 1e4, 4e4, 2e5]), damping=3e3)
PRESSED = hs.PrescribedNormal(Table(np.array([0.0, 10.0]), np.array([1e4, 3e4])))
POINTS = np.array([[1.0, 0.5, -1.0], [-0.8, -0.6, -1.1]])
EARTH_PLANE = hs.Plane((0.2, 0.1, -0.2), (0.1, -0.2, 1.0))
DECK = hs.Plane((0.3, -0.2, 0.9), (0.1, -0.2, 1.0), body="carrier")
LAWS = {
    "stick-slip": hs.StickSlip(0.4, 0.3, 2e5, 1e4, 3e3),
    "friction slope": hs.FrictionSlope(0.3, 4e4),
    "frictionless": hs.Frictionless(),
}

PUSH = [3e3, -2e3, 5e3, 1e3, -4e3, 2e3]
SLACKENING = np.array([-0.3, 0.1, 0.4]), np.array([0.0, 5e3, 4e4])  # extension, tension


def push(body_fixed: bool) -> hs.AppliedForce:
    force = table([0.0, 10.0], [np.zeros(6), PUSH])
    frame = "body" if body_fixed else "earth"
    return hs.AppliedForce("block", (0.4, -0.3, 0.8), force, frame=frame)


ANGLES = np.radians([10.0, 80.0, 130.0, 200.0, 290.0])
SHAPE = (np.array([9.0, 2.0, -4.0, -8.0, 3.0]), RNG.normal(size=5), RNG.normal(size=5))
STREAM_TABLE = (ANGLES, *(1e2 * x for x in SHAPE))
HEAD, LOW, HIGH = (0.4, -0.3, 0.8), (0.4, -0.3, -0.8), (0.4, -0.3, 2.8)
IN_BODY_AXES = {
    "linear damping": hs.LinearDamping("block", DAMPING),
    "linear damping through the water": hs.LinearDamping(
        "block", DAMPING, relative_to_current=True
    ),
    "quadratic damping": hs.QuadraticDamping("block", DAMPING),
    "current load": hs.CurrentLoad("block", LOW, *STREAM_TABLE),
    "wind load": hs.WindLoad("block", HIGH, *STREAM_TABLE),
}
STREAMS = Environment(current=Stream(0.8, 0.5), wind=Stream(12.0, 2.0))
ELEMENTS = {
    **IN_BODY_AXES,
    "linear mooring": hs.LinearMooring("block", STIFFNESS, DAMPING),
    "applied force": push(body_fixed=False),
    "applied force, body-fixed": push(body_fixed=True),
    "spring to the earth": hs.Spring(
        "block", HEAD, (0.5, 0.3, 6.0), 4.2, curve=hs.TensionCurve(*SLACKENING), damping=2000.0
    ),
    "spring to another body": hs.Spring(
        "block",
        HEAD,
        (0.5, 0.2, 5.0),
        2.7,
        curve=hs.TensionCurve(*SLACKENING),
        damping=2000.0,
        anchor_body="carrier",
    ),
    **{
        f"fender on {where}, {name}": hs.Fender("block", POINTS, plane, curve, law)
        for where, plane in (("earth", EARTH_PLANE), ("a body", DECK))
        for name, curve, law in (
            *((name, KNEES, law) for name, law in LAWS.items()),
            ("prescribed normal force", PRESSED, LAWS["stick-slip"]),
            ("rate-free", replace(KNEES, damping=0.0), hs.StickSlip(0.4, 0.3, 2e5, 0.0)),
        )
    },
    **all_examples(),
}
FENDERS = [name for name, element in ELEMENTS.items() if isinstance(element, hs.Fender)]
CASES = [
    (name, mode)
    for name in ELEMENTS
    for mode in ((STICK, SLIP) if name in FENDERS else (OPEN,))
    # in the rate-free limit the traction of slip is not free: it is on the cone
    if not ("rate-free" in name and mode == SLIP)
    # what rigid friction holds is a constraint: `test_coulomb`
    if not ("coulomb" in name and mode == STICK)
    # a drive is a constraint, whatever acts: `tests/elements/joint/test_drives.py`
    if not isinstance(ELEMENTS[name], Drive)
]
ON_EARTH = (hs.LinearMooring, hs.AppliedForce, Drive)  # in its axes
EXAMPLES = [name for name, element in ELEMENTS.items() if "example" in name]
TURNING_EXAMPLES = (name for name in EXAMPLES if not isinstance(ELEMENTS[name], ON_EARTH))
IN_TURNING_AXES = [*IN_BODY_AXES, "applied force, body-fixed", *TURNING_EXAMPLES]
RESTING = [  # prescribed forces act at rest; so may what supplies, has weight, or is pressed
    name
    for name, element in ELEMENTS.items()
    if "prescribed" not in name and not (element.supplies and name in EXAMPLES)
    if not isinstance(element, Catenary | hs.GasSpring | Stop)
]


def two_bodies(at_rest: bool = False) -> tuple[Body, Body]:
    """A moving block pressed into a moving carrier's deck and the earth; at rest it hovers."""
    above = block(2e3, location=(0.5, -0.2), centre_of_gravity=(0.0, 0.0, 2.0))
    below = block(5e3, name="carrier", location=(0.3, 0.1), centre_of_gravity=(0.0, 0.0, -0.3))
    if at_rest:
        return above, below
    q, v = (0.1, -0.2, -1.6, 0.1, -0.12, 0.3), (0.7, -0.5, -0.4, 0.2, 0.3, -0.25)
    p, u = (-0.1, 0.05, 0.2, -0.08, 0.1, -0.2), (-0.3, 0.2, 0.15, -0.1, 0.2, 0.3)
    return replace(above, position=q, velocity=v), replace(below, position=p, velocity=u)


def scene_of(
    elements: Mapping[str, Any], kinematics: Kinematics = Kinematics.EXACT, **bodies: bool
) -> Scene:
    found = scene(two_bodies(**bodies), elements, 10.0, 0.5, step=0.01, kinematics=kinematics)
    return found if bodies.get("at_rest") else replace(found, environment=STREAMS)


@dataclass(frozen=True)
class Moment:
    """What the equation of motion makes of one instant."""

    model: Model
    state: State
    motion: Motion
    wrench: np.ndarray  # (rows, 12)
    dy: np.ndarray

    def stored(self, y: np.ndarray) -> np.ndarray:
        """Energy stored in every row at ``y`` (rows,)."""
        out = np.zeros(self.model.rows)
        stored_energies(NOW, y, self.state.modes, self.model, new_work(self.model), out)
        return out

    @property
    def points(self) -> np.ndarray:
        """Constants of the contact points."""
        return self.model.elements.fenders.points

    def loss(self, row: int) -> float:
        """Rate of the work or the dissipation of a row."""
        first = self.model.elements.fenders.state
        points = self.dy[first:][: CONTACT_STATES * self.points.size].reshape(-1, CONTACT_STATES)
        mine = self.points["row"] == row
        return float(self.dy[self.model.energy + row] + points[mine, DISSIPATED].sum())


def evaluate(
    scene: Scene,
    mode: int = OPEN,
    hydrostatics: np.ndarray | None = None,
    stretch: np.ndarray = STRETCH,
) -> Moment:
    """The first instant of a scene, with the points in contact put into ``mode``."""
    model, state = hs.compile_scene(scene)
    if hydrostatics is not None:
        model = model._replace(stiffness=hydrostatics)
    if mode != OPEN:
        state.modes[state.modes[:, 0] != OPEN, 0] = mode
    fenders = model.elements.fenders
    states = state.y[fenders.state :][: CONTACT_STATES * fenders.points.size]
    points = states.reshape(-1, CONTACT_STATES)
    if mode != OPEN and isinstance(next(iter(scene.forces.values())).friction, hs.StickSlip):
        points[:, :2] = stretch
    work, dy = new_work(model), np.zeros(model.size)
    rhs(NOW, state.y, state.modes, state.history, model, work, dy)
    return Moment(model, state, work.motion, work.wrench.copy(), dy)


@pytest.mark.parametrize(("name", "mode"), CASES)
@pytest.mark.parametrize("kinematics", Kinematics)
def test_power_is_the_rate_of_what_is_stored_and_lost(name, mode, kinematics):
    """F v = -dE/dt - loss, and the work of what supplies, to the error of central differences."""
    element = ELEMENTS[name]
    now = evaluate(scene_of({"element": element}, kinematics), mode)
    power, eps = now.wrench[ELEMENT] @ now.motion.velocity, 1e-6
    y, dy = now.state.y, now.dy
    storing = (now.stored(y + eps * dy) - now.stored(y - eps * dy))[ELEMENT] / (2 * eps)
    lost = now.loss(ELEMENT)
    assert abs(power) > 1.0  # W: there is something to compare
    if element.supplies:
        assert (lost, storing) == (pytest.approx(power, rel=1e-12), 0.0)
    else:
        size = abs(power) + abs(storing) + abs(lost)
        assert power + storing + lost == pytest.approx(0.0, abs=1e-7 * size)


@pytest.mark.parametrize("kinematics", Kinematics)
def test_power_of_hydrostatics_is_the_rate_of_what_is_stored(kinematics):
    C = np.array([STIFFNESS, DAMPING])
    now = evaluate(scene_of({}, kinematics), hydrostatics=C)
    eps, y, dy = 1e-6, now.state.y, now.dy
    storing = (now.stored(y + eps * dy) - now.stored(y - eps * dy))[HYDROSTATIC] / (2 * eps)
    power = now.wrench[HYDROSTATIC] @ now.motion.velocity
    assert power == pytest.approx(-storing, rel=1e-7)
    q = y[:12].reshape(2, 6)
    assert now.stored(y)[HYDROSTATIC] == pytest.approx(0.5 * np.einsum("bi,bij,bj", q, C, q))


@pytest.mark.parametrize("name", RESTING)
def test_no_force_at_rest(name):
    """Table still at zero, springs at their length, points above their planes."""
    resting = scene_of({"element": ELEMENTS[name]}, at_rest=True)
    model, state = hs.compile_scene(resting)
    work, dy = new_work(model), np.zeros(model.size)
    rhs(0.0, state.y, state.modes, state.history, model, work, dy)
    rounding = 1e-10 if isinstance(ELEMENTS[name], hs.Bushing) else 0.0  # of where its frames meet
    assert np.abs(work.wrench).max() <= rounding
    assert np.abs(dy).max() <= rounding


@pytest.mark.parametrize(
    ("name", "mode"),
    [case for case in CASES if any(b for _, b in ELEMENTS[case[0]].connected_bodies())],
)
@pytest.mark.parametrize("kinematics", Kinematics)
def test_action_is_reaction(name, mode, kinematics):
    """No force and no moment about the earth's origin on both bodies together; small angles keep
    lever arms, and so the places of the centres, as they are at rest."""
    now = evaluate(scene_of({"element": ELEMENTS[name]}, kinematics), mode)
    wrench = now.wrench[ELEMENT].reshape(2, 6)
    centre = now.model.bodies.each["origin"].copy()
    if kinematics is Kinematics.EXACT:
        centre += now.motion.coordinates.reshape(2, 6)[:, :3]
    moment = wrench[:, 3:] + np.cross(centre, wrench[:, :3])
    assert np.abs(wrench[0]).max() > 1e3
    element = ELEMENTS[name]
    if isinstance(element, Catenary):  # its weight, which both bodies carry
        pieces = pieces_of_segments(element.segments)
        weight = pieces["length"] @ pieces["weight"] + pieces["hung"][:-1].sum()
        assert wrench[:, :3].sum(axis=0) == pytest.approx([0.0, 0.0, -weight], abs=1e-9)
        return
    assert wrench[:, :3].sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-9)
    lines = hs.Spring | hs.Strut | Winch | hs.Compensator | hs.GasSpring | Stop | hs.DryFriction
    if kinematics is Kinematics.EXACT or not isinstance(element, lines):  # their limit
        assert moment.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-12 * np.abs(moment).max())


TURN = Rotation.from_euler("z", 1.1).as_matrix()
SHIFT = np.array([7.0, -4.0, 0.0])


def turned_body(body: Body) -> Body:
    """The body in a scene that is turned by `TURN` and then moved by `SHIFT`."""
    R = TURN @ Rotation.from_euler("ZYX", body.position[:2:-1]).as_matrix() @ TURN.T
    angles = Rotation.from_matrix(R).as_euler("ZYX")[::-1]
    position = (*(TURN @ body.position[:3]), *angles)
    start = {"position": position, "velocity": tuple(turned_wrench(np.array(body.velocity)))}
    location = tuple((TURN @ [*body.location, 0.0] + SHIFT)[:2])
    return replace(body, inertia=TURN @ body.inertia @ TURN.T, location=location, **start)


def turned_element(element: Any) -> Any:
    both = block_diag(TURN, TURN)
    if isinstance(element, hs.LinearMooring):
        K, C = (both @ A @ both.T for A in (element.stiffness, element.damping))
        return replace(element, stiffness=K, damping=C)
    if isinstance(element, hs.AppliedForce):
        point = tuple(TURN @ element.point)
        return replace(element, point=point, force=table([0.0, 10.0], [np.zeros(6), both @ PUSH]))
    if isinstance(element, hs.Spring):
        anchor = TURN @ element.anchor + (SHIFT if element.anchor_body is None else 0.0)
        return replace(element, point=tuple(TURN @ element.point), anchor=tuple(anchor))
    plane = element.plane
    point = TURN @ plane.point + (SHIFT if plane.body is None else 0.0)
    plane = replace(plane, point=tuple(point), normal=tuple(TURN @ plane.normal))
    return replace(element, points=element.points @ TURN.T, plane=plane)


def turned_stretch(moment: Moment, turned: Moment) -> np.ndarray:
    """The stretches of ``moment`` along the tangents that ``turned`` has."""
    here, there = (m.model.elements.fenders.points for m in (moment, turned))
    s = np.einsum("i,ij->ij", STRETCH[:, 0], here["tangent1"])
    s += np.einsum("i,ij->ij", STRETCH[:, 1], here["tangent2"])
    s = s @ TURN.T
    along = [np.einsum("ij,ij->i", s, there[name]) for name in ("tangent1", "tangent2")]
    return np.stack(along, axis=1)


def turned_wrench(wrench: np.ndarray) -> np.ndarray:
    return np.concatenate([TURN @ part for part in wrench.reshape(-1, 3)])


@pytest.mark.parametrize("name", IN_TURNING_AXES)
@pytest.mark.parametrize("at_rest", [False, True])
def test_elements_in_body_axes_turn_with_the_body(name, at_rest):
    """Scene, streams and yaw are turned together, while the elements stay as they are: those in the
    axes of bodies, and between bodies. The bodies have another heading at rest, or at the start."""
    if not at_rest and isinstance(ELEMENTS[name], hs.Strut | hs.Bushing | hs.SpringDamper):
        pytest.skip("its length or place at rest depends on the headings there")
    streams = (STREAMS.current, STREAMS.wind)
    current, wind = (replace(stream, heading=stream.heading + 1.1) for stream in streams)
    bodies = tuple(yawed(body, at_rest) for body in two_bodies())
    there = Environment(current=current, wind=wind)
    turned = replace(scene_of({"element": ELEMENTS[name]}), bodies=bodies, environment=there)
    here, there = evaluate(scene_of({"element": ELEMENTS[name]})), evaluate(turned)
    expected = turned_wrench(here.wrench[ELEMENT])
    tiny = 1e-12 * np.abs(expected).max()
    assert there.wrench[ELEMENT] == pytest.approx(expected, abs=tiny)
    assert there.loss(ELEMENT) == pytest.approx(here.loss(ELEMENT), rel=1e-12)


def yawed(body: Body, at_rest: bool) -> Body:
    """The body in the turned scene with its own axes turned as well, at rest too if ``at_rest``."""
    position = np.concatenate([TURN @ body.position[:3], body.position[3:]])
    heading = 1.1 if at_rest else 0.0
    position[5] += 1.1 - heading
    velocity = tuple(turned_wrench(np.array(body.velocity)))
    start = {"heading": heading, "position": tuple(position), "velocity": velocity}
    return replace(body, location=tuple((TURN @ [*body.location, 0.0] + SHIFT)[:2]), **start)


@pytest.mark.parametrize(
    ("name", "mode"), [case for case in CASES if case[0] not in {*IN_BODY_AXES, *EXAMPLES}]
)
def test_everything_turns_with_the_scene(name, mode):
    """About z, and shifted; moorings on angles are no vectors: they have none here (see below)."""
    element = ELEMENTS[name]
    if isinstance(element, hs.LinearMooring):
        K, C = (block_diag(A[:3, :3], np.zeros((3, 3))) for A in (STIFFNESS, DAMPING))
        element = replace(element, stiffness=K, damping=C)
    original = scene_of({"element": element})
    here = evaluate(original, mode)
    bodies = tuple(turned_body(body) for body in original.bodies)
    other = replace(original, bodies=bodies, forces={"element": turned_element(element)})
    stretch = turned_stretch(here, evaluate(other, mode)) if name in FENDERS else STRETCH
    there = evaluate(other, mode, stretch=stretch)
    expected = turned_wrench(here.wrench[ELEMENT])
    tiny = 1e-11 * np.abs(expected).max()
    assert there.wrench[ELEMENT] == pytest.approx(expected, abs=tiny)
    assert there.loss(ELEMENT) == pytest.approx(here.loss(ELEMENT), rel=1e-10, abs=1e-9)
    acceleration = turned_wrench(here.dy[12:24])
    for k in (0, 6):  # accelerations of the centres
        assert there.dy[12 + k : 15 + k] == pytest.approx(acceleration[k : k + 3], rel=1e-10)


def test_springs_on_angles_turn_with_the_scene_to_first_order():
    """The moment of a linear spring turns up to a part that is proportional to the angles."""

    def difference(size: float) -> float:
        body = block(2e3, position=(0.0, 0.0, 0.0, 0.1 * size, -0.12 * size, 0.3 * size))
        springs = {"mooring": hs.LinearMooring("block", STIFFNESS)}
        original = scene(body, springs, 10.0, 0.5)
        turned = turned_element(replace(springs["mooring"], damping=DAMPING))
        other = replace(original, bodies=(turned_body(body),), forces={"mooring": turned})
        here, there = (evaluate(s).wrench[ELEMENT] for s in (original, other))
        return float(np.abs(there - turned_wrench(here)).max() / np.abs(here).max())

    assert difference(1e-2) < 1e-2
    assert difference(1e-2) / difference(5e-3) == pytest.approx(2.0, abs=0.1)


IDLE = {
    "linear mooring": hs.LinearMooring("block", np.zeros((6, 6))),
    "applied force": steady(surge=0.0, yaw=0.0),
    "linear damping": hs.LinearDamping("block", np.zeros((6, 6))),
    "quadratic damping": hs.QuadraticDamping("block", np.zeros((6, 6))),
    "wind load": hs.WindLoad("block", (0.0, 0.0, 1.0), ANGLES, *np.zeros((3, 5))),
    "spring": hs.Spring(
        "block", HEAD, (50.0, 0.0, 0.0), 100.0, curve=hs.TensionCurve(*SLACKENING), damping=2000.0
    ),
    **{
        f"fender, {name}": hs.Fender("block", POINTS, hs.Plane((0, 0, -50), (0, 0, 1)), KNEES, law)
        for name, law in LAWS.items()
    },
}


def drifting(elements: Mapping[str, Any]) -> Scene:
    """A body on a spring, and whatever else."""
    spring = {"spring": hs.LinearMooring("block", STIFFNESS)}
    body = block(2e3, position=moving(surge=0.3, pitch=0.1), velocity=moving(sway=1.0, yaw=0.2))
    return scene(body, {**spring, **elements}, 5.0, 0.1, step=0.05)


@pytest.mark.parametrize("name", IDLE)
def test_an_element_that_does_nothing_changes_nothing(name):
    without, idle = hs.simulate(drifting({})), hs.simulate(drifting({"idle": IDLE[name]}))
    assert np.array_equal(without.position, idle.position)
    assert not idle["force_idle"].values.any()
    assert without.energy_residual.values == pytest.approx(idle.energy_residual.values, abs=1e-9)


def largest_array(p: Any) -> int:
    """Entries of the largest array among the constants of a kind."""
    parts = p if isinstance(p, tuple) else (p,)
    return max((part.size for part in parts if isinstance(part, np.ndarray)), default=0)


def test_absent_elements_have_no_size():
    model, state = hs.compile_scene(drifting({}))
    sizes = {name: largest_array(p) for name, p in model.elements._asdict().items()}
    assert sizes.pop("linear_moorings") == 1
    assert not any(sizes.values())
    assert state.modes.shape == (0, 3)
    assert model.energy == model.radiation == 12  # coordinates and rates alone
    assert model.size - model.energy == len(BODY_ROWS) + 2  # its rows, the mooring's, |wave power|
