"""Questions about allowable loads, beside loads at the start and weights, and about streams."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np

from hydrosim.compile.questions import query
from hydrosim.elements.line.catenary import pieces_of_line
from hydrosim.elements.line.points import largest_strain
from hydrosim.integrate.state import start_loads
from hydrosim.scene import Body, Weight
from hydrosim.scene.catenary import Catenary
from hydrosim.scene.contacts import Contact
from hydrosim.scene.force import strongest_breaking_load
from hydrosim.scene.links import Spring, TwoPointElement
from hydrosim.scene.loads import CurrentLoad, StreamLoad, WindLoad
from hydrosim.scene.scene import joined_with
from hydrosim.scene.winch import Winch

# Share of the breaking load of chain of grade R5; grade R3 has 0.7 of it, and ships' chain 0.3
MOST_OF_BREAKING = 2.0
LEAST_OF_BREAKING = 0.02
MOST_EXTENSION = 10.0  # of a spring, over its length
MOST_STRAIN = 0.5  # at the breaking load: nylon has 0.3
NEGLIGIBLE_LOAD_FRACTION = (
    1e-5  # of the weight of the lightest body that a line, contact or joint acts on
)


def ask_about_capacities(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about allowable loads that are exceeded at the start, that no weight can hang from, or
    that are a unit away from the bodies' weights."""
    yield from _ask_about_tiny_capacities(about)
    yield from _ask_about_strengths(about)
    yield from _ask_about_stretch_at_capacity(about)
    yield from _ask_about_overloaded_lines(about)
    yield from _ask_about_bodies_on_lines(about)


def _ask_about_tiny_capacities(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about allowable loads that the weight of a few litres of water exceeds."""
    limits = [
        (
            f"forces.{name}.capacity",
            of.capacity,
            {of.body, *(body for _, body in of.connected_bodies())},
        )
        for name, of in about.scene.forces.items()
        if isinstance(of, TwoPointElement | Contact) and of.capacity is not None
    ]
    limits += [
        (f"joints.{name}.breaks_at", joint.breaks_at, {joint.body, joint.to})
        for name, joint in about.scene.joints.items()
        if joint.breaks_at is not None
    ]
    gravity = about.scene.environment.gravity
    for key, limit, names in limits:
        masses = [body.mass for body in about.scene.bodies if body.name in names and body.dofs]
        lightest = gravity * min(masses, default=0.0)
        if limit is not None and limit < NEGLIGIBLE_LOAD_FRACTION * lightest:
            found_text = f"{limit:.3g} N, for a body whose weight is {lightest:.3g} N"
            usual = f"usual is above {NEGLIGIBLE_LOAD_FRACTION:g} of the weight"
            yield query.Query(key, found_text, usual, "Is it in kN?")


def _ask_about_stretch_at_capacity(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about capacities of springs at which they are several times as long."""
    for name, of in about.scene.forces.items():
        if not isinstance(of, Spring) or not of.capacity or not isinstance(of.length, float):
            continue
        slope = float(of.tension[-1] - of.tension[-2]) / float(of.extension[-1] - of.extension[-2])
        extension = of.extension[-1] + max(of.capacity - of.tension[-1], 0.0) / max(slope, 1e-300)
        if of.length > 0.0 and extension > MOST_EXTENSION * of.length:
            found_text = (
                f"{of.capacity:.3g} N, at which the line of {of.length:g} m is"
                f" {extension:.3g} m longer"
            )
            usual = f"usual is up to {MOST_EXTENSION:g} times its length"
            yield query.Query(
                f"forces.{name}.capacity", found_text, usual, "Check capacity and stiffness."
            )


def _ask_about_strengths(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about capacities far above or below the breaking load of a line's thinnest chain, and
    about those that stretch a rope by half of its length."""
    for name, of in about.scene.forces.items():
        if not isinstance(of, Catenary) or not of.capacity:
            continue
        key = f"forces.{name}.capacity"
        bars = list(query.bar_diameters(of, about.scene.environment))
        breaking = strongest_breaking_load(min(bars)) if bars else 0.0
        low, high = LEAST_OF_BREAKING * breaking, MOST_OF_BREAKING * breaking
        strain = largest_strain(pieces_of_line(of), of.capacity)
        if bars and not low <= of.capacity <= high:
            found_text = f"{of.capacity:.3g} N, for a chain of {1e3 * min(bars):.3g} mm"
            usual = f"such a chain of grade R5 breaks at {breaking:.3g} N"
            yield query.Query(key, found_text, usual, "Check diameter, capacity and their units.")
        elif strain > MOST_STRAIN:
            share = query.text_beyond(strain, MOST_STRAIN, ".0%")
            found_text = f"{of.capacity:.3g} N, at which the line is {share} longer"
            usual = f"usual is up to {MOST_STRAIN:.0%}"
            yield query.Query(key, found_text, usual, "Check capacity, stiffness and their units.")


def _ask_about_overloaded_lines(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about lines whose tension at the start is above their capacity."""
    scene = about.scene
    limits = {
        name: of.capacity
        for name, of in scene.forces.items()
        if isinstance(of, TwoPointElement) and of.capacity is not None
    }
    if not limits:
        return
    begin = about.end - scene.duration
    loads = start_loads(scene, about.model, about.state, about.derived.rows, begin)
    for name, capacity in limits.items():
        tension = loads[name]
        if tension > capacity:
            found_text = f"{capacity:.4g} N, and {query.text_beyond(tension, capacity, '.4g')} N"
            usual = "usual is a tension at the start below the capacity"
            yield query.Query(
                f"forces.{name}.capacity", f"{found_text} of tension at the start", usual
            )


def _ask_about_bodies_on_lines(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about dry bodies that hang from lines whose capacities add up to less than the weight."""
    for body in about.scene.bodies:
        if not _is_dry_and_heavy(about, body):
            continue
        acting = [
            of
            for of in about.scene.forces.values()
            if body.name in {of.body, *(name for _, name in of.connected_bodies())}
            and of.can_carry_weight()
        ]
        if not acting or not all(isinstance(of, TwoPointElement) for of in acting):
            continue
        allowed = sum(_allowable_force(of) for of in acting if isinstance(of, TwoPointElement))
        weight = body.mass * about.scene.environment.gravity
        if weight > allowed:
            found_text = (
                f"a weight of {weight:.3g} N that hangs from lines of {allowed:.3g} N in all"
            )
            usual = "usual is a weight below the capacities of the lines that carry it"
            advice = "Is the mass in tonne? Are the loads in kN?"
            yield query.Query(f"bodies.{body.name}.mass", found_text, usual, advice)


def _is_dry_and_heavy(about: query.SceneContext, body: Body) -> bool:
    """Whether nothing but force elements carries a body."""
    wet = body.name in about.derived.databases or body.hydrostatics is not None
    jointed = len(joined_with(about.scene, body.name)) > 1
    held = any(body.name in (joint.body, joint.to) for joint in about.scene.joints.values())
    falls = "heave" in body.dofs and body.weight == Weight.CARRIED
    return falls and not (wet or jointed or held)


def _allowable_force(line: TwoPointElement) -> float:
    """Allowable tension [N] of a line; infinite if none is given."""
    if line.capacity is not None:
        return line.capacity
    return _set_tension(line) if isinstance(line, Winch) else inf


def _set_tension(line: Winch) -> float:
    """Tension that a drum holds [N]; infinite if it controls a length or a speed."""
    return inf if line.tension is None else line.tension


# Coefficients of wind and current: size beside the hull, and sign.

AIR = 1.225  # kg/m^3
# drag coefficients: of the current on length times draught; of the wind on length times breadth,
# because no area above the water is known
CURRENT_DRAG = (0.002, 10.0)
WIND_DRAG = (0.003, 30.0)
MAX_DRAUGHT_RATIO = 3.0  # ratio
MAX_OPPOSING_FRACTION = 0.1  # part of the forces


def ask_about_coefficients(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about coefficients of wind and current that are not those of a hull of this size, that
    drive a body against the stream, and about a draught for the current that the hull has not."""
    sizes = {body.name: query.extents(body, db) for _, body, db in about.floating_bodies()}
    density = about.scene.environment.water_density
    for name, of in about.scene.forces.items():
        if isinstance(of, StreamLoad):
            yield from _ask_about_reversed_tables(name, of)
        size = sizes.get(of.body)
        if size is not None and isinstance(of, CurrentLoad):
            area = 2.0 * float(size.half.max()) * size.draught
            yield from _ask_about_load_size(name, of, 0.5 * density * area, CURRENT_DRAG)
        elif size is not None and isinstance(of, WindLoad):
            area = 4.0 * float(np.prod(size.half))
            yield from _ask_about_load_size(name, of, 0.5 * AIR * area, WIND_DRAG)
    for _, body, _ in about.floating_bodies():
        yield from _ask_about_other_draught(body.name, body.draught, sizes[body.name])


def _ask_about_load_size(
    name: str, of: StreamLoad, reference: float, limits: tuple[float, float]
) -> Iterator[query.Query]:
    """Ask about coefficients whose largest force is far from a ``reference`` force [N s^2/m^2]."""
    low, high = limits
    for key, force in (("surge", of.surge), ("sway", of.sway)):
        largest = float(np.abs(force).max())
        coefficient = largest / reference
        if largest > 0.0 and not low <= coefficient <= high:
            text = query.text_outside_range(coefficient, low, high, ".2g")
            found_text = (
                f"up to {largest:.3g} N s^2/m^2, a drag coefficient of {text} for the size of"
                f" {of.body}"
            )
            usual = f"usual is {low:g} to {high:g}"
            yield query.Query(f"forces.{name}.{key}", found_text, usual, "Is it in kN?")


def _ask_about_reversed_tables(name: str, of: StreamLoad) -> Iterator[query.Query]:
    """Ask about a table whose forces are against the stream in the sum over its headings."""
    for key, force, component in (
        ("surge", of.surge, np.cos(of.headings)),
        ("sway", of.sway, np.sin(of.headings)),
    ):
        if float(force @ component) < -MAX_OPPOSING_FRACTION * float(np.abs(force).sum()):
            found_text = "forces against the stream"
            usual = "usual are forces along it: surge above 0 at 0 deg, sway above 0 at 90 deg"
            advice = "headings are those that the stream goes to, relative to the body."
            yield query.Query(f"forces.{name}.{key}", found_text, usual, advice)


def _ask_about_other_draught(
    body: str, draught: float | None, size: query.Extents | None
) -> Iterator[query.Query]:
    if draught is None or size is None:
        return
    ratio = draught / size.draught
    if not 1.0 / MAX_DRAUGHT_RATIO <= ratio <= MAX_DRAUGHT_RATIO:
        found_text = f"{draught:.3g} m"
        usual = f"the hull of its database has about {size.draught:.3g} m"
        yield query.Query(f"bodies.{body}.draught", found_text, usual)
