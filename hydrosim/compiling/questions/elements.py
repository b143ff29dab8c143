"""Questions about force elements: stiffness of fenders, friction and damping."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.questions.doubt import About, Doubt, text_beyond
from hydrosim.compiling.questions.shapes import drag
from hydrosim.dofs import DOFS
from hydrosim.forces.contact.coulomb import Coulomb
from hydrosim.forces.contact.fender import Contact
from hydrosim.forces.contact.friction_slope import FrictionSlope
from hydrosim.forces.contact.normal import PrescribedNormal
from hydrosim.forces.contact.stick_slip import StickSlip
from hydrosim.forces.damping.linear_damping import LinearDamping
from hydrosim.forces.damping.viscous_roll import KIND as ROLLS
from hydrosim.forces.damping.viscous_roll import ViscousRoll
from hydrosim.forces.line.catenary import Catenary
from hydrosim.forces.linear_mooring import LinearMooring
from hydrosim.scene import Question, Weight

ROUGHEST = 1.0
BERTHING = 0.1  # m/s: berthing speed of a large ship (PIANC WG 33, 2002)
SOFTEST = 1.5  # m: a pneumatic fender of 3.3 m takes all its energy in twice that
SAME_PERIOD = 0.1
TOGETHER = 0.7  # cosine of the largest angle between normals of fenders that share a load


def bending(about: About) -> Iterator[Doubt]:
    """Ask about the bending stiffness of lines in files of other programs."""
    yield from _left_out(about, Question.BENDING)


def files(about: About) -> Iterator[Doubt]:
    """Tell what else files of other programs say and the scene has not."""
    yield from _left_out(about, Question.FILES)


def _left_out(about: About, question: Question) -> Iterator[Doubt]:
    for element in about.scene.forces.values():
        for each in element.left_out if isinstance(element, Catenary) else ():
            if each.question is question:
                yield Doubt(each.key, each.found, each.becomes, each.advice, each.refused)


def softness(about: About) -> Iterator[Doubt]:
    """Ask about fenders that a body at berthing speed compresses by metres."""
    fenders = [
        (name, fender)
        for name, fender in about.scene.forces.items()
        if isinstance(fender, Contact) and not isinstance(fender.normal, PrescribedNormal)
    ]
    for name, fender in fenders:
        others = [other for _, other in fenders if _together(fender, other)]
        stiffness = sum(len(other.points) * _stiffness(other) for other in others)
        below_weight = list(_under_weight(about, name, fender, stiffness))
        if below_weight:
            yield from below_weight
            continue
        mass = _mass(about, fender)
        pressed = BERTHING * np.sqrt(mass / stiffness) if stiffness > 0.0 else np.inf
        if mass > 0.0 and pressed > SOFTEST:
            by = text_beyond(pressed, SOFTEST)
            yield Doubt(
                f"forces.{name}.normal",
                f"{_stiffness(fender):.3g} N/m per point: {mass:.3g} kg at {BERTHING:g} m/s would"
                f" compress the {len(others)} fenders of that side by {by} m"
                if len(others) > 1
                else f"{stiffness:.3g} N/m in all: {mass:.3g} kg at {BERTHING:g} m/s would"
                f" compress it by {by} m",
                f"usual is up to {SOFTEST:g} m",
                "Is it in kN/m?",
            )


def _under_weight(about: About, name: str, fender: Contact, stiffness: float) -> Iterator[Doubt]:
    """Ask about dry bodies whose weight alone compresses the fenders below them by metres."""
    body = about.scene.bodies[about.index[fender.body]]
    normal = np.array(fender.planes()[0].normal, float)
    upward = normal[2] / np.linalg.norm(normal)
    dry = body.name not in about.facts.databases
    hangs = any(
        each.body == body.name and each.carries() and not isinstance(each, Contact)
        for each in about.scene.forces.values()
    )
    if body.weight != Weight.CARRIED or not dry or hangs or upward < TOGETHER:
        return
    weight = body.mass * about.scene.environment.gravity
    if weight > SOFTEST * stiffness:
        yield Doubt(
            f"forces.{name}.normal",
            f"{stiffness:.3g} N/m below {body.name}, whose weight of {weight:.3g} N compresses it"
            f" by {text_beyond(weight / stiffness, SOFTEST)} m",
            f"usual is up to {SOFTEST:g} m",
            "Is it in kN/m? Is the mass in tonne?",
        )


def _together(fender: Contact, other: Contact) -> bool:
    """Whether two fenders stop the same body on the same side."""
    normals = (np.array(each.planes()[0].normal, float) for each in (fender, other))
    n, m = (normal / np.linalg.norm(normal) for normal in normals)
    same = fender.body == other.body and [*fender.others()] == [*other.others()]
    return same and bool(n @ m > TOGETHER)


def _stiffness(fender: Contact) -> float:
    """Secant stiffness of a point at the end of its curve [N/m]."""
    assert not isinstance(fender.normal, PrescribedNormal)
    return float(fender.normal.force[-1] / fender.normal.compression[-1])


def _mass(about: About, fender: Contact) -> float:
    """Mass of the lighter of the two bodies of a fender that move [kg]."""
    names = {fender.body, *(name for _, name in fender.others())}
    moving = [body.mass for body in about.scene.bodies if body.name in names and body.dofs]
    return min(moving, default=0.0)


def friction(about: About) -> Iterator[Doubt]:
    """Ask about friction coefficients above 1."""
    for name, fender in about.scene.forces.items():
        law = fender.friction if isinstance(fender, Contact) else None
        largest = 0.0
        if isinstance(law, FrictionSlope):
            largest = law.coefficient
        elif isinstance(law, StickSlip | Coulomb):
            largest = law.static
        if largest > ROUGHEST:
            usual = "usual is 0.05 to 0.8: steel on steel 0.1 to 0.7, rubber up to 1"
            advice = "Is it a percentage?"
            yield Doubt(f"forces.{name}.friction", f"a coefficient of {largest:g}", usual, advice)


def damping(about: About) -> Iterator[Doubt]:
    """Ask about damping ratios above critical, about decay tests that are not of this body, and
    about drag of another size."""
    yield from drag(about)
    yield from _roll_damping(about)
    for name, element in about.scene.forces.items():
        if not isinstance(element, LinearMooring | LinearDamping) or element.damping_ratio is None:
            continue
        for dof, ratio in zip(DOFS, np.asarray(element.damping_ratio), strict=True):
            if ratio > 1.0:
                usual = "usual is 0.01 to 0.3 of critical"
                advice = f'Is it a percentage? Then it is "{ratio:g} %".'
                yield Doubt(f"forces.{name}.damping_ratio.{dof}", f"{ratio:g}", usual, advice)


def _roll_damping(about: About) -> Iterator[Doubt]:
    """Ask about decay tests with less damping than radiated waves alone, or with another period."""
    rolling = ROLLS.of(about.model)
    elements = [(n, e) for n, e in about.scene.forces.items() if isinstance(e, ViscousRoll)]
    for (name, element), found in zip(elements, rolling, strict=True):
        measured, waves, omega = (float(found[x]) for x in ("measured", "waves", "frequency"))
        if measured < waves and (element.p1 or element.p2 or element.p3):
            yield Doubt(
                f"forces.{name}.p1",
                f"{measured:.3g} N m s/rad of damping in all, and {waves:.3g} N m s/rad by radiated"
                " waves in the database, so that the linear part is 0",
                "the total of a decay test is the larger",
                "The roll decays faster than measured. Check loading condition and draught, or set"
                " includes_waves: false if p1 has no waves in it.",
            )
        period = 2.0 * np.pi / omega if omega > 0.0 else np.inf
        if element.period and omega > 0.0 and abs(element.period / period - 1.0) > SAME_PERIOD:
            yield Doubt(
                f"forces.{name}.period",
                f"a natural period of {element.period:.3g} s in the decay test, and of"
                f" {period:.3g} s of this body in the case",
                f"usual is a difference of at most {100.0 * SAME_PERIOD:g} % of the body's period",
                "Test and case must have the same loading condition and scale: check mass, centre"
                " of gravity and radius of gyration, and scale the test to the ship.",
            )
