"""Random moored cases: 1 to 3 bodies, wet or dry, on 2 to 8 lines of all kinds.

A case is drawn from its seed alone, and can be turned as a whole about the vertical. Sizes go
together as those of `random_cases` do, and so do hulls, waves and methods. Floats with coefficients
lie in shallow water, whose seabed their chains touch. Loads hang from a crane on the earth or on a
hull. Some lines begin slack, some part, and some steps are too large.
"""

from itertools import pairwise
from math import pi, sqrt

from hydrosim.dofs import DOFS
from tests.generators.moored_lines import (
    CONTROLS,
    Ends,
    above,
    add_line,
    add_spread,
    add_winch,
    between,
    depth_of,
)
from tests.generators.random_cases import (
    ASTRAY,
    GRAVITY,
    Case,
    Draw,
    Form,
    Place,
    Sketch,
    float_hulls,
    rounded,
    with_solver,
)
from tests.generators.random_elements import add_sea, add_stream_load
from tests.generators.turned_cases import turned_case


def moored_case(seed: int, turn: float = 0.0) -> Case:
    """The case of a seed, as a case file holds it, turned about the vertical by ``turn`` [rad]."""
    d = Draw(seed)
    s = Sketch(d, astray=seed % ASTRAY == 0)
    joints: Case = {}
    d.one((_with_hulls, _with_floats, _with_loads), 45, 30, 25)(s, joints)
    _add_streams(s)
    for name, form in ((form.name, form) for form in s.forms):
        length, beam = form.half
        mast = [0.0, rounded(0.1 * beam), rounded(max(form.top, length))]
        s.bodies[name]["points"] = {"bow": [length, 0.0, 0.0], "mast": mast}
    case = with_solver(s, seed)
    case["title"] = f"moored case {seed}"
    if joints:
        case["joints"] = joints
    if s.yaw or d.chance(0.7):  # small angles suit few of them
        case["solver"].pop("kinematics", None)
    if d.chance(0.15):
        case["initial"] = "at_rest"
    return turned_case(case, turn)


def _with_hulls(s: Sketch, joints: Case) -> None:
    """Hulls of the databases, perhaps with a load over the side or a boom."""
    d = s.draw
    float_hulls(s, beams_apart=d.between(2.2, 4.0))
    for body in s.bodies.values():
        if body.pop("dofs", None):  # those of the earth's axes would not turn
            body.pop("initial", None)
        body["wave_forces"] |= {"headings": "slow", "position": "slow"}
        if "database_body" in body:
            body["radiation"] = "automatic"
    hulls = list(s.forms)
    _moor(s, hulls)
    if len(hulls) < 3 and d.chance(0.35):
        _hang_over_side(s, hulls[0])
    elif len(hulls) < 3 and d.chance(0.25):
        _add_boom(s, joints, hulls[0])
    add_sea(s)
    for form in hulls:
        _damp(s, form, form.mass * (0.4 * form.half[1] * 2.0) ** 2)


def _with_floats(s: Sketch, joints: Case) -> None:
    """Floats with coefficients, in water that is not deep."""
    d = s.draw
    s.yaw = d.between(-pi, pi) if d.chance(0.5) else 0.0
    mass = d.order(3e4, 3e7)
    y = 0.0
    for k in range(d.one((1, 2, 3), 60, 28, 12)):
        own = rounded(mass * d.order(0.3, 1.5))
        form = _float(s, f"float{k + 1}", own, y)
        y += 3.0 * form.half[1] + d.between(2.0, 10.0)
    size = max(form.half[0] for form in s.forms)
    s.environment["water_depth"] = rounded(size * d.order(1.0, 10.0) + 10.0)
    floats = list(s.forms)
    _moor(s, floats)
    if len(floats) < 3 and d.chance(0.25):
        _add_boom(s, joints, floats[0])
    for form in floats:
        _damp(s, form, form.mass * (0.7 * form.half[1]) ** 2)


def _float(s: Sketch, name: str, mass: float, y: float) -> Form:
    d = s.draw
    length = (mass / 1025.0 / 0.03) ** (1.0 / 3.0)
    half = (rounded(0.5 * length), rounded(0.15 * length))
    draught = rounded(mass / 1025.0 / (0.3 * length * length))
    heave = rounded(1025.0 * GRAVITY * 0.3 * length * length)
    form = Form(name, mass, half, -draught, draught, (0.0, y, 0.0), heave)
    radii = (0.7 * half[1], 0.5 * half[0], 0.5 * half[0])
    inertia = [mass * r * r for r in radii]
    added = [mass * d.between(*x) for x in ((0.03, 0.2), (0.3, 1.0), (0.7, 1.5))]
    added += [x * d.between(0.1, 0.5) for x in inertia]
    rate = sqrt(heave / (mass + added[2]))
    stiff = {"heave": heave, "roll": inertia[0] * d.between(0.5, 1.5) ** 2}
    stiff["pitch"] = heave * (0.58 * half[0]) ** 2
    s.rates.append(1.5 * rate)
    damping = [m * rate * d.order(0.01, 0.2) for m in (mass, mass, mass, *inertia)]
    body: Case = {"mass": mass, "centre_of_gravity": [0.0, 0.0, 0.0]}
    body |= {"location": list(s.turned(0.0, y)), "radii_of_gyration": [rounded(r) for r in radii]}
    water = {"added_mass": _by_dof(added), "damping": _by_dof(damping)}
    water["stiffness"] = {dof: rounded(x) for dof, x in stiff.items()}
    body["hydrodynamics"] = water
    offsets = [rounded(0.02 * length * d.between(-1.0, 1.0)) for _ in range(3)]
    angles = [d.between(-0.03, 0.03) for _ in range(2)]
    s.head(body, [*offsets, *angles] if d.chance(0.7) else [0.0] * 5)
    s.bodies[name] = body
    s.forms.append(form)
    return form


def _by_dof(values: list[float]) -> Case:
    return {dof: rounded(x) for dof, x in zip(DOFS, values, strict=True)}


def _moor(s: Sketch, forms: list[Form]) -> None:
    """Lines from bodies to anchors, and between the bodies."""
    d = s.draw
    most = d.one((2, 3, 4, 6, 8), 15, 15, 30, 20, 20)
    for form in forms:
        period = d.between(25.0, 120.0) * (form.mass / 1e8) ** 0.15
        stiffness = 1.1 * form.mass * (2.0 * pi / period) ** 2
        count = max(2, most // len(forms))
        add_spread(s, form, count, 2.0 * stiffness / count)
        if d.chance(0.4):
            soft = rounded(0.1 * stiffness)
            s.add("linear_mooring", form.name, stiffness={"surge": soft, "sway": soft})
    for one, other in pairwise(forms):
        if d.chance(0.7):
            _tie(s, one, other)


def _tie(s: Sketch, one: Form, other: Form) -> None:
    """Lines between two bodies side by side."""
    d = s.draw
    mass = min(one.mass, other.mass)
    stiffness = mass * (2.0 * pi / d.between(8.0, 30.0)) ** 2
    for x in (-0.6, 0.6):
        near = [rounded(x * one.half[0]), 0.0, one.top]
        far = [rounded(x * other.half[0]), 0.0, other.top]
        kind = d.one(("taut", "rope", "winch"))
        add_line(s, kind, between(one, near, other, far), stiffness)


def _with_loads(s: Sketch, joints: Case) -> None:
    """Dry loads that hang from the earth or from one another, with lines that steady them."""
    d = s.draw
    s.yaw = d.between(-pi, pi) if d.chance(0.4) else 0.0
    mass = d.order(1e3, 1e6)
    x = 0.0
    for k in range(d.one((1, 2, 3), 50, 30, 20)):
        own = rounded(mass * d.order(0.4, 1.5))
        before = s.forms[-1] if s.forms else None
        if before is not None and d.chance(0.3):
            below = before.at[2] + before.bottom - 0.5 * _size(own) - d.order(1.0, 10.0)
            form = _load(s, f"load{k + 1}", own, (before.at[0], 0.0, rounded(below)))
            top = between(form, [0.0, 0.0, form.top], before, [0.0, 0.0, before.bottom])
        else:
            form = _load(s, f"load{k + 1}", own, (rounded(x), 0.0, d.between(2.0, 10.0)))
            top = above(s, form, d.order(3.0, 40.0))
        x += 4.0 * _size(own)
        _hoist(s, top, own)
        if d.chance(0.85):
            _steady(s, form)
    if not s.bodies or s.units < 2:
        _steady(s, s.forms[0])
    if d.chance(0.15) and len(s.forms) < 3:
        _add_boom(s, joints, s.forms[0])


def _size(mass: float) -> float:
    return float((mass / 500.0) ** (1.0 / 3.0))


def _load(s: Sketch, name: str, mass: float, at: Place) -> Form:
    d = s.draw
    size = _size(mass)
    half = (rounded(0.6 * size), rounded(0.5 * size))
    up = rounded(0.4 * size)
    body: Case = {"mass": mass, "centre_of_gravity": [0.0, 0.0, at[2]]}
    body |= {"location": list(s.turned(at[0], at[1]))}
    body |= {"radii_of_gyration": [rounded(r * size) for r in (0.38, 0.42, 0.45)]}
    body["weight"] = "carried"
    offsets = [rounded(0.05 * size * d.between(-1.0, 1.0)) for _ in range(3)]
    s.head(body, [*offsets, 0.0, 0.0] if d.chance(0.5) else [0.0] * 5)
    s.bodies[name] = body
    form = Form(name, mass, half, -up, up, at)
    s.forms.append(form)
    s.rates.append(2.0 * sqrt(GRAVITY / size))
    return form


def _hoist(s: Sketch, ends: Ends, mass: float) -> None:
    """What carries a load: a winch of any control, a spring, or a heavy line."""
    d = s.draw
    s.units += 1
    weight = mass * GRAVITY
    stiffness = weight / (d.order(2e-3, 2e-2) * ends.chord)
    rate = sqrt(stiffness / mass)
    s.rates.append(1.5 * rate)
    kind = d.one(("winch", "spring", "catenary"), 60, 20, 20)
    if kind == "winch":
        add_winch(s, ends, stiffness, weight, d.one(CONTROLS))
        next(reversed(s.forces.values())).pop("active", None)  # it must not fall
        return
    EA = stiffness * ends.chord
    length = rounded(ends.chord / (1.0 + weight / EA))
    keys: Case = {"point": ends.point, **ends.keys}
    if kind == "spring":
        keys |= {"length": length, "stiffness": rounded(stiffness)}
        s.add(kind, ends.form.name, **keys, damping=rounded(0.05 * mass * rate))
        return
    line = {"length": length, "weight": rounded(0.02 * weight / length), "stiffness": rounded(EA)}
    s.add(kind, ends.form.name, **keys, segments=[line])


def _steady(s: Sketch, form: Form) -> None:
    """Two lines at the sides of a load, to the earth."""
    d = s.draw
    stiffness = form.mass * d.order(0.5, 3.0) ** 2
    for x in (-1.0, 1.0):
        point = [rounded(x * form.half[0]), 0.0, 0.0]
        reach = form.half[0] * d.order(3.0, 15.0)
        away = (x * reach, reach * d.between(-0.5, 0.5), reach * d.between(-0.2, 0.2))
        end = s.turned(form.at[0] + point[0] + away[0], form.at[1] + away[1])
        keys = {"anchor": [*end, rounded(form.at[2] + away[2])]}
        kind = d.one(("taut", "rope", "winch"), 25, 20, 55)
        add_line(s, kind, Ends(form, point, away, keys), stiffness)


def _hang_over_side(s: Sketch, hull: Form) -> None:
    """A load that hangs from a crane on a hull, with two tuggers."""
    d = s.draw
    mass = rounded(hull.mass * d.order(0.0005, 0.01))
    side = -1.0 if len(s.forms) > 1 else d.one((1.0, -1.0))
    aside = rounded(side * (hull.half[1] + 2.0 * _size(mass)))
    z = rounded(hull.at[2] + hull.top + d.between(3.0, 10.0))
    form = _load(s, "load", mass, (hull.at[0], rounded(hull.at[1] + aside), z))
    crane = [0.0, aside, rounded(z - hull.at[2] + d.between(5.0, 30.0))]
    _hoist(s, between(form, [0.0, 0.0, form.top], hull, crane), mass)
    stiffness = mass * d.order(0.3, 1.5) ** 2
    for x in (-1.0, 1.0):
        point = [rounded(x * form.half[0]), 0.0, 0.0]
        far = [rounded(x * 0.3 * hull.half[0]), rounded(side * 0.8 * hull.half[1]), hull.top]
        add_line(s, d.one(("winch", "rope"), 70, 30), between(form, point, hull, far), stiffness)


def _add_boom(s: Sketch, joints: Case, hull: Form) -> None:
    """A boom on a joint, with a line from its tip to the body that carries it."""
    d = s.draw
    mass = rounded(0.01 * hull.mass)
    length = rounded(0.6 * hull.half[0])
    z = rounded(hull.at[2] + hull.top)
    form = Form("boom", mass, (length, 1.0), -0.5, 0.5, (rounded(hull.at[0]), hull.at[1], z))
    body: Case = {"mass": mass, "centre_of_gravity": [0.0, 0.0, z]}
    body |= {"location": list(s.turned(form.at[0], form.at[1]))}
    body |= {"radii_of_gyration": [rounded(r * length) for r in (0.2, 0.5, 0.5)]}
    s.head(body, [0.0] * 5)
    body.pop("initial", None)
    s.bodies["boom"] = body
    s.forms.append(form)
    inertia = mass * (1.2 * length) ** 2
    rate = d.order(1.0, 4.0)
    s.rates.append(2.0 * rate)
    kind = d.one(("hinge", "ball", "fixed"), 60, 20, 20)
    joint: Case = {"type": kind, "body": "boom", "to": hull.name, "point": [-length, 0.0, 0.0]}
    if kind == "hinge":
        joint |= {"axis": d.one(([0, 1, 0], [0, 0, 1])), "stiffness": rounded(inertia * rate**2)}
        joint["initial"] = {"angle": d.between(-0.1, 0.1)}
    joints["foot"] = joint
    tip = [length, 0.0, 0.0]
    far = [rounded(-0.8 * hull.half[0]), rounded(0.5 * hull.half[1]), hull.top]
    ends = between(form, tip, hull, far)
    add_line(s, d.one(("taut", "rope", "winch")), ends, 0.3 * mass * rate**2)


def _damp(s: Sketch, form: Form, inertia: float) -> None:
    """Roll damping of all sources, and drag relative to the current."""
    d = s.draw
    if "roll" not in s.bodies[form.name].get("dofs", DOFS):
        return
    box: Case = {"length": 2.0 * form.half[0], "beam": 2.0 * form.half[1]}
    box["draught"] = rounded(max(-form.bottom, 0.5))
    p: Case = {"p1": d.order(2e-3, 5e-2), "p2": d.order(0.05, 1.0), "p3": d.order(0.01, 0.5)}
    kinds: tuple[Case, ...] = (
        {**p, "includes_waves": False},
        {"p2": p["p2"], "includes_waves": False},
        {"ikeda": box},
        {"linear": rounded(0.02 * inertia), "quadratic": rounded(inertia * d.order(0.1, 2.0))},
        {"quadratic": rounded(inertia * d.order(0.1, 2.0)), "cubic": rounded(0.5 * inertia)},
        {},
    )
    chosen = d.one(kinds, 15, 10, 20, 10, 10, 35)
    if chosen:
        s.add("viscous_roll", form.name, **chosen)
    if d.chance(0.3):
        drag = rounded(0.5 * 1025.0 * 2.0 * form.half[0] * box["draught"] * d.order(0.3, 1.2))
        damping = {"sway": drag, "surge": rounded(0.1 * drag)}
        s.add("quadratic_damping", form.name, damping=damping)


def _add_streams(s: Sketch) -> None:
    """Current over the depth and wind with gusts, and their loads on bodies."""
    d = s.draw
    wet = [form for form in s.forms if form.afloat]
    if wet and d.chance(0.5):
        s.environment["current"] = _current(s)
        for form in wet:
            s.bodies[form.name]["draught"] = rounded(-form.at[2] - form.bottom)
            if form is wet[0] or d.chance(0.7):
                add_stream_load(s, form, "current", 1025.0)
    if d.chance(0.45):
        s.environment["wind"] = _wind(s)
        for form in s.forms:
            if form is s.forms[0] or d.chance(0.7):
                add_stream_load(s, form, "wind", 1.2)
                load = next(reversed(s.forces.values()))
                load["height"] = d.between(2.0, 30.0)


def _current(s: Sketch) -> Case:
    d = s.draw
    speed, heading = d.between(0.2, 1.5), d.between(-pi, pi)
    kind = d.one(("uniform", "table", "turning", "power"), 35, 25, 20, 20)
    if kind == "uniform":
        return {"speed": speed, "heading": heading}
    depth = min(depth_of(s), 100.0)
    if kind == "power":
        return {"speed": speed, "heading": heading, "profile": {"exponent": 0.143, "depth": depth}}
    depths = [0.0, rounded(0.3 * depth), depth]
    table: Case = {"depth": depths, "speed": [speed, rounded(0.7 * speed), rounded(0.3 * speed)]}
    if kind == "table":
        return {"heading": heading, "profile": table}
    table["heading"] = [heading, rounded(heading + 0.3), rounded(heading + d.between(-1.0, 1.0))]
    return {"profile": table}


def _wind(s: Sketch) -> Case:
    d = s.draw
    wind: Case = {"speed": d.between(5.0, 30.0), "heading": d.between(-pi, pi)}
    if d.chance(0.5):
        wind["profile"] = d.one(("npd", {"exponent": 0.11}))
    if d.chance(0.6):
        gusts: Case = {"spectrum": d.one(("npd", "api", "ochi_shin"))}
        gusts["seed"] = int(d.rng.integers(1, 100))
        if d.chance(0.3):
            gusts["ramp"] = d.between(2.0, 20.0)
        wind["gusts"] = gusts
    return wind
