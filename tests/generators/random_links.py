"""Links of random cases: stops, gas springs, dry friction and spring-dampers along a coordinate.

Cases of numbers from `LINKED_FROM` on draw them, after all that they draw without.
"""

from math import sqrt
from typing import NamedTuple

from tests.generators.random_cases import Case, Draw, rounded

LINKED_FROM = 8_000_000


class Course(NamedTuple):
    """A coordinate: its ``place`` at rest, the ``span`` about it that matters, and the ``mass`` or
    inertia that moves along it. A ``distance`` stays above 0."""

    place: float
    span: float
    mass: float
    distance: bool = False


class DrawnLink(NamedTuple):
    """Type and keys of a link but for its coordinate, and its fastest rate [rad/s]."""

    kind: str
    keys: Case
    rate: float


def draw_link(d: Draw, course: Course) -> DrawnLink:
    """A link along a coordinate."""
    laws = (_stop, _gas_spring, _dry_friction, _spring_damper)
    return d.one(laws, 30, 20, 25, 25)(d, course)


def _stop(d: Draw, course: Course) -> DrawnLink:
    rate = d.order(6.0, 25.0)
    keys: Case = {"stiffness": rounded(course.mass * rate**2)}
    sides = {"lowest": (-1.0,), "highest": (1.0,), "both": (-1.0, 1.0)}
    ends = sides[d.one(("lowest", "highest", "both"))]
    for side in ends:
        end = course.place + side * course.span * d.between(-0.2 if len(ends) < 2 else 0.1, 1.0)
        keys["lowest" if side < 0.0 else "highest"] = rounded(end)
    if d.chance(0.6):
        keys["damping"] = rounded(course.mass * rate * d.between(0.05, 0.5))
    return DrawnLink("stop", keys, 2.0 * rate)


def _gas_spring(d: Draw, course: Course) -> DrawnLink:
    soft = d.order(0.5, 3.0)
    stiff = d.order(6.0, 25.0)
    stroke = rounded(course.span * d.between(0.5, 2.0))
    gas = rounded(stroke * d.between(0.6, 2.0))
    exponent = d.one((1.0, d.between(1.0, 1.5)))
    keys: Case = {"push": rounded(course.mass * soft**2 * gas), "stroke": stroke}
    keys |= {"gas_length": gas, "exponent": exponent, "stiffness": rounded(course.mass * stiff**2)}
    if d.chance(0.5):
        keys["neutral"] = rounded(course.place + course.span * d.between(-0.5, 0.5))
        if course.distance:
            keys["neutral"] = max(keys["neutral"], stroke)
    if d.chance(0.5):
        keys["damping"] = rounded(course.mass * soft * d.between(0.02, 0.5))
    steepest = soft * sqrt(exponent * (gas / (gas - 0.5 * stroke)) ** (exponent + 1.0))
    return DrawnLink("gas_spring", keys, 2.0 * max(steepest, stiff))


def _dry_friction(d: Draw, course: Course) -> DrawnLink:
    rate = d.order(6.0, 25.0)
    static = rounded(course.mass * course.span * d.order(0.1, 3.0))
    keys: Case = {"static": static, "kinetic": min(static, rounded(static * d.between(0.4, 1.0)))}
    keys["stiffness"] = rounded(course.mass * rate**2)
    if d.chance(0.7):
        keys["damping"] = rounded(course.mass * rate * d.between(0.05, 0.5))
    return DrawnLink("dry_friction", keys, 2.0 * rate)


def _spring_damper(d: Draw, course: Course) -> DrawnLink:
    rate = d.order(0.5, 5.0)
    stiffness = course.mass * rate**2
    keys: Case = {}
    if d.chance(0.5):
        keys["stiffness"] = rounded(stiffness * d.one((1.0, -0.1), 85, 15))
    else:
        places = [rounded(course.span * x) for x in (-0.5, d.between(-0.2, 0.2), 0.6)]
        loads = [rounded(stiffness * x) for x in (places[0], 0.3 * places[1], 1.5 * places[2])]
        keys["curve"] = {"place": places, "load": loads}
    if d.chance(0.4):
        keys["neutral"] = rounded(course.place + 0.5 * course.span * d.between(-0.5, 0.5))
    if d.chance(0.7):
        keys["damping"] = rounded(course.mass * rate * d.between(0.02, 0.4))
    if d.chance(0.3):
        keys["quadratic_damping"] = rounded(course.mass / course.span * d.order(0.02, 0.5))
    if d.chance(0.3):
        keys["absorbs"] = True
    return DrawnLink("spring_damper", keys, 4.0 * rate)
