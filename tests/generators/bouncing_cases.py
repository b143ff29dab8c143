"""Random bodies that strike a few times: balls on elastic floors, masses at a stop, landing blocks.

A case is drawn from its seed alone, lasts 60 to 120 s, and has 5 to 19 impacts, or blocks that land
and come to rest. Their weights are forces of any size, so that they are slow enough for so few.
"""

from math import pi, sqrt

from tests.generators.long_cases import long_case, long_duration
from tests.generators.random_cases import Case, Draw, rounded

FLOOR: Case = {"point": [0, 0, 0], "normal": [0, 0, 1]}
IMPACTS = (5.0, 19.9)
CORNERS = [(x, y) for x in (0.5, -0.5) for y in (0.4, -0.4)]
"""Of a block, over its size."""


def bouncing_case(seed: int) -> Case:
    """The case of a seed, as a case file holds it."""
    d = Draw(seed)
    return d.one((_ball, _stop, _landing), 50, 25, 25)(d, seed)


def _ball(d: Draw, seed: int) -> Case:
    """A ball on a floor that gives back nearly all."""
    duration = long_duration(d)
    between = duration / d.between(*IMPACTS)
    gravity = d.order(0.1, 10.0)
    height = gravity * between**2 / 8.0
    mass = d.order(10.0, 1e6)
    rate = d.order(3.0, 40.0)
    sideways = d.chance(0.3)
    dofs = ["surge", "heave"] if sideways else ["heave"]
    body = _body(d, mass, 1.0, dofs, up=rounded(height))
    if sideways:
        body["initial"]["velocity"] = [d.between(-1.0, 1.0), 0.0, 0.0, 0.0, 0.0, 0.0]
    floor = {
        **_fender(d, [[0.0, 0.0, 0.0]], FLOOR, mass * rate**2, mass * gravity),
        "friction": _friction(d, mass, rate) if sideways else {"law": "none"},
    }
    forces = {"floor": floor, "gravity": _steady("heave", -mass * gravity)}
    return long_case(d, seed, rate, duration, bodies={"body": body}, forces=forces)


def _stop(d: Draw, seed: int) -> Case:
    """A mass on a soft spring that strikes a stop once a period."""
    duration = long_duration(d)
    slow = 2.0 * pi * d.between(*IMPACTS) / duration
    mass = d.order(10.0, 1e6)
    rate = slow * d.order(5.0, 40.0)
    far = d.order(0.1, 5.0)
    wall = {"point": [rounded(-far * d.between(0.1, 0.8)), 0, 0], "normal": [1, 0, 0]}
    body = _body(d, mass, 1.0, ["surge"])
    body["initial"] = {"position": [rounded(far), 0.0, 0.0, 0.0, 0.0, 0.0]}
    spring = {"type": "linear_mooring", "body": "body"}
    stop = _fender(d, [[0.0, 0.0, 0.0]], wall, mass * rate**2, mass * rate * slow * far)
    soft = {"surge": rounded(mass * slow**2)}
    stop = {**stop, "friction": {"law": "none"}}
    forces = {"spring": {**spring, "stiffness": soft}, "stop": stop}
    return long_case(d, seed, rate, duration, bodies={"body": body}, forces=forces)


def _landing(d: Draw, seed: int) -> Case:
    """A block that falls on its four corners, and is pushed to and fro."""
    mass = d.order(1e3, 1e7)
    size = (mass / 800.0) ** (1.0 / 3.0)
    height = 0.25 * size
    rate = d.order(5.0, 30.0)
    body = _body(d, mass, size, None, up=rounded(size * d.order(0.01, 0.3)))
    body["centre_of_gravity"] = [0.0, 0.0, rounded(height)]
    body["initial"]["position"][3:5] = [d.between(-0.05, 0.05) for _ in range(2)]
    corners = [(0.5 * size * x, 0.4 * size * y) for x, y in CORNERS]
    points = [[rounded(x), rounded(y), -rounded(height)] for x, y in corners]
    floor = _fender(d, points, FLOOR, mass * rate**2, mass * 9.81)
    floor["normal"]["damping"] = rounded(mass * rate * d.between(0.1, 0.6))
    floor["friction"] = _friction(d, mass, rate)
    forces = {"floor": floor, "gravity": _steady("heave", -9.81 * mass)}
    if d.chance(0.6):
        push = {"amplitude": rounded(mass * d.order(0.3, 5.0)), "period": d.order(2.0, 12.0)}
        forces["push"] = {"type": "applied_force", "body": "body", "force": {"surge": push}}
    bodies = {"body": body}
    return long_case(d, seed, 1.5 * rate, long_duration(d), bodies=bodies, forces=forces)


def _body(d: Draw, mass: float, size: float, dofs: list[str] | None, up: float = 0.0) -> Case:
    radii = [rounded(size * d.between(0.28, 0.38)) for _ in range(3)]
    body: Case = {"mass": rounded(mass), "centre_of_gravity": [0.0, 0.0, 0.0]}
    body |= {"radii_of_gyration": radii, "initial": {"position": [0.0, 0.0, up, 0.0, 0.0, 0.0]}}
    return {**body, "dofs": dofs} if dofs else body


def _steady(dof: str, size: float) -> Case:
    return {"type": "applied_force", "body": "body", "force": {dof: rounded(size)}}


def _fender(d: Draw, points: list[list[float]], plane: Case, k: float, load: float) -> Case:
    """Points with a straight or a bent curve of a stiffness ``k`` all in all."""
    normal: Case = {"total": True}
    if d.chance(0.6):
        normal["stiffness"] = rounded(k)
    else:
        bend = load / k * d.order(0.5, 5.0)
        steeper = d.between(1.2, 3.0)
        normal["compression"] = [0.0, rounded(bend), rounded(3.0 * bend)]
        normal["force"] = [0.0, rounded(k * bend), rounded(k * bend * (1.0 + 2.0 * steeper))]
    if d.chance(0.2):
        normal["damping"] = rounded(d.order(0.002, 0.05) * sqrt(k * load))
    return {"type": "fender", "body": "body", "points": points, "plane": plane, "normal": normal}


def _friction(d: Draw, mass: float, rate: float) -> Case:
    if d.chance(0.3):
        return {"law": "none"}
    kinetic = d.between(0.1, 0.5)
    keys: Case = {"static": rounded(kinetic * d.between(1.0, 1.6)), "kinetic": kinetic}
    stiffness = rounded(mass * rate**2 * d.order(0.3, 1.5))
    damping = rounded(mass * rate * d.between(0.05, 0.4))
    return {"law": "stick_slip", **keys, "stiffness": stiffness, "damping": damping, "total": True}
