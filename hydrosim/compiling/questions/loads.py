"""Questions about allowable loads: beside the loads at the start, and beside weights."""

from __future__ import annotations

from collections.abc import Iterator
from math import inf

import numpy as np

from hydrosim.compiling.questions.doubt import About, Doubt, text_beyond
from hydrosim.forces.contact.fender import Contact
from hydrosim.forces.line.winch import Winch
from hydrosim.forces.pair import Tie
from hydrosim.scene import Body, Weight
from hydrosim.scene.trees import joined_with
from hydrosim.stepping.start_loads import start_loads

TINY = 1e-5  # of the weight of the lightest body that a line, contact or joint acts on


def capacities(about: About) -> Iterator[Doubt]:
    """Ask about allowable loads that are exceeded at the start, that no weight can hang from, or
    that are a unit away from the bodies' weights."""
    yield from _tiny(about)
    yield from _exceeded(about)
    yield from _hanging(about)


def _tiny(about: About) -> Iterator[Doubt]:
    """Ask about allowable loads that the weight of a few litres of water exceeds."""
    limits = [
        (f"forces.{name}.capacity", of.capacity, {of.body, *(body for _, body in of.others())})
        for name, of in about.scene.forces.items()
        if of.capacity is not None and isinstance(of, Tie | Contact)
    ]
    limits += [
        (f"joints.{name}.breaks_at", joint.breaks_at, {joint.body, joint.to})
        for name, joint in about.scene.joints.items()
        if joint.breaks_at is not None
    ]
    gravity = about.scene.environment.gravity
    for key, limit, names in limits:
        own = [body.mass for body in about.scene.bodies if body.name in names and body.dofs]
        lightest = gravity * min(own, default=0.0)
        if limit is not None and limit < TINY * lightest:
            found = f"{limit:.3g} N, for a body whose weight is {lightest:.3g} N"
            usual = f"usual is above {TINY:g} of the weight"
            yield Doubt(key, found, usual, "Is it in kN?")


def _exceeded(about: About) -> Iterator[Doubt]:
    """Ask about lines whose tension at the start is above their capacity."""
    scene = about.scene
    limits = {
        name: of.capacity
        for name, of in scene.forces.items()
        if isinstance(of, Tie) and of.capacity is not None
    }
    if not limits:
        return
    begin = about.end - scene.duration
    loads = start_loads(scene, about.model, about.state, about.facts.rows, begin)
    for name, capacity in limits.items():
        tension = loads[name]
        if tension > capacity:
            found = f"{capacity:.4g} N, and {text_beyond(tension, capacity, '.4g')} N"
            usual = "usual is a tension at the start below the capacity"
            yield Doubt(f"forces.{name}.capacity", f"{found} of tension at the start", usual)


def _hanging(about: About) -> Iterator[Doubt]:
    """Ask about dry bodies that hang from lines whose capacities add up to less than the weight."""
    for body in about.scene.bodies:
        if not _is_dry_and_heavy(about, body):
            continue
        acting = [
            of
            for of in about.scene.forces.values()
            if body.name in {of.body, *(name for _, name in of.others())} and of.carries()
        ]
        if not acting or not all(isinstance(of, Tie) for of in acting):
            continue
        allowed = sum(_allowable(of) for of in acting if isinstance(of, Tie))
        weight = body.mass * about.scene.environment.gravity
        if weight > allowed:
            found = f"a weight of {weight:.3g} N that hangs from lines of {allowed:.3g} N in all"
            usual = "usual is a weight below the capacities of the lines that carry it"
            advice = "Is the mass in tonne? Are the loads in kN?"
            yield Doubt(f"bodies.{body.name}.mass", found, usual, advice)


def _is_dry_and_heavy(about: About, body: Body) -> bool:
    """Whether nothing but force elements carries a body."""
    wet = body.name in about.facts.databases or body.hydrostatics is not None
    jointed = len(joined_with(about.scene, body.name)) > 1
    held = any(body.name in (joint.body, joint.to) for joint in about.scene.joints.values())
    falls = "heave" in body.dofs and body.weight == Weight.CARRIED
    return falls and not (wet or jointed or held)


def _allowable(line: Tie) -> float:
    """Allowable tension [N] of a line; infinite if none is given."""
    if line.capacity is not None:
        return line.capacity
    return inf if not isinstance(line, Winch) or line.control is None else _set_tension(line)


def _set_tension(line: Winch) -> float:
    """Tension that a drum holds [N]; infinite if it controls a length or a speed."""
    return float(getattr(line.control, "tension", np.inf))
