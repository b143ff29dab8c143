"""Random operations: a topside lands on a barge, or is lifted off it, while water is pumped.

A case is drawn from its seed alone. It mixes tanks and pumps, draughts of a family of databases,
landings with or without loops, currents, wind and two bodies. Sizes go together as those of
`random_cases` do. Some steps are too large on purpose.
"""

from math import cos, hypot, sin, sqrt
from typing import NamedTuple

from tests.generators.random_cases import DATABASES, FINE, GRAVITY, STEPS, Case, Draw, rounded
from tests.generators.random_links import LINKED_FROM, Course, draw_link

HEADINGS = ["0 deg", "45 deg", "90 deg", "135 deg", "180 deg"]
WATER = 1025.0
WALL = 0.5  # m between a tank and the hull
FAMILY = ((12.4, "h851.nc"), (11.3, "h851_11m3.nc"), (10.2, "h851_10m2.nc"))
MESH = "hull.stl"
UNSUITED = (0.1, 0.05, 0.02)  # s: steps that are taken whatever the rates are


class Barge(NamedTuple):
    """Dimensions [m] and mass [kg] of a hull; the deck is at ``top`` over the waterline."""

    length: float
    beam: float
    draught: float
    top: float
    mass: float


def mixed_case(seed: int) -> Case:
    """The case of a seed, as a case file holds it. A box barge wants `mesh_of` it beside."""
    draw = Draw(seed)
    family = draw.chance(0.15)
    barge = _launch_barge() if family else _box_barge(draw)
    heading = draw.between(-3.0, 3.0) if draw.chance(0.4) and not family else 0.0
    at_rest = draw.chance(0.15)
    bodies = {"barge": _hull(draw, barge, family), "topside": {}}
    forces: Case = {}
    centre = bodies["barge"]["centre_of_gravity"][2]
    up = 0.0 if at_rest else draw.one((0.0, draw.between(0.0, 0.3)), 60, 40)
    topside = _topside(draw, barge, centre, up, forces)
    bodies["topside"] = topside.body
    for body in bodies.values():
        if heading:
            body["heading"] = heading
    if not at_rest:
        offsets = [draw.between(-0.2, 0.2) for _ in range(3)]
        angles = [draw.between(-0.005, 0.005) for _ in range(2)]
        sunk = (
            topside.body["mass"] / (WATER * barge.length * barge.beam) if draw.chance(0.7) else 0.0
        )
        offsets[2] = rounded(0.3 * offsets[2] - sunk)
        bodies["barge"]["initial"] = {"position": [*offsets, *angles, 0.0]}
        place = [offsets[0], offsets[1], rounded(-sunk), 0.0, 0.0, 0.0]
        topside.body["initial"] = {"position": place}
    environment = _surroundings(draw, barge, forces, family)
    _hold(draw, barge, forces)
    duration = draw.between(10.0, 30.0)
    _lift(draw, topside.body["mass"], duration, forces)
    rate = topside.rate
    if seed >= LINKED_FROM:
        rate = max(rate, _link(draw, bodies, forces))
    case: Case = {"title": f"mixed case {seed}", "duration": float(round(duration))}
    case |= {"environment": environment, "bodies": bodies, "forces": forces}
    case |= {"solver": _solver(draw, rate), "output": {"step": 0.5}}
    if at_rest:
        case["initial"] = "at_rest"
    return case


def mesh_of(seed: int) -> str | None:
    """The hull of a case as text of an STL file, if it is a box."""
    draw = Draw(seed)
    if draw.chance(0.15):
        return None
    barge = _box_barge(draw)
    x = barge.length / 2
    y = barge.beam / 2
    low = -barge.draught
    top = barge.top
    corners = [(a * x, b * y, low) for a in (-1, 1) for b in (-1, 1)]
    corners = [(x, y, z) for x, y, low in corners for z in (low, top)]
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    lines = ["solid hull"]
    for a, b, c, d in faces:
        for triangle in ((a, b, c), (a, c, d)):
            lines += ["facet normal 0 0 0", "outer loop"]
            lines += ["vertex {:.6g} {:.6g} {:.6g}".format(*corners[i]) for i in triangle]
            lines += ["endloop", "endfacet"]
    return "\n".join([*lines, "endsolid hull", ""])


def _box_barge(d: Draw) -> Barge:
    length = d.between(70.0, 150.0)
    beam = rounded(length * d.between(0.16, 0.3))
    draught = d.between(4.0, 8.0)
    top = d.between(4.0, 7.0)
    return Barge(length, beam, draught, top, rounded(WATER * length * beam * draught))


def _launch_barge() -> Barge:
    return Barge(260.0, 63.0, 12.4, 2.6, 1.56758e8)


def _hull(d: Draw, barge: Barge, family: bool) -> Case:
    mass = barge.mass
    body: Case = {"weight": "carried", "mass": mass, "location": [0.0, 0.0]}
    if family:
        files = [(draught, str(DATABASES / name)) for draught, name in FAMILY]
        body["hydrodynamics"] = [{"draught": draught, "file": file} for draught, file in files]
        body["hydrostatics"] = {"recipe": str(DATABASES / "h851.yaml"), "depth": 15.0}
        body["centre_of_gravity"] = [0.0, 0.0, -4.9]
        body["radii_of_gyration"] = [22.05, 67.6, 68.9]
        body["wave_forces"] = {"second_order": "none"}
    else:
        body |= _box_coefficients(d, barge)
    _tanks(d, barge, body, family)
    return body


def _box_coefficients(d: Draw, barge: Barge) -> Case:
    mass = barge.mass
    heave = rounded(mass * d.between(0.8, 1.3))
    roll = rounded(mass * barge.beam**2 * d.between(0.05, 0.1))
    pitch = rounded(heave * barge.length**2 / 14.0)
    return {
        "hydrodynamics": {
            "added_mass": {
                "surge": rounded(0.05 * mass),
                "sway": rounded(0.5 * mass),
                "heave": heave,
                "roll": roll,
                "pitch": pitch,
                "yaw": rounded(0.5 * pitch),
            },
            "damping": {
                "sway": rounded(0.05 * mass),
                "heave": rounded(0.3 * mass),
                "roll": rounded(0.05 * roll),
                "pitch": rounded(0.3 * pitch),
            },
        },
        "hydrostatics": {"mesh": MESH},
        "centre_of_gravity": [0.0, 0.0, d.between(-2.5, 0.5)],
        "radii_of_gyration": [
            rounded(0.35 * barge.beam),
            rounded(0.26 * barge.length),
            rounded(0.26 * barge.length),
        ],
    }


def _tanks(d: Draw, barge: Barge, body: Case, family: bool) -> None:
    """None to two tanks side by side or one before the other, and a pump."""
    count = 2 if family else d.one((0, 1, 2), 20, 30, 50)
    if not count:
        return
    x = 0.39 * barge.length if not family else 70.0
    y = 0.4 * barge.beam
    low = -barge.draught + WALL
    height = min(barge.top - WALL, 0.8 * barge.top) - low
    tanks: Case = {}
    for i in range(count):
        side = -1 if i == 0 else 1
        near = sorted((0.02 * x * side, x * side))
        box = [[near[0], -y, low], [near[1], rounded(y * d.one((1.0, 0.4, -0.05))), low + height]]
        box = [[rounded(value) for value in corner] for corner in box]
        level = rounded(height * d.one((0.0, d.between(0.05, 0.9), 0.5), 10, 70, 20))
        tanks[f"t{i}"] = {"box": box, "level": level, "density": WATER}
        if d.chance(0.3):
            tanks[f"t{i}"]["permeability"] = d.between(0.6, 0.98)
    if count == 2 and d.chance(0.6):
        rate = rounded(barge.mass / WATER * d.order(0.0003, 0.003))
        start = d.between(0.0, 15.0)
        body["pumps"] = {"p0": {"source": "t0", "target": "t1", "rate": rate, "start": start}}
    body["tanks"] = tanks


class Topside(NamedTuple):
    """The body of it, and the fastest rate [rad/s] of its supports."""

    body: Case
    rate: float


def _topside(d: Draw, barge: Barge, centre: float, up: float, forces: Case) -> Topside:
    mass = rounded(barge.mass * d.order(0.01, 0.12))
    x = rounded(0.5 * barge.length * d.between(0.15, 0.3))
    y = rounded(0.5 * barge.beam * d.between(0.4, 0.6))
    height = rounded(y * d.between(0.6, 1.0))
    half = rounded(height / 2)
    radii = [rounded(r) for r in (0.6 * hypot(y, half), 0.6 * hypot(x, half))]
    at = [0.0, 0.0, rounded(barge.top + half + up)]
    body: Case = {"mass": mass, "weight": "carried", "centre_of_gravity": at}
    body["location"] = [0.0, 0.0]
    body["radii_of_gyration"] = [*radii, rounded(0.6 * hypot(x, y))]
    points = [[a * x, b * y, -half] for a in (1, -1) for b in (1, -1)]
    seat = rounded(barge.top - centre)
    seats = [[a * x, b * y, seat] for a in (1, -1) for b in (1, -1)]
    normal, stiffness = _supports(d, mass)
    friction = _friction(d, mass, stiffness)
    landing: Case = {"type": "landing", "body": "topside", "points": points}
    landing |= {"on": {"body": "barge", "points": seats}, "normal": normal, "friction": friction}
    if d.chance(0.5):
        gap = d.between(0.1, 0.4)
        wall = rounded(mass * d.order(10.0, 120.0))
        landing["wall"] = {"gap": gap, "stiffness": wall, "depth": rounded(1.0 + 3 * gap)}
    forces["deck"] = landing
    steepest = max(stiffness, friction.get("stiffness", 0.0))
    return Topside(body, 2.0 * sqrt(4.0 * steepest / mass))


def _supports(d: Draw, mass: float) -> tuple[Case, float]:
    """The law of a support, with a loop or without, and its steepest stiffness [N/m]."""
    load = mass * GRAVITY / 4
    deep = d.order(0.03, 0.4)
    force = rounded(load * d.between(1.0, 4.0))
    loading = force / deep
    normal: Case = {"compression": [0.0, deep], "force": [0.0, force]}
    if d.chance(0.25):
        return normal, loading
    back = rounded(force * d.between(0.6, 0.98))
    steep = rounded(loading * d.order(3.0, 45.0))
    normal["unloading"] = {"compression": [0.0, deep], "force": [0.0, back], "stiffness": steep}
    return normal, steep


def _friction(d: Draw, mass: float, stiffness: float) -> Case:
    law = d.one(("none", "stick_slip", "rate_free", "friction_slope"), 25, 40, 25, 10)
    kinetic = d.between(0.05, 0.4)
    static = rounded(kinetic * d.between(1.0, 1.8))
    if law == "none":
        return {"law": "none"}
    if law == "friction_slope":
        slope = rounded(kinetic * mass * GRAVITY / 4 / d.order(0.01, 0.2))
        return {"law": law, "coefficient": kinetic, "slope": slope}
    side = rounded(stiffness * d.order(0.05, 1.0))
    keys: Case = {"law": "stick_slip", "static": static, "kinetic": kinetic, "stiffness": side}
    if law == "stick_slip":
        keys["damping"] = rounded(d.between(0.03, 0.3) * 2.0 * sqrt(side * mass / 4))
    return keys


def _surroundings(d: Draw, barge: Barge, forces: Case, family: bool) -> Case:
    """Streams and their loads. A family lies in still water, since the program refuses a current
    there; it is drawn all the same, so that what follows is what it would be with it."""
    environment: Case = {"water_depth": "infinite", "water_density": WATER}
    for stream, chance, density, low, high, height in (
        ("current", 0.7, WATER, 0.2, 1.8, barge.draught),
        ("wind", 0.3, 1.2, 4.0, 20.0, barge.top),
    ):
        if not d.chance(chance):
            continue
        blows = {"speed": d.between(low, high), "heading": d.between(-3.1, 3.1)}
        along = rounded(0.5 * density * d.between(0.4, 1.1) * barge.beam * height)
        if family and stream == "current":
            continue
        environment[stream] = blows
        across = rounded(along * barge.length / barge.beam)
        yaw = rounded(0.05 * across * barge.length)
        forces[stream] = {
            "type": f"{stream}_load",
            "body": "barge",
            "headings": HEADINGS,
            "surge": [along, rounded(0.7 * along), 0.0, rounded(-0.7 * along), -along],
            "sway": [0.0, rounded(0.5 * across), across, rounded(0.5 * across), 0.0],
            "yaw": [0.0, yaw, 0.0, -yaw, 0.0],
        }
    return environment


def _hold(d: Draw, barge: Barge, forces: Case) -> None:
    """A mooring, damping of roll, and a push in place of waves."""
    stiffness = rounded(barge.mass * d.order(0.008, 0.04))
    yaw = rounded(stiffness * barge.length**2 / 25.0)
    held = {"surge": stiffness, "sway": stiffness, "yaw": yaw}
    mooring = {"type": "linear_mooring", "body": "barge", "stiffness": held}
    forces["mooring"] = {**mooring, "damping_ratio": {"surge": 0.1, "sway": 0.1}}
    ratio = {"roll": d.between(0.02, 0.08)}
    forces["damping"] = {"type": "linear_damping", "body": "barge", "damping_ratio": ratio}
    periods = (d.between(7.0, 15.0), d.between(7.0, 15.0), d.between(6.0, 12.0))
    push = {}
    for dof, size, period in zip(("surge", "sway", "heave"), (0.6, 1.0, 1.0), periods, strict=True):
        amplitude = rounded(barge.mass * size * d.order(0.02, 0.09))
        push[dof] = {"amplitude": amplitude, "period": period}
    point = [rounded(0.2 * barge.length), rounded(0.2 * barge.beam), 0.0]
    forces["push"] = {"type": "applied_force", "body": "barge", "point": point, "force": push}


def _lift(d: Draw, mass: float, duration: float, forces: Case) -> None:
    """A winch, and a lift that takes a part of the weight or more of it than there is."""
    if d.chance(0.5):
        tilt = d.between(-0.2, 0.2)
        length = d.between(40.0, 70.0)
        stretched = rounded(length * d.between(1.0, 1.06))
        anchor = [rounded(stretched * sin(tilt)), 0.0, rounded(15.0 + stretched * cos(tilt))]
        winch = {"type": "spring", "body": "topside", "point": [0.0, 0.0, 3.0], "anchor": anchor}
        stiffness = rounded(mass * d.order(0.02, 0.2))
        forces["winch"] = {**winch, "length": length, "stiffness": stiffness}
    weight = mass * GRAVITY
    if d.chance(0.7):
        parts = [0.0, d.between(0.0, 0.4), d.between(0.3, 0.7), d.between(0.0, 0.5)]
        times = [0.0, rounded(0.25 * duration), rounded(0.7 * duration), rounded(duration)]
        heave = [rounded(part * weight) for part in parts]
        lift: Case = {"type": "applied_force", "body": "topside"}
        forces["lift"] = {**lift, "time": times, "force": {"heave": heave}}


def _link(d: Draw, bodies: Case, forces: Case) -> float:
    """Links of topside and barge, level and about the vertical; their fastest rate [rad/s]."""
    mass = bodies["topside"]["mass"]
    up = bodies["topside"]["centre_of_gravity"][2] - bodies["barge"]["centre_of_gravity"][2]
    rates = [0.0]
    for axis in ([1.0, 0.0], [0.0, 1.0]):
        if not d.chance(0.5):
            continue
        reach = d.between(5.0, 15.0)
        link = draw_link(d, Course(reach, 0.5, mass, distance=True))
        rates.append(link.rate)
        ends = {"point": [0.0, 0.0, 0.0], "anchor": [reach * axis[0], reach * axis[1], rounded(up)]}
        ends = {"type": link.kind, "body": "topside", **ends, "anchor_body": "barge"}
        forces[f"link_{len(rates)}"] = {**ends, **link.keys}
    if d.chance(0.5):
        size = bodies["topside"]["radii_of_gyration"][2]
        link = draw_link(d, Course(0.0, 0.05, mass * size**2))
        rates.append(link.rate)
        twist = {"body": "topside", "axis": [0, 0, 1], "to": "barge"}
        forces["twist"] = {"type": link.kind, **twist, **link.keys}
    return max(rates)


def _solver(d: Draw, rate: float) -> Case:
    method = d.one(("rk4", "dopri5", "esdirk4", "rk2"), 45, 35, 12, 8)
    wanted = FINE[method] * d.order(0.06, 0.5) / rate
    step = next((h for h in STEPS if h <= wanted), STEPS[-1])
    if d.chance(0.25):
        step = d.one(UNSUITED)
    return {"method": method, "step": step}
