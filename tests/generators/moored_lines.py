"""Lines of `moored_cases`: chains on a seabed, taut lines, ropes, winches of all controls.

A line has a wanted stiffness and a tension at the start that goes with it. Its length follows from
where its ends are at rest, nearly: some lines are slack, others are short.
"""

from dataclasses import dataclass
from math import acosh, cos, hypot, inf, sin, sqrt
from typing import Any

from tests.generators.random_cases import GRAVITY, Case, Form, Place, Sketch, rounded

LINES = 8
"""Of a scene, at most."""
CONTROLS = ("length", "speed", "tension", "tugger", "compensation")


@dataclass(frozen=True)
class Ends:
    """A line from ``point`` of a ``form`` to an end that is ``away`` from there in the axes of the
    scene; ``keys`` say where that is."""

    form: Form
    point: list[float]
    away: Place
    keys: Case

    @property
    def chord(self) -> float:
        """Distance between both ends [m]."""
        return hypot(*self.away)


def depth_of(s: Sketch) -> float:
    """Water depth of a sketch [m]; of dry scenes infinite."""
    given = s.environment.get("water_depth", "infinite")
    return inf if given == "infinite" else float(str(given).split()[0])


def add_spread(s: Sketch, form: Form, count: int, stiffness: float) -> None:
    """Lines in all directions, each with such a ``stiffness`` [N/m]."""
    d = s.draw
    start = d.between(-3.0, 3.0)
    kinds = ("chain", "taut", "rope", "winch")
    weights = (45 if depth_of(s) < inf else 0, 30, 12, 13)
    usual = d.one(kinds, *weights)
    for k in range(count):
        along = start + 6.2832 * k / count + d.between(-0.15, 0.15)
        kind = usual if d.chance(0.7) else d.one(kinds, *weights)
        k_line = stiffness * d.order(0.5, 2.0)
        if kind == "chain":
            _add_chain(s, form, along, k_line)
        else:
            add_line(s, kind, _to_anchor(s, form, along), k_line)


def add_line(s: Sketch, kind: str, ends: Ends, stiffness: float) -> None:
    """A line of a ``kind`` between given ends."""
    if s.units >= LINES:
        return
    s.units += 1
    s.rates.append(1.5 * sqrt(stiffness / ends.form.mass))
    {"taut": _add_taut, "rope": _add_rope, "winch": _add_winch}[kind](s, ends, stiffness)


def _fairlead(s: Sketch, form: Form, along: float) -> list[float]:
    """A place on a body from which a line leads in a direction."""
    d = s.draw
    x, y = (
        rounded(max(-0.95, min(0.95, 1.3 * part)) * half)
        for part, half in zip((cos(along), sin(along)), form.half, strict=True)
    )
    return [x, y, d.between(0.6 * form.bottom, form.top)]


def _to_anchor(s: Sketch, form: Form, along: float) -> Ends:
    """From a body to an anchor off it, above the seabed."""
    d = s.draw
    point = _fairlead(s, form, along)
    reach = form.half[0] * d.order(1.0, 5.0)
    z = form.at[2] + point[2]
    end = max(z - reach * d.between(-0.1, 0.7), 1.0 - depth_of(s))
    if form.afloat and end > 0.0:  # on a quay
        end = min(end, z - 3.0)
    away = (reach * cos(along), reach * sin(along), end - z)
    anchor = s.turned(form.at[0] + point[0] + away[0], form.at[1] + point[1] + away[1])
    return Ends(form, point, away, {"anchor": [*anchor, rounded(end)]})


def between(form: Form, point: list[float], other: Form, anchor: list[float]) -> Ends:
    """From a body to a point of another one that has the same heading at the start."""
    x, y, z = (other.at[i] + anchor[i] - form.at[i] - point[i] for i in range(3))
    return Ends(form, point, (x, y, z), {"anchor": anchor, "anchor_body": other.name})


def above(s: Sketch, form: Form, height: float) -> Ends:
    """From the top of a body to the earth above it, nearly upright."""
    d = s.draw
    point = [0.0, 0.0, form.top]
    away = (height * d.between(-0.03, 0.03), height * d.between(-0.03, 0.03), height)
    anchor = s.turned(form.at[0] + away[0], form.at[1] + away[1])
    end = [*anchor, rounded(form.at[2] + form.top + height)]
    return Ends(form, point, away, {"anchor": end})


def _add_chain(s: Sketch, form: Form, along: float, stiffness: float) -> None:
    """A chain that lies on the seabed, or hangs just above it. Its horizontal stiffness without
    stretch is w / (acosh(1 + h/a) - 2 / sqrt(1 + 2 a/h)), with a = H/w."""
    if s.units >= LINES:
        return
    s.units += 1
    d = s.draw
    point = _fairlead(s, form, along)
    h = depth_of(s) + form.at[2] + point[2]
    a = h * d.order(0.2, 6.0)
    w = stiffness * (acosh(1.0 + h / a) - 2.0 / sqrt(1.0 + 2.0 * a / h))
    hung = h * sqrt(1.0 + 2.0 * a / h)
    ground = hung * d.one((d.order(0.05, 1.5), 0.0), 85, 15)
    reach = a * acosh(1.0 + h / a) + ground
    length = (hung + ground) * d.between(0.995, 1.01)
    tension = w * (a + h)
    EA = tension * d.order(100.0, 3000.0)
    at = (form.at[0] + point[0] + reach * cos(along), form.at[1] + point[1] + reach * sin(along))
    keys: Case = {"point": point, "anchor": [*s.turned(*at), rounded(-depth_of(s))]}
    keys |= {"segments": _segments(s, length, w, EA), "seabed": {}}
    if d.chance(0.5):
        keys["seabed"] = {"friction": d.between(0.1, 1.0)}
    s.rates.append(0.5 * sqrt(EA / length / form.mass))
    s.add("catenary", form.name, **keys, **_ending(s, tension))


def _add_taut(s: Sketch, ends: Ends, stiffness: float) -> None:
    """A line with little sag, or with some."""
    d = s.draw
    strain = d.order(2e-4, 2e-2)
    EA = stiffness * ends.chord
    tension = EA * strain
    sag = ends.chord * d.order(0.7, 100.0)
    level = hypot(*ends.away[:2])
    slack = d.between(-0.002, 0.004)
    length = ends.chord * (1.0 + (level / sag) ** 2 / 24.0) / (1.0 + strain) * (1.0 + slack)
    keys: Case = {"point": ends.point, **ends.keys}
    keys["segments"] = _segments(s, length, tension / sag, EA)
    if depth_of(s) < inf and d.chance(0.4):
        keys["seabed"] = {"friction": d.one((0.0, 0.5))}
    s.add("catenary", ends.form.name, **keys, **_ending(s, tension))


def _segments(s: Sketch, length: float, weight: float, EA: float) -> list[Case]:
    """Segments of a line with this weight [N/m], all in all, and what hangs between them."""
    d = s.draw
    count = d.one((1, 2, 3), 60, 27, 13)
    parts = [d.between(0.5, 1.5) for _ in range(count)]
    afloat = any(form.afloat for form in s.forms)
    found = []
    for k, part in enumerate(parts):
        own = length * part / sum(parts)
        heavier = d.order(0.3, 2.0) if count > 1 else 1.0
        one: Case = {"length": rounded(own), "weight": rounded(weight * heavier)}
        one["stiffness"] = rounded(EA * (d.order(0.5, 3.0) if count > 1 else 1.0))
        if k < count - 1 and d.chance(0.5):
            one[d.one(("clump", "buoy"))] = rounded(weight * length * d.order(0.03, 0.4))
        if afloat and d.chance(0.35):
            width = rounded(2.0 * sqrt(weight / (1000.0 * GRAVITY)))
            one["drag"] = {"coefficient": d.between(1.0, 2.4), "diameter": width}
        found.append(one)
    if d.chance(0.12):
        found[0]["length"] = _length_over_time(s, found[0]["length"], 0.01 * length)
    return found


def _length_over_time(s: Sketch, length: float, change: float) -> Case:
    """A table or a sine of a length."""
    d = s.draw
    change = min(change, 0.3 * length)
    if d.chance(0.5):
        amplitude = rounded(change * d.between(0.1, 0.5))
        return {"mean": length, "amplitude": amplitude, "period": d.between(5.0, 30.0)}
    times = [d.between(0.0, 5.0), d.between(8.0, 15.0), d.between(18.0, 30.0)]
    lengths = [length, *(rounded(length + change * d.between(-1.0, 1.0)) for _ in range(2))]
    return {"time": times, "length": lengths}


def _add_rope(s: Sketch, ends: Ends, stiffness: float) -> None:
    """A spring, a little slack or taut, which may break."""
    d = s.draw
    extended = d.between(-0.004, 0.02)
    length = ends.chord / (1.0 + extended)
    tension = stiffness * max(extended, 0.004) * length
    keys: Case = {"point": ends.point, **ends.keys, "length": rounded(length)}
    if d.chance(0.7):
        keys["stiffness"] = rounded(stiffness)
    else:
        far = [0.0, rounded(0.02 * length), rounded(0.06 * length)]
        pull = [0.0, rounded(0.7 * stiffness * far[1]), rounded(1.2 * stiffness * far[2])]
        keys["curve"] = {"extension": far, "tension": pull}
    if d.chance(0.5):
        keys["damping"] = rounded(d.between(0.02, 0.2) * sqrt(stiffness * ends.form.mass))
    s.add("spring", ends.form.name, **keys, **_ending(s, tension))


def _ending(s: Sketch, tension: float) -> Case:
    """At what a line parts, or the time in which it acts."""
    d = s.draw
    if d.chance(0.18):
        load = {"tension": rounded(tension * d.order(1.4, 4.0))}
        return {"breaks_at": d.one((load["tension"], load, {"time": d.between(2.0, 40.0)}))}
    if d.chance(0.1):
        begin, end = d.between(1.0, 10.0), d.between(12.0, 40.0)
        return {"active": d.one(({"from": begin}, {"until": end}, {"from": begin, "until": end}))}
    return {}


def _add_winch(s: Sketch, ends: Ends, stiffness: float) -> None:
    """A winch of any control, which holds a tension at the start."""
    d = s.draw
    strain = d.order(1e-3, 2e-2)
    add_winch(s, ends, stiffness, strain * stiffness * ends.chord, d.one(CONTROLS))


def add_winch(s: Sketch, ends: Ends, stiffness: float, tension: float, control: str) -> None:
    """A winch that holds such a ``tension`` [N] at the start, with this ``control``."""
    d = s.draw
    chord = ends.chord
    EA = stiffness * chord
    length = rounded(chord / (1.0 + tension / EA))
    keys: Case = {"point": ends.point, **ends.keys, "stiffness": rounded(EA)}
    if d.chance(0.7):
        keys["damping"] = rounded(d.order(0.01, 0.2) / sqrt(stiffness / ends.form.mass))
    if control == "length":
        keys["length"] = _length_over_time(s, length, 0.3 * length * min(1.0, 20.0 * tension / EA))
        drive: Case = {}
    elif control == "speed":
        drive = {"length": length, "speed": _speed(s, length), "drum": _drum(s, length)}
    elif control == "compensation":
        drive = {"length": length, "compensation": _compensation(s, length)}
    else:
        drive = _tension(s, length, tension, control)
    s.add("winch", ends.form.name, **keys, **drive, **_ending(s, tension))


def _drum(s: Sketch, length: float) -> Case:
    """Ends of a drum, which may be near."""
    d = s.draw
    near = d.one((0.02, 0.5), 25, 75)
    return {
        "shortest": rounded(length * (1.0 - near * d.between(0.3, 1.0))),
        "longest": rounded(length * (1.0 + near * d.between(0.3, 1.0))),
    }


def _speed(s: Sketch, length: float) -> Any:
    """A speed of pay-out: a number, a table or a sine."""
    d = s.draw
    speed = rounded(length * d.order(2e-4, 5e-3) * d.one((1.0, -1.0)))
    form = d.one(("number", "table", "sine"))
    if form == "number":
        return speed
    if form == "sine":
        return {"amplitude": abs(speed), "period": d.between(5.0, 30.0)}
    times = [d.between(0.0, 3.0), d.between(4.0, 10.0), d.between(12.0, 25.0)]
    return {"time": times, "speed": [0.0, speed, d.one((0.0, rounded(-0.5 * speed)))]}


def _tension(s: Sketch, length: float, tension: float, control: str) -> Case:
    """Keys of a winch that keeps a tension: a tugger, or one with friction."""
    d = s.draw
    drive: Case = {"tension": rounded(tension), "speed": rounded(length * d.order(2e-3, 0.05))}
    drive["drum"] = _drum(s, length)
    if control == "tugger":
        drive["dead_band"] = d.between(0.02, 0.2)
    else:
        drive["friction"] = {"in": d.between(0.0, 0.4), "out": d.between(0.02, 0.3)}
        if d.chance(0.3):
            drive["dead_band"] = d.between(0.0, 0.1)
    if d.chance(0.4):
        drive["acceleration"] = rounded(drive["speed"] / d.order(0.3, 5.0))
    if d.chance(0.5):
        drive["length"] = length
    return drive


def _compensation(s: Sketch, length: float) -> Case:
    d = s.draw
    followed = d.one(s.forms)
    keys: Case = {"point": f"mast of {followed.name}", "gain": d.between(0.3, 1.1)}
    if d.chance(0.5):
        keys["delay"] = d.order(0.05, 1.0)
    if d.chance(0.5):
        keys["speed"] = rounded(length * d.order(0.002, 0.1))
    if d.chance(0.5):
        keys["stroke"] = rounded(length * d.order(0.01, 0.5))
    return keys
