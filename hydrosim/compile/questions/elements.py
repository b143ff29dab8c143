"""Questions about force elements: stiffness and places of fenders, friction and damping."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping

import numpy as np

from hydrosim.compile.questions import query
from hydrosim.compile.questions.attachments import ask_about_attachments
from hydrosim.compile.questions.bodies import ask_about_drag
from hydrosim.dofs import DOFS
from hydrosim.elements.viscous_roll import VISCOUS_ROLL_KIND as ROLLS
from hydrosim.multibody.kinematics import Motion
from hydrosim.scene import Body, Question, Weight
from hydrosim.scene.contacts import (
    Contact,
    Coulomb,
    Fender,
    FrictionSlope,
    NormalCurve,
    PrescribedNormal,
    StickSlip,
)
from hydrosim.scene.damping import LinearDamping, ViscousRoll
from hydrosim.scene.restraints import LinearMooring

ROUGHEST = 1.0
BERTHING = 0.1  # m/s: berthing speed of a large ship (PIANC WG 33, 2002)
SOFTEST = 1.5  # m: a pneumatic fender of 3.3 m takes all its energy in twice that
STIFFEST = 1e10  # N/m: a bar of steel of 1 m with a section of 0.05 m^2
# of critical damping: given as a ratio, and as damping
MIN_RATIO = 1e-3
LEAST_RATIO, MOST_RATIO = 1e-4, 3.0
MAX_ROLL_RATIO = 0.5
MAX_FENDER_RATIO = 10.0
SMOOTHEST = 0.005
SAME_SIZE = 1.5  # ratio of a barge's dimensions to those of its hull
MAX_STIFFNESS_RATIO = 100.0  # of friction beside that of the normal; elastic bodies have up to 1
SAME_PERIOD = 0.1
SHARED_LOAD_COSINE = 0.7  # cosine of the largest angle between normals of fenders that share a load


def ask_about_bending(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about the bending stiffness of lines in files of other programs."""
    yield from _ask_about_omitted_entries(about, Question.BENDING)


def ask_about_files(about: query.SceneContext) -> Iterator[query.Query]:
    """Tell what else files of other programs say and the scene has not."""
    yield from _ask_about_omitted_entries(about, Question.FILES)


def _ask_about_omitted_entries(
    about: query.SceneContext, question: Question
) -> Iterator[query.Query]:
    for entry in about.scene.left_out:
        if entry.question is question:
            yield query.Query(entry.key, entry.found, entry.becomes, entry.advice, entry.refused)


def ask_about_softness(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about fenders that a body at berthing speed compresses by metres, and about those that
    are stiffer than steel."""
    fenders = [
        (name, fender)
        for name, fender in about.scene.forces.items()
        if isinstance(fender, Contact) and not isinstance(fender.normal, PrescribedNormal)
    ]
    for name, fender in fenders:
        if _fender_stiffness(fender) > STIFFEST:
            found_text = f"{query.text_beyond(_fender_stiffness(fender), STIFFEST)} N/m per point"
            usual = f"usual is up to {STIFFEST:g} N/m, a bar of steel of 1 m and 0.05 m^2"
            yield query.Query(f"forces.{name}.normal", found_text, usual, "Check its unit.")
        others = [other for _, other in fenders if _share_load(fender, other)]
        stiffness = sum(len(other.points) * _fender_stiffness(other) for other in others)
        below_weight = list(_ask_about_compression_by_weight(about, name, fender, stiffness))
        if below_weight:
            yield from below_weight
            continue
        mass = _mass_on_fender(about, fender)
        pressed = BERTHING * np.sqrt(mass / stiffness) if stiffness > 0.0 else np.inf
        if mass > 0.0 and pressed > SOFTEST:
            by = query.text_beyond(pressed, SOFTEST)
            yield query.Query(
                f"forces.{name}.normal",
                f"{_fender_stiffness(fender):.3g} N/m per point: {mass:.3g} kg at"
                f" {BERTHING:g} m/s would"
                f" compress the {len(others)} fenders of that side by {by} m"
                if len(others) > 1
                else f"{stiffness:.3g} N/m in all: {mass:.3g} kg at {BERTHING:g} m/s would"
                f" compress it by {by} m",
                f"usual is up to {SOFTEST:g} m",
                "Is it in kN/m?",
            )


def _ask_about_compression_by_weight(
    about: query.SceneContext, name: str, fender: Contact, stiffness: float
) -> Iterator[query.Query]:
    """Ask about dry bodies whose weight alone compresses the fenders below them by metres."""
    body = about.scene.bodies[about.body_numbers[fender.body]]
    normal = np.array(fender.planes()[0].normal, float)
    upward = normal[2] / np.linalg.norm(normal)
    dry = body.name not in about.derived.databases
    hangs = any(
        element.body == body.name
        and element.can_carry_weight()
        and not isinstance(element, Contact)
        for element in about.scene.forces.values()
    )
    if body.weight != Weight.CARRIED or not dry or hangs or upward < SHARED_LOAD_COSINE:
        return
    weight = body.mass * about.scene.environment.gravity
    if weight > SOFTEST * stiffness:
        yield query.Query(
            f"forces.{name}.normal",
            f"{stiffness:.3g} N/m below {body.name}, whose weight of {weight:.3g} N compresses it"
            f" by {query.text_beyond(weight / stiffness, SOFTEST)} m",
            f"usual is up to {SOFTEST:g} m",
            "Is it in kN/m? Is the mass in tonne?",
        )


def _share_load(fender: Contact, other: Contact) -> bool:
    """Whether two fenders stop the same body on the same side."""
    normals = (np.array(contact.planes()[0].normal, float) for contact in (fender, other))
    n, m = (normal / np.linalg.norm(normal) for normal in normals)
    same = fender.body == other.body and [*fender.connected_bodies()] == [*other.connected_bodies()]
    return same and bool(n @ m > SHARED_LOAD_COSINE)


def _fender_stiffness(fender: Contact) -> float:
    """Secant stiffness of a point at the end of its curve [N/m]."""
    assert not isinstance(fender.normal, PrescribedNormal)
    return float(fender.normal.force[-1] / fender.normal.compression[-1])


def _mass_on_fender(about: query.SceneContext, fender: Contact) -> float:
    """Mass of the lighter of the two bodies of a fender that move [kg]."""
    names = {fender.body, *(name for _, name in fender.connected_bodies())}
    moving = [body.mass for body in about.scene.bodies if body.name in names and body.dofs]
    return min(moving, default=0.0)


def ask_about_friction(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about friction coefficients above 1, and about a stiffness of friction beside which a
    body moves by metres before it slips, or that is far above that of the fender."""
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
            yield query.Query(
                f"forces.{name}.friction", f"a coefficient of {largest:g}", usual, advice
            )
        if 0.0 < largest < SMOOTHEST:
            usual = "usual is 0.05 to 0.8: greased steel has 0.1, PTFE 0.04"
            yield query.Query(f"forces.{name}.friction", f"a coefficient of {largest:g}", usual)
        if isinstance(fender, Contact) and isinstance(law, StickSlip) and largest <= ROUGHEST:
            yield from _ask_about_friction_stiffness(about, name, fender, law)


def _ask_about_friction_stiffness(
    about: query.SceneContext, name: str, fender: Contact, law: StickSlip
) -> Iterator[query.Query]:
    """Ask about the tangential stiffness of a fender, at the load of a body at berthing speed."""
    if isinstance(fender.normal, PrescribedNormal):
        return
    normal = _fender_stiffness(fender)
    key = f"forces.{name}.friction.stiffness"
    load = BERTHING * np.sqrt(_mass_on_fender(about, fender) * normal / len(fender.points))
    stretch = law.static * load / law.stiffness
    if stretch > SOFTEST:
        found_text = (
            f"{law.stiffness:.3g} N/m per point: the body moves"
            f" {query.text_beyond(stretch, SOFTEST)} m"
            f" before it slips at a load of {load:.3g} N"
        )
        yield query.Query(key, found_text, f"usual is up to {SOFTEST:g} m", "Is it in kN/m?")
    if law.stiffness > MAX_STIFFNESS_RATIO * normal > 0.0:
        found_text = f"{law.stiffness:.3g} N/m per point, and {normal:.3g} N/m normal to the plane"
        usual = f"usual is up to {MAX_STIFFNESS_RATIO:g} times the normal stiffness"
        yield query.Query(key, found_text, usual, "Check its unit.")


def ask_about_damping(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about damping ratios above critical, about decay tests that are not of this body, and
    about drag of another size."""
    yield from ask_about_drag(about)
    yield from _ask_about_roll_damping(about)
    yield from _ask_about_linear_damping(about)
    yield from _ask_about_roll_forms(about)
    yield from _ask_about_fender_damping(about)
    for name, element in about.scene.forces.items():
        if not isinstance(element, LinearMooring | LinearDamping) or element.damping_ratio is None:
            continue
        for dof, ratio in zip(DOFS, np.asarray(element.damping_ratio), strict=True):
            if ratio > 1.0:
                usual = "usual is 0.01 to 0.3 of critical"
                advice = f'Is it a percentage? Then it is "{ratio:g} %".'
                yield query.Query(f"forces.{name}.damping_ratio.{dof}", f"{ratio:g}", usual, advice)
            if 0.0 < ratio < MIN_RATIO:
                usual = "usual is 0.01 to 0.3 of critical"
                advice = "It is a fraction of critical damping: 5 % are 0.05."
                yield query.Query(f"forces.{name}.damping_ratio.{dof}", f"{ratio:g}", usual, advice)


def _ask_about_linear_damping(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about linear damping far below or above critical, where hydrostatics or moorings restore
    a body."""
    wet = {body.name: (i, body, db) for i, body, db in about.afloat()}
    for name, of in about.scene.forces.items():
        if not isinstance(of, LinearDamping) or of.damping is None or of.body not in wet:
            continue
        i, body, db = wet[of.body]
        restored = list(query.natural_inertias(about, i, body, db))
        unrestored = {*DOFS[:2]} - {dof for dof, _, _ in restored}
        yield from _ask_about_slow_damping(
            about, name, of.damping, body, query.extents(body, db), unrestored
        )
        for dof, inertia, period in restored:
            damping = float(of.damping[DOFS.index(dof), DOFS.index(dof)])
            ratio = damping * period / (4.0 * np.pi * inertia)
            if damping > 0.0 and not LEAST_RATIO <= ratio <= MOST_RATIO:
                share = query.text_outside_range(ratio, LEAST_RATIO, MOST_RATIO, ".2g")
                found_text = f"{damping:.3g}, which is {share} of critical"
                usual = "usual is 0.01 to 0.3 of critical"
                yield query.Query(
                    f"forces.{name}.damping.{dof}", found_text, usual, "Check its unit."
                )


def _ask_about_roll_forms(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about dimensions of a barge, for its roll damping, that its hull has not."""
    sizes = {body.name: query.extents(body, db) for _, body, db in about.afloat()}
    for name, of in about.scene.forces.items():
        size = sizes.get(of.body) if isinstance(of, ViscousRoll) else None
        if size is None or not isinstance(of, ViscousRoll) or of.ikeda is None:
            continue
        lengths = {
            "length": 2.0 * size.half.max(),
            "beam": 2.0 * size.half.min(),
            "draught": size.draught,
        }
        for key, length in lengths.items():
            given = float(getattr(of.ikeda, key))
            if not 1.0 / SAME_SIZE <= given / length <= SAME_SIZE:
                found_text = f"a {key} of {given:.3g} m"
                usual = f"the hull of {of.body} has about {length:.3g} m"
                yield query.Query(f"forces.{name}.ikeda.{key}", found_text, usual)


def _ask_about_fender_damping(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about dampers of contacts that are far above critical."""
    for name, of in about.scene.forces.items():
        if not isinstance(of, Contact) or not isinstance(of.normal, NormalCurve):
            continue
        mass = _mass_on_fender(about, of) / len(of.points)
        law = of.friction
        coefficients = [("normal.damping", of.normal.damping, _fender_stiffness(of))]
        if isinstance(law, StickSlip):
            coefficients.append(("friction.damping", law.damping, law.stiffness))
            coefficients.append(("friction.slip_damping", law.slip_damping, law.stiffness))
        for key, damping, stiffness in coefficients:
            critical = 2.0 * np.sqrt(stiffness * mass)
            if damping > MAX_FENDER_RATIO * critical > 0.0:
                text = f"{damping:.3g} N s/m per point, {damping / critical:.3g} times critical"
                usual = f"usual is up to {MAX_FENDER_RATIO:g} times critical"
                yield query.Query(f"forces.{name}.{key}", text, usual, "Check its unit.")


def _ask_about_slow_damping(
    about: query.SceneContext,
    name: str,
    matrix: np.ndarray,
    body: Body,
    size: query.Extents | None,
    unrestored: Collection[str],
) -> Iterator[query.Query]:
    """Ask about linear damping of surge and sway beside the mass and the length of a hull, where
    no stiffness of its own restores it."""
    if size is None:
        return
    rate = np.sqrt(about.scene.environment.gravity / (2.0 * size.half.max()))
    for k, dof in enumerate(DOFS[:2]):
        damping = float(matrix[k, k])
        ratio = damping / (body.mass * rate)
        if dof in unrestored and damping > 0.0 and not LEAST_RATIO <= ratio <= MOST_RATIO:
            share = query.text_outside_range(ratio, LEAST_RATIO, MOST_RATIO, ".2g")
            found_text = f"{damping:.3g} N s/m, {share} of m sqrt(g/L)"
            usual = f"usual is {LEAST_RATIO:g} to {MOST_RATIO:g} of that"
            yield query.Query(f"forces.{name}.damping.{dof}", found_text, usual, "Is it in kN s/m?")


def _ask_about_roll_damping(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about decay tests with less damping than radiated waves alone, or with another period."""
    rolling = ROLLS.constants_in(about.model)
    elements = [(n, e) for n, e in about.scene.forces.items() if isinstance(e, ViscousRoll)]
    for (name, element), linear_damping in zip(elements, rolling, strict=True):
        measured, waves, omega = (
            float(linear_damping[x]) for x in ("measured", "waves", "frequency")
        )
        if measured < waves and (element.p1 or element.p2 or element.p3):
            yield query.Query(
                f"forces.{name}.p1",
                f"{measured:.3g} N m s/rad of damping in all, and {waves:.3g} N m s/rad by radiated"
                " waves in the database, so that the linear part is 0",
                "the total of a decay test is the larger",
                "The roll decays faster than measured. Check loading condition and draught, or set"
                " includes_waves: false if p1 has no waves in it.",
            )
        period = 2.0 * np.pi / omega if omega > 0.0 else np.inf
        p1 = element.p1 or 0.0
        ratio = p1 * period / (4.0 * np.pi)
        if 0.0 < ratio < MIN_RATIO and not (element.p2 or element.p3):
            linear_damping = f"{p1:.3g} 1/s, which is {ratio:.2g} of critical damping"
            yield query.Query(
                f"forces.{name}.p1", linear_damping, "usual is 0.01 to 0.1 of critical"
            )
        if np.isfinite(period) and ratio > MAX_ROLL_RATIO:
            share = query.text_beyond(ratio, MAX_ROLL_RATIO, ".2g")
            linear_damping = f"{p1:.3g} 1/s, which is {share} of critical damping"
            yield query.Query(
                f"forces.{name}.p1", linear_damping, "usual is 0.01 to 0.1 of critical"
            )
        if element.period and omega > 0.0 and abs(element.period / period - 1.0) > SAME_PERIOD:
            yield query.Query(
                f"forces.{name}.period",
                f"a natural period of {element.period:.3g} s in the decay test, and of"
                f" {period:.3g} s of this body in the case",
                f"usual is a difference of at most {100.0 * SAME_PERIOD:g} % of the body's period",
                "Test and case must have the same loading condition and scale: check mass, centre"
                " of gravity and radius of gyration, and scale the test to the ship.",
            )


# Positions of fenders on a hull.

INNER = 0.8  # of length and breadth, for hulls without sides
FREEBOARD_FRACTION = 0.25  # of the draught: height above the water to which hulls have sides
FAR_SIDE = -0.3  # of the half breadth towards the plane: points behind it are at the other side
MIN_WALL_NORMAL = 0.5  # horizontal part of the normal, below which a plane is no wall
# m, or half of the breadth: largest distance of fenders and brackets from the hull
STANDING_OFF = 5.0


def ask_about_contact_points(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about fender points inside a hull, which would cross the plane before contact, or far
    outside, and about other points far off their bodies."""
    yield from ask_about_attachments(about)
    sizes = {body.name: query.extents(body, db) for _, body, db in about.floating_bodies()}
    wet = set(about.derived.databases)
    for name, fender in about.scene.forces.items():
        size = sizes.get(fender.body) if isinstance(fender, Fender) else None
        if size is None or not isinstance(fender, Fender):
            continue
        off = np.array([_distance_outside(size, point) for point in fender.points])
        far = int(np.argmax(off))
        limit = max(STANDING_OFF, float(size.half.min()))
        if off[far] > limit:
            away = query.text_beyond(off[far], limit, ".2g")
            found_text = f"point {far + 1} about {away} m outside the hull of {fender.body}"
            usual = f"usual is up to {limit:.2g} m"
            yield query.Query(f"forces.{name}.points", found_text, usual, ADVICE)
        if fender.plane.corners or not {fender.plane.body} <= {None, *wet}:
            continue
        yield from _ask_about_plane_inside(name, fender, sizes)
        normal = _normal_in_motion(about.motion, about.body_numbers, fender)
        deep = np.array([_distance_inside(size, point, normal) for point in fender.points])
        worst = int(np.argmax(deep))
        if deep[worst] > 0.0:
            where = (
                "at the far side of" if _is_far(size, fender.points[worst], normal) else "inside"
            )
            found_text = (
                f"point {worst + 1} {where} the hull of {fender.body}, which reaches about"
                f" {deep[worst]:.2g} m further towards the plane"
            )
            usual = "usual is a point at its side"
            yield query.Query(f"forces.{name}.points", found_text, usual, ADVICE)


def _ask_about_plane_inside(
    name: str, fender: Fender, sizes: Mapping[str, query.Extents | None]
) -> Iterator[query.Query]:
    """Ask about a plane at the other side of the hull that it is fixed to."""
    size = sizes.get(fender.plane.body) if fender.plane.body is not None else None
    if size is None:
        return
    towards = np.array(fender.plane.normal, float)
    point = np.array(fender.plane.point, float)
    deep = _distance_inside(size, point, -towards / np.linalg.norm(towards))
    if deep > float(size.half.min()):
        found_text = f"a plane that {fender.plane.body} exceeds by about {deep:.2g} m"
        usual = "usual is a plane at its side, with a normal that points away from it"
        yield query.Query(f"forces.{name}.plane", found_text, usual, ADVICE)


ADVICE = (
    "The size of the hull is estimated from its water plane. Points are in the body frame, from"
    " the centre of gravity."
)


def _normal_in_motion(motion: Motion, index: dict[str, int], fender: Fender) -> np.ndarray:
    """Normal of the plane in the frame of the fender's body, at the start."""
    normal = np.array(fender.plane.normal, float)
    if fender.plane.body is not None:
        normal = motion.rotation[index[fender.plane.body]] @ normal
    body_normal = motion.rotation[index[fender.body]].T @ normal
    return np.asarray(body_normal / np.linalg.norm(body_normal))


def _distance_outside(size: query.Extents, point: np.ndarray) -> float:
    """Distance of a point beside or below a hull [m]."""
    off = point - size.centre
    aside = np.maximum(np.abs(off[:2]) - query.ELLIPSE_OVER_RECTANGLE * size.half, 0.0)
    below = max(-off[2] - query.ELLIPSE_OVER_RECTANGLE * size.draught, 0.0)
    return float(np.linalg.norm([*aside, below]))


def _distance_inside(size: query.Extents, point: np.ndarray, normal: np.ndarray) -> float:
    """Distance by which a compact hull extends beyond a point inside it or at its other side,
    towards an upright plane with this ``normal`` [m]; 0 for other points."""
    x, y, z = point - size.centre
    level = float(np.linalg.norm(normal[:2]))
    if (
        z >= FREEBOARD_FRACTION * size.draught
        or size.filled < query.COMPACT
        or level < MIN_WALL_NORMAL
    ):
        return 0.0
    towards = -normal[:2] / level
    within = bool(np.all(np.abs([x, y]) < INNER * size.half)) or _is_far(size, point, normal)
    return float(np.abs(towards) @ size.half - towards @ [x, y]) if within else 0.0


def _is_far(size: query.Extents, point: np.ndarray, normal: np.ndarray) -> bool:
    """Whether a hull is between a point and an upright plane with this ``normal``."""
    x, y, _ = point - size.centre
    towards = -normal[:2] / np.linalg.norm(normal[:2])
    behind = towards @ [x, y] < FAR_SIDE * (np.abs(towards) @ size.half)
    across = np.abs(towards[0] * y - towards[1] * x)
    return bool(behind and across < INNER * (np.abs(towards) @ size.half[::-1]))
