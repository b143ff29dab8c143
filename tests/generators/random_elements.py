"""Fenders, lines, moorings, damping, loads, waves and streams of `random_cases`."""

from itertools import pairwise
from math import cos, hypot, pi, sin, sqrt
from typing import Any

from hydrosim.dofs import DOFS
from tests.generators.random_cases import GRAVITY, UNITS, Case, Form, Sketch, rounded
from tests.generators.random_links import Course, draw_link


def furnish(s: Sketch) -> None:
    """All that acts on the bodies of a sketch."""
    for i, form in enumerate(s.forms):
        if form.afloat:
            _moor(s, form)
        else:
            _support(s, i, form)
    _between_hulls(s)
    for form in s.forms:
        if form.afloat and s.draw.chance(0.45):
            _press(s, form)
        _push(s, form)
        _damp(s, form)
    if any(form.afloat for form in s.forms):
        add_sea(s)
    _streams(s)
    if s.linked:
        for form in s.forms:
            _link(s, form)


def _moor(s: Sketch, form: Form) -> None:
    """Springs at the centre, lines to anchors, or nothing."""
    d = s.draw
    kind = d.one(("linear", "lines", "none"), 55, 30, 15)
    period = d.between(25.0, 120.0) * (form.mass / 1e8) ** 0.15
    stiffness = rounded(1.1 * form.mass * (2.0 * pi / period) ** 2)
    if kind == "linear":
        dofs = ["surge", "sway"]
        keys: Case = {"stiffness": dict.fromkeys(dofs, stiffness)}
        if d.chance(0.5):
            keys["stiffness"]["yaw"] = rounded(stiffness * (0.25 * 2.0 * form.half[0]) ** 2)
            dofs.append("yaw")
        if d.chance(0.8):
            keys["damping_ratio"] = {dof: d.between(0.02, 0.3) for dof in dofs}
        s.add("linear_mooring", form.name, **keys)
    elif kind == "lines":
        for x in (-1.0, 1.0):
            for y in (-1.0, 1.0):
                _line(s, form, x, y, 0.5 * stiffness)


def _line(s: Sketch, form: Form, x: float, y: float, stiffness: float) -> None:
    """From a corner to an anchor off that corner, a little slack or taut."""
    d = s.draw
    if s.units >= UNITS:
        return
    s.units += 1
    point = (0.9 * x * form.half[0], 0.9 * y * form.half[1], form.top)
    reach = d.between(1.0, 3.0) * form.half[0]
    out = (point[0] + 0.8 * x * reach, point[1] + 0.6 * y * reach)
    fixed = s.turned(form.at[0] + out[0], form.at[1] + out[1])
    anchor = [*fixed, rounded(form.at[2] + point[2] - d.between(0.0, 0.3) * reach)]
    span = hypot(out[0] - point[0], out[1] - point[1], anchor[2] - form.at[2] - point[2])
    length = rounded(span * d.between(0.985, 1.005))
    keys: Case = {"point": [rounded(v) for v in point], "anchor": anchor, "length": length}
    if d.chance(0.5):
        keys["stiffness"] = rounded(stiffness)
    else:
        far = [0.0, 0.02 * span, 0.05 * span]
        bend = 0.6 * stiffness * far[1]
        tension = [0.0, bend, bend + stiffness * 0.03 * span]
        extension, tension = list(map(rounded, far)), list(map(rounded, tension))
        keys["curve"] = {"extension": extension, "tension": tension}
    if d.chance(0.4):
        keys["damping"] = rounded(d.between(0.02, 0.2) * sqrt(stiffness * form.mass))
    s.add("spring", form.name, **keys)


def _support(s: Sketch, i: int, form: Form) -> None:
    """What a dry block stands on: the floor, the body below it, or springs that hold it."""
    d = s.draw
    below = _below(s, i)
    weight = form.mass * GRAVITY
    count = d.one((1, 2, 3, 4), 25, 15, 15, 45)
    if (below is None and d.chance(0.12)) or s.units + count > UNITS:
        _hang(s, form, below)
        return
    sag = d.order(0.015, 0.2)
    stiffness = weight / sag
    points = _corners(form, count, form.bottom)
    if count < 3:  # it would topple
        dofs = s.bodies[form.name].get("dofs", DOFS)
        free = [dof for dof in dofs if dof not in ("roll", "pitch")]
        s.bodies[form.name]["dofs"] = free
    if below is None:
        slope = [d.between(-0.06, 0.06) if d.chance(0.3) else 0.0 for _ in range(2)]
        x, y = s.turned(form.at[0], form.at[1])
        plane: Case = {"point": [x, y, 0.0], "normal": [*slope, 1.0]}
    else:
        plane = {"body": below.name, "point": [0.0, 0.0, below.top], "normal": [0.0, 0.0, 1.0]}
    _fender(s, form, points, plane, stiffness, weight)


def _below(s: Sketch, i: int) -> Form | None:
    """The body whose deck this one stands on, as they were placed."""
    here = s.forms[i]
    for form in s.forms[:i]:
        level = abs(form.at[2] + form.top + here.bottom * -1.0 - here.at[2]) < 1e-3
        if level and abs(form.at[0] - here.at[0]) + abs(form.at[1] - here.at[1]) < 1e-3:
            return form
    return None


def _hang(s: Sketch, form: Form, below: Form | None) -> None:
    """Six springs to the earth, or a fixed deck's worth of them."""
    d = s.draw
    k = form.mass * d.between(1.0, 6.0) ** 2
    turning = k * (0.6 * form.half[0]) ** 2
    stiffness = {**dict.fromkeys(("surge", "sway", "heave"), k)}
    stiffness |= dict.fromkeys(("roll", "pitch", "yaw"), turning)
    keys: Case = {"stiffness": {dof: rounded(x) for dof, x in stiffness.items()}}
    if d.chance(0.7):
        keys["damping_ratio"] = dict.fromkeys(stiffness, d.between(0.01, 0.2))
    s.rates.append(sqrt(k / form.mass))
    s.add("linear_mooring", form.name, **keys)


def _corners(form: Form, count: int, z: float) -> list[list[float]]:
    """So many points at a level, in the middle or towards the corners."""
    x, y = (rounded(0.8 * half) for half in form.half)
    places = {
        1: [(0.0, 0.0)],
        2: [(x, 0.0), (-x, 0.0)],
        3: [(x, y), (x, -y), (-x, 0.0)],
        4: [(x, y), (x, -y), (-x, y), (-x, -y)],
    }[count]
    return [[*place, z] for place in places]


def _fender(
    s: Sketch, form: Form, points: list[list[float]], plane: Case, stiffness: float, load: float
) -> None:
    """Points with a normal curve of this ``stiffness`` altogether, and any friction."""
    d, n = s.draw, len(points)
    s.units += n
    rate = sqrt(stiffness / form.mass)
    s.rates.append(1.5 * rate)
    normal: Case = {"total": True}
    if d.chance(0.5):
        normal["stiffness"] = rounded(stiffness)
    else:
        sag = load / stiffness
        normal["compression"] = [0.0, rounded(sag), rounded(3.0 * sag)]
        steeper = d.between(1.0, 2.5)
        normal["force"] = [0.0, rounded(0.8 * load), rounded(load * (0.8 + 2.0 * steeper))]
        s.rates.append(1.5 * rate * sqrt(steeper))
    friction, damped = _friction(s, form, n, stiffness, load)
    if damped and d.chance(0.4):
        normal["damping"] = rounded(d.between(0.02, 0.4) * sqrt(stiffness * form.mass))
    s.add("fender", form.name, points=points, plane=plane, normal=normal, friction=friction)


def _friction(
    s: Sketch, form: Form, count: int, stiffness: float, load: float
) -> tuple[Case, bool]:
    """A law, and whether the normal may be damped."""
    d = s.draw
    laws = ("stick_slip", "friction_slope", "coulomb", "none")
    law = d.one(laws, 60, 15, 12 if count == 1 else 2, 12)
    kinetic = d.between(0.05, 0.5)
    static = rounded(kinetic * d.one((1.0, d.between(1.0, 2.0)), 30, 70))
    if law == "none":
        return {"law": "none"}, True
    if law == "coulomb":
        return {"law": law, "static": static, "kinetic": kinetic}, True
    if law == "friction_slope":
        slope = kinetic * load / d.order(0.01, 0.2)
        s.rates.append(slope / form.mass)
        return {"law": law, "coefficient": kinetic, "slope": rounded(slope), "total": True}, True
    return _stick_slip(s, form, static, kinetic, stiffness, load)


def _stick_slip(
    s: Sketch, form: Form, static: float, kinetic: float, stiffness: float, load: float
) -> tuple[Case, bool]:
    d = s.draw
    K2 = rounded(stiffness * d.order(0.2, 4.0))
    critical = 2.0 * sqrt(K2 * form.mass)
    s.rates.append(1.5 * sqrt(K2 / form.mass))
    keys: Case = {"law": "stick_slip", "static": static, "kinetic": kinetic, "stiffness": K2}
    rate_free = d.chance(0.25)
    if not rate_free:
        keys["damping"] = rounded(d.between(0.03, 0.3) * critical)
        if d.chance(0.5):
            keys["slip_damping"] = rounded(d.between(0.005, 0.1) * critical)
        s.rates.append(K2 / (keys["damping"] + keys.get("slip_damping", 0.0)))
        if d.chance(0.2):
            power = d.between(0.2, 0.8)
            keys["load"] = {"reference": rounded(load), "stiffness": power, "damping": power / 2}
    return {**keys, "total": True}, not rate_free


def _between_hulls(s: Sketch) -> None:
    """Fenders and perhaps lines between hulls that lie side by side."""
    d, hulls = s.draw, [form for form in s.forms if form.afloat]
    hulls = sorted(hulls, key=lambda form: form.at[1])
    for one, other in pairwise(hulls):
        count = d.one((1, 2, 3))
        if s.units + count + 2 > UNITS or d.chance(0.2):
            continue
        stiffness = one.mass * (2.0 * pi / d.between(4.0, 15.0)) ** 2
        x = 0.4 * one.half[0]
        points = [[rounded((j - (count - 1) / 2) * x), one.half[1], 0.5] for j in range(count)]
        gap = other.at[1] - one.at[1] - one.half[1] - other.half[1]
        face = -other.half[1] - gap * d.between(0.3, 1.02)
        plane = {"body": other.name, "point": [0.0, rounded(face), 0.0], "normal": [0.0, -1.0, 0.0]}
        _fender(s, one, points, plane, stiffness, 0.1 * stiffness)
        if d.chance(0.5):
            _ties(s, one, other, stiffness)


def _ties(s: Sketch, one: Form, other: Form, stiffness: float) -> None:
    """Two lines that pull hulls together."""
    d = s.draw
    for x in (-0.6, 0.6):
        s.units += 1
        point = [rounded(x * one.half[0]), one.half[1], one.top]
        anchor = [rounded(x * other.half[0] + 0.1 * one.half[0]), -other.half[1], other.top]
        apart = (anchor[0] - point[0], other.at[1] + anchor[1] - one.at[1] - point[1])
        length = rounded(hypot(*apart) * d.between(0.9, 1.0))
        tie = {"point": point, "anchor": anchor, "anchor_body": other.name, "length": length}
        s.add("spring", one.name, **tie, stiffness=rounded(0.1 * stiffness))


def _press(s: Sketch, form: Form) -> None:
    """A quay beside, or a fixed topside above, and a force that presses the hull to it."""
    d = s.draw
    count = d.one((1, 2, 3, 4))
    if s.units + count > UNITS:
        return
    end = d.between(10.0, 40.0)
    gap, deep = d.between(-0.02, 0.4), d.between(0.05, 0.4)
    if d.chance(0.5):
        stiffness = form.heave * d.order(0.5, 4.0)
        points = _corners(form, count, form.top)
        x, y = s.turned(form.at[0], form.at[1])
        plane = {"point": [x, y, rounded(form.at[2] + form.top + gap)], "normal": [0.0, 0.0, -1.0]}
        load = form.heave * (max(gap, 0.0) + deep)
        force: Case = {"heave": [0.0, rounded(load)]}
    else:
        stiffness = form.mass * (2.0 * pi / d.between(4.0, 15.0)) ** 2
        points = [[p[0], -form.half[1], 0.5] for p in _corners(form, min(count, 2), 0.0)]
        x, y = s.turned(form.at[0], form.at[1] - form.half[1] - gap)
        nx, ny = s.turned(0.0, 1.0)
        plane = {"point": [x, y, 0.0], "normal": [nx, ny, 0.0]}
        load = stiffness * deep
        fx, fy = s.turned(0.0, -0.3 * load)
        force = {"surge": [0.0, fx], "sway": [0.0, fy]}
    s.add("applied_force", form.name, time=[0.0, end], force=force)
    _fender(s, form, points, plane, stiffness, deep * stiffness)


def _link(s: Sketch, form: Form) -> None:
    """Links along a line to an anchor, and about an axis to the earth or another body."""
    d = s.draw
    if d.chance(0.4):
        reach = form.half[0] * d.between(1.0, 2.0)
        away = d.between(-pi, pi)
        x, y = s.turned(form.at[0] + reach * cos(away), form.at[1] + reach * sin(away))
        span = min(0.2 * reach, 1.0)
        link = draw_link(d, Course(reach, span, form.mass, distance=True))
        s.rates.append(link.rate)
        anchor = [x, y, form.at[2]]
        s.add(link.kind, form.name, point=[0.0, 0.0, 0.0], anchor=anchor, **link.keys)
    if d.chance(0.3):
        others = [other.name for other in s.forms if other is not form]
        to: Case = {"to": d.one(others)} if others and d.chance(0.5) else {}
        axis = d.one(([0, 0, 1], [0, 1, 0], [1, 0, 0]))
        link = draw_link(d, Course(0.0, 0.05, form.mass * form.half[0] ** 2))
        s.rates.append(link.rate)
        s.add(link.kind, form.name, axis=axis, **to, **link.keys)


def _push(s: Sketch, form: Form) -> None:
    """A force to and fro, or steps of it."""
    d = s.draw
    if not d.chance(0.3 if form.afloat else 0.75):
        return
    size = form.mass * (d.order(0.002, 0.03) if form.afloat else d.order(0.3, 2.5))
    force: Case = {}
    for dof in ("surge", "sway") if d.chance(0.4) else ("surge",):
        if d.chance(0.7):
            harmonic = {"amplitude": rounded(size), "period": d.order(2.0, 20.0)}
            if d.chance(0.3):
                harmonic["mean"] = rounded(d.between(-0.5, 0.5) * size)
            force[dof] = harmonic
        else:
            times = [0.0, d.between(1.0, 8.0), d.between(9.0, 20.0)]
            force[dof] = {"time": times, "force": [0.0, rounded(size), rounded(-0.5 * size)]}
    keys: dict[str, Any] = {"frame": "body"} if d.chance(0.2) else {}
    if d.chance(0.2):
        keys["point"] = [rounded(0.3 * form.half[0]), 0.0, 0.0]
    s.add("applied_force", form.name, force=force, **keys)


def _damp(s: Sketch, form: Form) -> None:
    """Damping, linear or quadratic."""
    d = s.draw
    if form.afloat and d.chance(0.4):
        s.add("linear_damping", form.name, damping_ratio={"roll": d.between(0.01, 0.1)})
    elif not form.afloat and d.chance(0.25):
        damping = rounded(form.mass * d.order(0.01, 0.3))
        s.add("linear_damping", form.name, damping={"surge": damping, "sway": damping})
    if form.afloat and d.chance(0.2):
        drag = 0.5 * 1025.0 * form.half[0] * -2.0 * min(form.bottom, -1.0)
        drag = rounded(drag * d.order(0.3, 1.5))
        s.add("quadratic_damping", form.name, damping={"sway": drag, "surge": rounded(0.1 * drag)})


def add_sea(s: Sketch) -> None:
    """Waves, with a ramp or without."""
    d = s.draw
    low, high = next(form.periods for form in s.forms if form.afloat)
    period = d.between(low, high)
    length = 1.56 * period**2
    common: Case = {"heading": d.one((0.0, pi, d.between(-pi, pi)), 25, 10, 65)}
    if d.chance(0.7):
        common["ramp"] = d.between(5.0, 40.0)
    kind = d.one(("jonswap", "pierson_moskowitz", "regular", "none"), 50, 8, 22, 20)
    if kind == "none":
        return
    if kind == "regular":
        waves: Case = {"amplitude": rounded(length * d.order(0.002, 0.015)), "period": period}
        _follow(s)
    else:
        waves = {"significant_height": rounded(min(length * d.order(0.005, 0.03), 6.0))}
        waves |= {"peak_period": period, "seed": int(d.rng.integers(1, 100))}
        waves["repeat_period"] = d.one((10800.0, 1800.0))
        if d.chance(0.2):
            waves["spreading"] = d.between(2.0, 20.0)
    s.environment["waves"] = {"spectrum": kind, **common, **waves}


def _follow(s: Sketch) -> None:
    """Loads at the place and heading of the time, in some seas of a single wave."""
    if s.draw.chance(0.2):
        for form in s.forms:
            if "location" in s.bodies[form.name] and form.afloat:
                forces = s.bodies[form.name]["wave_forces"]
                forces.update(headings="instantaneous", position="instantaneous")


def _streams(s: Sketch) -> None:
    """Current and wind, and their loads on bodies."""
    d = s.draw
    for stream, density, low, high in (("current", 1025.0, 0.2, 2.0), ("wind", 1.2, 5.0, 30.0)):
        afloat = any(form.afloat for form in s.forms)
        if not d.chance(0.25) or (stream == "current" and not afloat):
            continue
        s.environment[stream] = {"speed": d.between(low, high), "heading": d.between(-pi, pi)}
        for form in s.forms:
            if stream == "wind" or form.afloat:
                add_stream_load(s, form, stream, density)


def add_stream_load(s: Sketch, form: Form, stream: str, density: float) -> None:
    d = s.draw
    height = -form.bottom if stream == "current" else form.top
    along = rounded(0.5 * density * d.between(0.3, 1.2) * 2.0 * form.half[1] * max(height, 1.0))
    across = rounded(along * form.half[0] / form.half[1])
    yaw = rounded(0.1 * across * form.half[0])
    s.add(
        *(f"{stream}_load", form.name),
        headings=["0 deg", "45 deg", "90 deg", "135 deg", "180 deg"],
        surge=[along, rounded(0.7 * along), 0.0, rounded(-0.7 * along), -along],
        sway=[0.0, rounded(0.7 * across), across, rounded(0.7 * across), 0.0],
        yaw=[0.0, yaw, 0.0, -yaw, 0.0],
    )
