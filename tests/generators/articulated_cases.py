"""Random articulated cases: trees of 2 to 6 bodies on joints of all types, dry or in water.

A case is drawn from its seed alone, and can be turned as a whole about the vertical. Sizes go
together as those of `random_cases` do: springs with natural periods of what they hold, stops and
friction with the loads that reach them, steps with the fastest rate. Trees hang from the earth or
drift on a mooring. Some start far from rest, and some steps are too large. Numbers from
`LINKED_FROM` on have links in joints, about axes and along lines.
"""

from dataclasses import dataclass, field
from math import cos, hypot, pi, sin, sqrt
from typing import Any

from hydrosim.scene import joint as joints
from tests.generators.random_cases import FINE, GRAVITY, STEPS, Case, Draw, Place, rounded
from tests.generators.random_links import LINKED_FROM, Course, draw_link

TYPES = {
    "hinge": 30.0,
    "ball": 18.0,
    "universal": 15.0,
    "slider": 11.0,
    "cylindrical": 10.0,
    "planar": 8.0,
    "fixed": 8.0,
}
METHODS = {"rk4": 45.0, "dopri5": 30.0, "esdirk4": 10.0, "rk2": 5.0, "automatic": 10.0}
LINES = ("spring", "strut", "power_take_off")
UNSUITED = (0.1, 0.05)  # s: steps that are taken whatever the rates are
DOFS = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass
class Limb:
    """A body: half of its length [m], its place at rest before the turn of the scene, its heading
    there. Its joint holds it at ``arm`` from its centre, in its own axes; a root has none."""

    name: str
    mass: float
    size: float
    place: Place
    heading: float
    wet: bool
    arm: Place = (0.0, 0.0, 0.0)

    @property
    def inertia(self) -> float:
        """Of the order of its inertia about its joint [kg m^2]."""
        return self.mass * self.size**2


@dataclass
class Tree:
    """A case on its way, turned by ``turn``; ``rates`` [rad/s] are the fastest of its parts."""

    draw: Draw
    turn: float
    limbs: list[Limb] = field(default_factory=list)
    bodies: Case = field(default_factory=dict)
    joints: Case = field(default_factory=dict)
    forces: Case = field(default_factory=dict)
    rates: list[float] = field(default_factory=lambda: [2.0])

    def turned(self, x: float, y: float) -> tuple[float, float]:
        """A horizontal vector as the turned scene has it, not rounded."""
        c, s = cos(self.turn), sin(self.turn)
        return c * x - s * y, s * x + c * y

    def add(self, kind: str, body: str, **keys: Any) -> None:
        """A force element, under a name of its own."""
        self.forces[f"{kind}_{len(self.forces) + 1}"] = {"type": kind, "body": body, **keys}


def articulated_case(seed: int, turn: float = 0.0) -> Case:
    """The case of a seed, as a case file holds it, turned about the vertical by ``turn`` [rad]."""
    d = Draw(seed)
    tree = Tree(d, turn)
    floats = d.chance(0.5)
    _grow(tree, d.one((2, 3, 4, 5, 6), 30, 25, 20, 15, 10), floats)
    for limb in tree.limbs:
        tree.bodies[limb.name] = _body(tree, limb, floats)
    if floats:
        _moor(tree)
    for limb in tree.limbs:
        _furnish(tree, limb)
    if len(tree.limbs) > 2 and d.chance(0.3):
        _tie(tree)
    if seed >= LINKED_FROM:
        _link_joints(tree)
        for limb in tree.limbs:
            _link_limb(tree, limb)
    return _whole(tree, seed)


def _grow(tree: Tree, count: int, floats: bool) -> None:
    """Bodies one after the other, each on a joint to one of those before it or to the earth."""
    d = tree.draw
    mass = d.order(1e2, 1e6)
    size = d.between(0.5, 1.0) * (mass / 300.0) ** (1.0 / 3.0)
    water = floats or d.chance(0.3)
    for k in range(count):
        own = size * d.between(0.6, 1.4)
        weight = rounded(mass * d.order(0.3, 1.5))
        limb = Limb(f"limb{k}", weight, rounded(own), (0.0, 0.0, 0.0), 0.0, water and d.chance(0.6))
        limb.heading = d.between(-pi, pi) if d.chance(0.5) else 0.0
        if k == 0 and floats:
            limb.wet = True
            limb.mass = rounded(3.0 * mass)
            tree.limbs.append(limb)
            continue
        parent = d.one(tree.limbs) if tree.limbs and (floats or d.chance(0.85)) else None
        _join(tree, limb, parent)
        tree.limbs.append(limb)


def _join(tree: Tree, limb: Limb, parent: Limb | None) -> None:
    """Place a body beside its parent and join it."""
    d = tree.draw
    reach = parent.size if parent else 0.0
    away = d.between(-pi, pi)
    here = parent.place if parent else (0.0, 0.0, 0.0)
    x, y, z = here
    pin = (x + reach * cos(away), y + reach * sin(away), z - d.between(-0.2, 0.6) * reach)
    limb.arm = tuple(rounded(limb.size * x) for x in (d.between(-0.4, 0.4), 0.1, d.between(0.3, 1)))
    c, s = cos(limb.heading), sin(limb.heading)
    x, y, z = limb.arm
    centre = (pin[0] - c * x + s * y, pin[1] - s * x - c * y, pin[2] - z)
    limb.place = tuple(rounded(v) for v in centre)
    kind = d.one(tuple(TYPES), *TYPES.values())
    joint: Case = {"type": kind, "body": limb.name, "point": list(limb.arm)}
    if parent:
        joint["to"] = parent.name
    joint |= _axes(d, kind)
    joint |= _motions(tree, kind, limb)
    tree.joints[f"joint{len(tree.joints) + 1}"] = joint


def _axes(d: Draw, kind: str) -> Case:
    if kind in ("ball", "fixed"):
        return {}
    first = d.one(([0, 1, 0], [1, 0, 0], [0, 0, 1], [d.between(-1, 1), d.between(-1, 1), 1.0]))
    if kind != "universal":
        return {"axis": first}
    square = ([0, 1, 0], [0, 0, 1])
    axis, second = d.one((([1, 0, 0], [0, 1, 0]), square, ([1, 1, 0], [1, -1, 0.5])))
    return {"axis": axis, "second_axis": second}


def _motions(tree: Tree, kind: str, limb: Limb) -> Case:
    """What acts in the free motions of a joint, and how they start."""
    if kind == "hinge":
        return _turn(tree, limb)
    if kind == "slider":
        return _slide(tree, limb)
    if kind == "cylindrical":
        return {"slide": _slide(tree, limb), "turn": _turn(tree, limb)}
    if kind == "universal":
        return {"first": _turn(tree, limb), "second": _turn(tree, limb)}
    if kind == "planar":
        slides = {"first": _slide(tree, limb), "second": _slide(tree, limb)}
        return {**slides, "turn": _turn(tree, limb)}
    return _swivel(tree, limb) if kind == "ball" else {}


def _swivel(tree: Tree, limb: Limb) -> Case:
    d = tree.draw
    rotation, rate = ([d.between(-0.5, 0.5) for _ in range(3)] for _ in range(2))
    found: Case = {"initial": {"rotation": rotation, "rate": rate}}
    if d.chance(0.6):
        found["damping"] = rounded(limb.inertia * d.order(0.05, 1.0))
    return found


def _turn(tree: Tree, limb: Limb) -> Case:
    """A spring, damping, stops or friction about an axis."""
    d = tree.draw
    angle = d.between(-0.5, 0.5)
    found: Case = {"initial": {"angle": angle, "rate": d.between(-0.5, 0.5)}}
    if d.chance(0.6):
        rate = d.order(1.0, 5.0)
        found["stiffness"] = rounded(limb.inertia * rate**2)
        tree.rates.append(2.0 * rate)
        if d.chance(0.3):
            found["neutral"] = d.between(-0.2, 0.2)
    if d.chance(0.5):
        found["damping"] = rounded(limb.inertia * d.order(0.05, 1.0))
    if d.chance(0.25):
        rate = d.order(8.0, 25.0)
        ends = [rounded(angle - d.between(0.1, 0.8)), rounded(angle + d.between(0.1, 0.8))]
        found["stops"] = {"range": ends, "stiffness": rounded(limb.inertia * rate**2)}
        if d.chance(0.6):
            found["stops"]["damping"] = rounded(limb.inertia * rate * d.between(0.05, 0.5))
        tree.rates.append(2.0 * rate)
    if d.chance(0.15):
        static = rounded(limb.inertia * d.order(0.1, 1.0))
        kinetic = rounded(static * d.between(0.6, 1.0))
        moments = {"static_moment": static, "kinetic_moment": min(static, kinetic)}
        found["friction"] = {"law": "coulomb", **moments}
    return found


def _slide(tree: Tree, limb: Limb) -> Case:
    """A spring along an axis, damping, stops or friction."""
    d = tree.draw
    offset = rounded(limb.size * d.between(-0.1, 0.1))
    rate = d.order(2.0, 6.0)
    tree.rates.append(2.0 * rate)
    start = {"offset": offset, "speed": rounded(limb.size * d.between(-0.2, 0.2))}
    found: Case = {"initial": start, "stiffness": rounded(limb.mass * rate**2)}
    if d.chance(0.6):
        found["damping"] = rounded(limb.mass * rate * d.order(0.02, 0.5))
    if d.chance(0.2):
        stiff = d.order(8.0, 25.0)
        ends = [offset - limb.size * d.between(0.1, 0.6), offset + limb.size * d.between(0.1, 0.6)]
        found["stops"] = {
            "range": [rounded(end) for end in ends],
            "stiffness": rounded(limb.mass * stiff**2),
            "damping": rounded(limb.mass * stiff * d.between(0.05, 0.5)),
        }
        tree.rates.append(2.0 * stiff)
    if d.chance(0.15):
        static = rounded(limb.mass * d.order(0.05, 0.5))
        found["friction"] = {"law": "coulomb", "static_force": static}
    return found


def _body(tree: Tree, limb: Limb, floats: bool) -> Case:
    """The body of a limb. What hangs from the earth has weight; what floats is mostly balanced."""
    d = tree.draw
    x, y, z = limb.place
    extent = [limb.size * d.between(0.2, 0.45) for _ in range(3)]
    radii = [rounded(sqrt(extent[i - 1] ** 2 + extent[i - 2] ** 2)) for i in range(3)]
    points = {"bow": [limb.size, 0.0, 0.0], "mast": [0.0, 0.1 * limb.size, limb.size]}
    body: Case = {"mass": limb.mass, "centre_of_gravity": [0.0, 0.0, z]}
    body |= {"location": list(tree.turned(x, y)), "radii_of_gyration": radii, "points": points}
    if limb.heading or tree.turn:
        body["heading"] = limb.heading + tree.turn
    is_root = limb is tree.limbs[0] and floats
    if limb.wet:
        body["hydrodynamics"] = _coefficients(tree, limb, is_root)
    elif d.chance(0.2 if floats else 0.85):
        body["weight"] = "carried"
        tree.rates.append(2.0 * sqrt(GRAVITY / limb.size))
    if is_root:
        offsets = [rounded(limb.size * d.between(-0.2, 0.2)) for _ in range(3)]
        angles = [d.between(-0.2, 0.2) for _ in range(3)]
        speed = [rounded(limb.size * d.between(-0.2, 0.2)) for _ in range(3)]
        position = [*tree.turned(offsets[0], offsets[1]), offsets[2], *angles]
        sliding = [*tree.turned(speed[0], speed[1]), speed[2]]
        velocity = [*sliding, 0.0, 0.0, d.between(-0.2, 0.2)]
        body["initial"] = {"position": position, "velocity": velocity}
    return body


def _coefficients(tree: Tree, limb: Limb, is_root: bool) -> Case:
    d = tree.draw
    mass, inertia = limb.mass, limb.inertia
    added = {dof: rounded(mass * d.between(0.05, 1.0)) for dof in DOFS[:3]}
    added |= {dof: rounded(inertia * d.between(0.02, 0.3)) for dof in DOFS[3:]}
    found: Case = {"added_mass": added}
    if d.chance(0.7):
        damping = {dof: rounded(mass * d.order(0.02, 0.4)) for dof in DOFS[:3]}
        damping |= {dof: rounded(inertia * d.order(0.01, 0.2)) for dof in DOFS[3:]}
        found["damping"] = damping
    if is_root:
        rate = d.between(1.5, 3.0)
        tree.rates.append(1.5 * rate)
        stiff = {"heave": 2.0 * mass, "roll": 0.5 * inertia, "pitch": 0.5 * inertia}
        found["stiffness"] = {dof: rounded(k * rate**2) for dof, k in stiff.items()}
    return found


def _moor(tree: Tree) -> None:
    """A mooring of the root, alike in all directions, as it must be to be turned."""
    d = tree.draw
    root = tree.limbs[0]
    rate = d.order(0.2, 1.0)
    stiffness = rounded(root.mass * rate**2)
    yaw = rounded(root.inertia * rate**2)
    keys: Case = {"stiffness": {"surge": stiffness, "sway": stiffness, "yaw": yaw}}
    if d.chance(0.6):
        keys["damping_ratio"] = {"surge": 0.1, "sway": 0.1, "yaw": d.between(0.02, 0.2)}
    tree.add("linear_mooring", root.name, **keys)


def _furnish(tree: Tree, limb: Limb) -> None:
    """Pushes, lines to anchors, damping, and a floor or a wall near by."""
    d = tree.draw
    if d.chance(0.3):
        size = rounded(limb.mass * d.order(0.1, 1.5))
        push = {"amplitude": size, "period": d.order(1.5, 8.0)}
        keys: Case = {"force": {d.one(("surge", "sway", "heave")): push}, "frame": "body"}
        if d.chance(0.5):
            keys["point"] = [rounded(0.3 * limb.size), 0.0, 0.0]
        tree.add("applied_force", limb.name, **keys)
    if d.chance(0.25):
        _line(tree, limb)
    if d.chance(0.2):
        damping = rounded(limb.mass * d.order(0.05, 0.5))
        tree.add("linear_damping", limb.name, damping=dict.fromkeys(DOFS[:3], damping))
    if d.chance(0.1):
        _hold(tree, limb)
    if d.chance(0.15):
        _face(tree, limb)


def _hold(tree: Tree, limb: Limb) -> None:
    """A spring about an axis, or one in six directions, to another body or to the earth."""
    d = tree.draw
    rate = d.order(0.5, 4.0)
    tree.rates.append(2.0 * rate)
    others = [other.name for other in tree.limbs if other is not limb]
    keys: Case = {"to": d.one(others)} if d.chance(0.7) else {}
    moment = rounded(limb.inertia * rate**2)
    loss = rounded(limb.inertia * rate * d.between(0.02, 0.3))
    if d.chance(0.5):
        keys |= {"axis": [0.3, 1.0, 0.2], "stiffness": moment, "damping": loss}
        tree.add("torsion_spring", limb.name, **keys)
        return
    stiffness = dict.fromkeys(DOFS[:3], rounded(limb.mass * rate**2))
    stiffness |= dict.fromkeys(DOFS[3:], moment)
    keys |= {"point": [0.0, 0.0, rounded(0.3 * limb.size)], "stiffness": stiffness}
    tree.add("bushing", limb.name, **keys, damping=dict.fromkeys(DOFS[3:], loss))


def _line(tree: Tree, limb: Limb) -> None:
    """A spring to an anchor, a little slack or taut."""
    d = tree.draw
    away, reach = d.between(-pi, pi), limb.size * d.between(1.5, 4.0)
    x, y, z = limb.place
    up = d.between(-1.0, 1.0) * reach
    anchor = tree.turned(x + reach * cos(away), y + reach * sin(away))
    rate = d.order(0.5, 4.0)
    tree.rates.append(2.0 * rate)
    keys: Case = {
        "point": [0.0, 0.0, rounded(0.2 * limb.size)],
        "anchor": [*anchor, rounded(z + 0.2 * limb.size + up)],
        "length": rounded(hypot(reach, up) * d.between(0.95, 1.1)),
        "stiffness": rounded(limb.mass * rate**2),
    }
    if d.chance(0.4):
        keys["damping"] = rounded(limb.mass * rate * d.between(0.02, 0.3))
    tree.add(d.one(LINES, 60, 30, 10), limb.name, **keys)


def _tie(tree: Tree) -> None:
    """A spring between two bodies."""
    d = tree.draw
    one, other = tree.limbs[-1], tree.limbs[0]
    x, y, z = one.place
    aside = 0.1 * other.size
    u, v, w = other.place
    ring = (u - aside * sin(other.heading), v + aside * cos(other.heading), w)
    span = hypot(ring[0] - x, ring[1] - y, ring[2] - z)
    rate = d.order(0.5, 4.0)
    tree.rates.append(2.0 * rate)
    kind = d.one(LINES, 60, 30, 10)
    keys = {"point": [0.0, 0.0, 0.0], "anchor": [0.0, rounded(aside), 0.0]}
    length = rounded(max(span, 0.5 * one.size) * d.between(0.95, 1.1))
    keys |= {"anchor_body": other.name, "length": length}
    tree.add(kind, one.name, **keys, stiffness=rounded(min(one.mass, other.mass) * rate**2))


def _link_joints(tree: Tree) -> None:
    """Links in motions of joints, of some motions two."""
    d = tree.draw
    sizes = {limb.name: limb for limb in tree.limbs}
    for name, joint in tree.joints.items():
        limb = sizes[joint["body"]]
        motions = [
            m for m in getattr(joints, joint["type"].capitalize()).motions if m.kind != "swivel"
        ]
        for motion in motions:
            for _ in range(d.one((0, 1, 2), 50, 40, 10)):
                turns = motion.kind == "turn"
                span, mass = (0.5, limb.inertia) if turns else (0.3 * limb.size, limb.mass)
                course = Course(0.0, span, mass)
                link = draw_link(d, course)
                tree.rates.append(link.rate)
                tree.forces[f"{link.kind}_{len(tree.forces) + 1}"] = {
                    "type": link.kind,
                    "joint": name,
                    **({"motion": motion.name} if len(motions) > 1 or d.chance(0.5) else {}),
                    **link.keys,
                }


def _link_limb(tree: Tree, limb: Limb) -> None:
    """A link about an axis, to the earth or another body, and one along a line to an anchor."""
    d = tree.draw
    if d.chance(0.25):
        axis = d.one(([0, 0, 1], [0, 1, 0], [d.between(-1, 1), d.between(-1, 1), 1.0]))
        others = [other.name for other in tree.limbs if other is not limb]
        to: Case = {"to": d.one(others)} if d.chance(0.6) else {}
        link = draw_link(d, Course(0.0, 0.5, limb.inertia))
        tree.rates.append(link.rate)
        tree.add(link.kind, limb.name, axis=axis, **to, **link.keys)
    if d.chance(0.25):
        away = d.between(-pi, pi)
        reach = limb.size * d.between(1.5, 4.0)
        x, y, z = limb.place
        anchor = tree.turned(x + reach * cos(away), y + reach * sin(away))
        link = draw_link(d, Course(reach, 0.4 * limb.size, limb.mass, distance=True))
        tree.rates.append(link.rate)
        tree.add(link.kind, limb.name, point=[0.0, 0.0, 0.0], anchor=[*anchor, z], **link.keys)


def _face(tree: Tree, limb: Limb) -> None:
    """A floor or a wall, with a point of the body that may touch it."""
    d = tree.draw
    rate = d.order(5.0, 20.0)
    tree.rates.append(2.0 * rate)
    x, y, z = limb.place
    gap = limb.size * d.between(0.02, 0.4)
    if d.chance(0.5):
        point = [0.0, 0.0, -limb.size]
        plane: Case = {"point": [0.0, 0.0, rounded(z - limb.size - gap)], "normal": [0.0, 0.0, 1.0]}
    else:
        away = d.between(-pi, pi)
        side = (cos(away), sin(away))
        face = (x - (limb.size + gap) * side[0], y - (limb.size + gap) * side[1])
        turn = away - limb.heading
        point = [-limb.size * cos(turn), -limb.size * sin(turn), 0.0]
        plane = {"point": [*tree.turned(*face), 0.0], "normal": [*tree.turned(*side), 0.0]}
    stiffness = rounded(limb.mass * rate**2)
    friction: Case = {"law": "none"}
    if d.chance(0.6):
        friction = {"law": "stick_slip", "static": 0.3, "kinetic": d.between(0.1, 0.3)}
        friction |= {"stiffness": stiffness, "damping": rounded(0.2 * limb.mass * rate)}
        tree.rates.append(5.0 * rate)
    normal = {"stiffness": stiffness, "damping": rounded(limb.mass * rate * d.between(0.02, 0.4))}
    tree.add("fender", limb.name, points=[point], plane=plane, normal=normal, friction=friction)


def _current(tree: Tree) -> Case:
    """A current that drags all that is in the water."""
    d = tree.draw
    for limb in tree.limbs:
        if limb.wet:
            drag = {dof: rounded(limb.mass * d.order(0.02, 0.2)) for dof in DOFS[:2]}
            tree.add("linear_damping", limb.name, damping=drag, relative_to_current=True)
    return {"speed": d.between(0.1, 1.0), "heading": d.between(-pi, pi) + tree.turn}


def _whole(tree: Tree, seed: int) -> Case:
    """The whole case, with a method and a step that goes with its fastest rate."""
    d = tree.draw
    environment: Case = {"water_depth": "infinite"}
    if d.chance(0.3) and any(limb.wet for limb in tree.limbs):
        environment["current"] = _current(tree)
    method = d.one(tuple(METHODS), *METHODS.values())
    wanted = FINE.get(method, 1.0) * d.order(0.06, 0.4) / max(tree.rates)
    step = next((h for h in STEPS if h <= wanted), STEPS[-1])
    if d.chance(0.15):
        step = d.one(UNSUITED)
    every = max(1, round(0.1 / step))
    case = {"title": f"articulated case {seed}", "duration": float(d.one((5.0, 8.0, 12.0)))}
    case |= {"environment": environment, "bodies": tree.bodies, "joints": tree.joints}
    case |= {"forces": tree.forces, "solver": {"method": method, "step": step}}
    return {**case, "output": {"step": rounded(every * step)}}
