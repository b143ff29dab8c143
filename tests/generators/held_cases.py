"""Random bodies that are held, by loads that are just above or just below what holds them.

Rigid friction at a point, in a slider or a hinge, a drum, a joint or a rope that breaks. The peaks
of the load are 0.2 to 5 % beyond the bound, or below it, with round and odd periods.
"""

from math import pi, sqrt

from tests.generators.long_cases import long_case, long_duration
from tests.generators.random_cases import Case, Draw, rounded

ROUND = (0.5, 1.0, 2.0, 3.0)  # s
BELOW = 0.25  # of the cases: nothing may move
STIFF = 12.0  # times the frequency of the load: that of what holds by a spring


def held_case(seed: int) -> Case:
    """The case of a seed, as a case file holds it."""
    d = Draw(seed)
    make = d.one((_floor, _dip, _slider, _hinge, _drum, _clamp, _rope), 20, 15, 20, 10, 15, 10, 10)
    period = d.one(ROUND) if d.chance(0.6) else d.between(0.4, 4.0)
    return make(d, seed, period)


def _beyond(d: Draw) -> float:
    """Peak of a load over what holds."""
    by = d.order(0.002, 0.05)
    return 1.0 - by if d.chance(BELOW) else 1.0 + by


def _body(mass: float, dofs: list[str] | None = None) -> Case:
    shape: Case = {"centre_of_gravity": [0.0, 0.0, 0.0], "radii_of_gyration": [1, 1, 1]}
    body: Case = {"mass": mass, **shape}
    return {**body, "dofs": dofs} if dofs else body


def _push(d: Draw, dof: str, size: float, period: float) -> Case:
    """A sine with this peak [N, N m], with a mean or without."""
    mean = d.one((0.0, 0.3 * size), 70, 30)
    harmonic = {"amplitude": rounded(size - mean), "period": period, "mean": rounded(mean)}
    if d.chance(0.5):
        harmonic["phase"] = d.between(-pi, pi)
    return {"type": "applied_force", "body": "body", "force": {dof: harmonic}}


def _spring(mass: float, slow: float, dof: str = "surge") -> Case:
    """What brings the body back."""
    stiffness, damping = {dof: rounded(mass * slow**2)}, {dof: rounded(0.2 * mass * slow)}
    return {"type": "linear_mooring", "body": "body", "stiffness": stiffness, "damping": damping}


def _rigid(d: Draw, normal: Case) -> Case:
    """A point with rigid friction under a given load."""
    static = d.between(0.1, 0.5)
    plane = {"point": [0, 0, 0], "normal": [0, 0, 1]}
    law = {"law": "coulomb", "static": static, "kinetic": rounded(static * d.between(0.3, 1.0))}
    keys: Case = {"points": [[0, 0, 0]], "plane": plane, "normal": normal, "friction": law}
    return {"type": "fender", "body": "body", **keys}


def _mass(d: Draw) -> float:
    return d.order(1e2, 1e7)


def _floor(d: Draw, seed: int, period: float) -> Case:
    """A block under a constant load."""
    mass = _mass(d)
    load = rounded(mass * 9.81)
    floor = _rigid(d, {"prescribed": {"time": [0.0], "force": [load]}})
    hold = floor["friction"]["static"] * load
    forces = {"floor": floor, "push": _push(d, "surge", _beyond(d) * hold, period)}
    if d.chance(0.4):
        forces["spring"] = _spring(mass, 0.3 * 2.0 * pi / period)
    bodies = {"body": _body(mass, ["surge"])}
    return long_case(d, seed, 2.0 * pi / period, long_duration(d), bodies=bodies, forces=forces)


def _dip(d: Draw, seed: int, period: float) -> Case:
    """A block under a load that dips, and a push that grows and stays."""
    mass = _mass(d)
    load, dip = rounded(mass * 9.81), d.between(0.1, 0.6)
    prescribed = {"mean": load, "amplitude": rounded(dip * load), "period": period}
    floor = _rigid(d, {"prescribed": {**prescribed, "phase": d.between(-pi, pi)}})
    hold = floor["friction"]["static"] * load * (1.0 - dip)
    table = {"time": [0.0, 2.0], "force": [0.0, rounded(_beyond(d) * hold)]}
    push = {"type": "applied_force", "body": "body", "force": {"surge": table}}
    forces = {"floor": floor, "push": push, "spring": _spring(mass, d.order(0.2, 1.0))}
    bodies = {"body": _body(mass, ["surge"])}
    return long_case(d, seed, 2.0 * pi / period, long_duration(d), bodies=bodies, forces=forces)


def _slider(d: Draw, seed: int, period: float) -> Case:
    """A body on a rail with friction, and often a spring."""
    rail = {"type": "slider", "body": "body", "axis": [1, 0, 0]}
    return _rubbing(d, seed, period, {"rail": rail}, "force", "surge")


def _hinge(d: Draw, seed: int, period: float) -> Case:
    """A body on an upright hinge with friction and a spring."""
    pin = {"type": "hinge", "body": "body", "axis": [0, 0, 1]}
    return _rubbing(d, seed, period, {"pin": pin}, "moment", "yaw")


def _rubbing(d: Draw, seed: int, period: float, joints: Case, load: str, dof: str) -> Case:
    """A body on one of ``joints`` with friction, and a push along it."""
    mass = _mass(d)
    static = rounded(mass * d.order(0.1, 5.0))
    friction = {"law": "coulomb", f"static_{load}": static}
    friction[f"kinetic_{load}"] = rounded(static * d.between(0.2, 1.0))
    (joint,) = joints.values()
    joint["friction"] = friction
    if joint["type"] == "hinge" or d.chance(0.5):
        joint["stiffness"] = rounded(mass * (0.3 * 2.0 * pi / period) ** 2)
    forces = {"push": _push(d, dof, _beyond(d) * static, period)}
    parts: Case = {"bodies": {"body": _body(mass)}, "joints": joints, "forces": forces}
    return long_case(d, seed, 2.0 * pi / period, long_duration(d), **parts)


def _clamp(d: Draw, seed: int, period: float) -> Case:
    """A body that a joint holds until it breaks, and a mooring that is left."""
    mass = _mass(d)
    size = rounded(mass * d.order(0.1, 3.0))
    clamp = {"type": "fixed", "body": "body", "breaks_at": rounded(size / _beyond(d))}
    slow = 0.4 * 2.0 * pi / period
    forces = {"push": _push(d, "surge", size, period), "spring": _spring(mass, slow)}
    bodies = {"body": _body(mass, ["surge", "sway"])}
    parts: Case = {"bodies": bodies, "joints": {"clamp": clamp}, "forces": forces}
    return long_case(d, seed, 2.0 * pi / period, long_duration(d), **parts)


def _wire(d: Draw, mass: float, period: float, swing: float) -> tuple[Case, float]:
    """A stiff damped wire along x, and the peak of a push that swings it by ``swing`` [N]."""
    omega = 2.0 * pi / period
    stiffness = mass * (STIFF * omega) ** 2
    length = d.between(10.0, 50.0)
    keys: Case = {"body": "body", "point": [0, 0, 0], "length": length}
    peak = swing * abs(1.0 - 1.0 / STIFF**2)
    return {**keys, "stiffness": rounded(stiffness)}, peak


def _damper(mass: float, period: float) -> Case:
    damping = rounded(0.3 * mass * STIFF * 2.0 * pi / period)
    return {"type": "linear_damping", "body": "body", "damping": {"surge": damping}}


def _drum(d: Draw, seed: int, period: float) -> Case:
    """A winch that keeps a tension, against a constant pull: its drum is stuck, but for peaks."""
    mass = _mass(d)
    tension = rounded(mass * d.order(0.3, 5.0))
    out = d.between(0.05, 0.4)
    wire, peak = _wire(d, mass, period, _beyond(d) * out * tension)
    length, EA = wire["length"], wire["stiffness"] * wire["length"]
    reach = rounded(length * (1.0 + tension / EA))
    drive: Case = {"tension": tension, "speed": 1.0, "friction": {"in": out, "out": out}}
    drum = {"shortest": rounded(0.1 * length), "longest": rounded(3.0 * length)}
    winch = {**wire, "type": "winch", "stiffness": rounded(EA), "anchor": [reach, 0, 0], **drive}
    harmonic = {"amplitude": rounded(peak), "period": period, "mean": -tension}
    pull = {"type": "applied_force", "body": "body", "force": {"surge": harmonic}}
    forces = {"winch": {**winch, "drum": drum}, "pull": pull, "damper": _damper(mass, period)}
    rate = STIFF * 2.0 * pi / period
    bodies = {"body": _body(mass, ["surge"])}
    return long_case(d, seed, rate, long_duration(d), bodies=bodies, forces=forces)


def _rope(d: Draw, seed: int, period: float) -> Case:
    """A stiff rope that breaks, and a mooring that is left."""
    mass = _mass(d)
    mean = rounded(mass * d.order(0.3, 3.0))
    swing = mean * d.between(0.2, 0.8)
    wire, peak = _wire(d, mass, period, swing)
    stretch = mean / wire["stiffness"]
    rope = {**wire, "type": "spring", "anchor": [rounded(wire["length"] + stretch), 0, 0]}
    rope["breaks_at"] = rounded((mean + swing) / _beyond(d))
    harmonic = {"amplitude": rounded(peak), "period": period, "mean": -mean}
    pull = {"type": "applied_force", "body": "body", "force": {"surge": harmonic}}
    spring = _spring(mass, sqrt(0.1) * 2.0 * pi / period)
    forces = {"rope": rope, "pull": pull, "spring": spring, "damper": _damper(mass, period)}
    rate = STIFF * 2.0 * pi / period
    bodies = {"body": _body(mass, ["surge"])}
    return long_case(d, seed, rate, long_duration(d), bodies=bodies, forces=forces)
