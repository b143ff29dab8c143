"""Questions about bodies: mass, flotation, natural periods, hulls, drag and neighbours."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from hydrosim.compile.questions import query
from hydrosim.database.database import HydroDatabase, require_array
from hydrosim.dofs import DOFS
from hydrosim.scene import Body, Question, Weight
from hydrosim.scene.body import Box
from hydrosim.scene.damping import QuadraticDamping
from hydrosim.scene.loads import AppliedForce
from hydrosim.scene.signal import Harmonic, Signal
from hydrosim.tanks.timeline import body_without, least_moment, tanks_at_start

MASS_TOLERANCE = 0.01  # relative difference of mass and displaced mass that needs a question
HOPELESS = 10.0  # ratio of mass to displaced mass, or its inverse, that no mooring can hold
LIFTED = 0.5  # of the weight
MIN_NATURAL_PERIOD_S, MAX_NATURAL_PERIOD_S = 1.0, 1000.0  # s, of natural periods
TILT = np.radians(0.3)  # largest heel or trim by its own weight of a body that is afloat level
LIGHTEST = 1.2  # kg/m^3
SMALLEST_RADIUS = 0.01  # of that of a hull with all its mass at its ends
LARGER = 1.25  # ratio: rounding, above the radius of gyration of a body with all mass at its ends


def ask_about_mass(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about bodies whose mass differs from their displacement."""
    afloat = {body.name for _, body, _ in about.afloat()}
    for _, body, db in about.floating_bodies():
        held = body.weight == Weight.CARRIED and body.name not in afloat
        displaced = _displaced_mass(db)
        hopeless = _is_hopeless(body, displaced)
        if _is_mass_doubtful(body, db) and (hopeless or not held):
            yield query.Query(
                f"bodies.{body.name}.mass",
                f"{body.mass:.4g} kg",
                f"a displaced mass of {displaced:.4g} kg in its database",
                "No body of that mass floats there: check its unit."
                if hopeless
                else "Weight and buoyancy are assumed to balance. If lines or contacts carry the"
                " difference, write `weight: carried`.",
                hopeless and not held,
            )


def _displaced_mass(db: HydroDatabase) -> float:
    """Mass of the water that a body displaces [kg]."""
    return db.water_density * float(require_array(db, "volume")[0])


def _is_hopeless(body: Body, displaced: float) -> bool:
    """Whether no body of this mass floats at this displacement."""
    ratio = body.mass / displaced if displaced > 0.0 else np.inf
    return not 1.0 / HOPELESS < ratio < HOPELESS


def _is_mass_doubtful(body: Body, db: HydroDatabase) -> bool:
    """Whether the mass differs from the displacement, and nothing carries the difference."""
    displaced = _displaced_mass(db)
    differs = abs(body.mass - displaced) > MASS_TOLERANCE * displaced
    return differs and (body.weight != Weight.CARRIED or _is_hopeless(body, displaced))


def _is_mass_asked(about: query.SceneContext, body: Body, db: HydroDatabase) -> bool:
    """Whether `mass` asks about a body, because the user does not accept the question."""
    return Question.MASS not in about.scene.accept and _is_mass_doubtful(body, db)


def ask_about_inertia(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about moments of inertia that no rigid body has: one exceeds the sum of the others."""
    for body in about.scene.bodies:
        small, middle, large = np.linalg.eigvalsh(body.inertia)
        if large > (small + middle) * (1.0 + 1e-6) and any(dof in body.dofs for dof in DOFS[3:]):
            found_text = f"principal moments of {small:.3g}, {middle:.3g} and {large:.3g} kg m^2"
            usual = "the largest moment of a rigid body is at most the sum of the others"
            yield query.Query(f"bodies.{body.name}.inertia, radii_of_gyration", found_text, usual)
        empty = least_moment(body, body_without(body, tanks_at_start(body.tanks)).inertia)
        if empty <= 0.0 and not body.constant_inertia:
            yield query.Query(
                f"bodies.{body.name}.inertia, radii_of_gyration",
                f"a moment of inertia of {empty:.3g} kg m^2 without the contents of tanks",
                "the moments include the contents of tanks and are larger",
                "The contents that are pumped out have more inertia than the body.",
            )
    yield from _ask_about_radii(about)
    yield from _ask_about_densities(about)


def _ask_about_densities(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about dry bodies that turn and are lighter than air, by the box of their radii of
    gyration."""
    for body in about.scene.bodies:
        if not any(dof in body.dofs for dof in DOFS[3:]):
            continue
        squares = 3.0 * np.linalg.eigvalsh(body.inertia) / body.mass
        half = np.sqrt(np.maximum(squares.sum() / 2.0 - squares, 0.0))
        density = body.mass / (8.0 * np.prod(half)) if np.all(half > 0.0) else np.inf
        if body.name not in about.derived.databases and density < LIGHTEST:
            found_text = (
                f"radii of gyration of a box of {2.0 * half.max():.3g} m and {density:.2g} kg/m^3"
            )
            usual = f"usual is above {LIGHTEST:g} kg/m^3, the density of air"
            key = f"bodies.{body.name}.inertia, radii_of_gyration"
            yield query.Query(key, found_text, usual, "Are the radii in mm?")


def _ask_about_radii(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about radii of gyration that exceed the size of the hull, or that are a small part of
    it."""
    for _, body, db in about.floating_bodies():
        size = query.extents(body, db)
        if size is None:
            continue
        ends = np.square([*size.half, size.draught])
        largest = np.sqrt(ends.sum() - ends)
        radii = np.sqrt(np.maximum(np.diag(body.inertia), 0.0) / body.mass)
        for name, radius, limit in zip(DOFS[3:], radii, largest, strict=True):
            if name in body.dofs and radius > LARGER * limit:
                yield query.Query(
                    f"bodies.{body.name}.inertia, radii_of_gyration",
                    f"a radius of gyration of {query.text_beyond(radius, limit)} m in {name}",
                    f"a hull of this size with all its mass at its ends has {limit:.3g} m",
                    "Is it in feet? Then give it the unit ft.",
                )
            elif name in body.dofs and radius < SMALLEST_RADIUS * limit:
                yield query.Query(
                    f"bodies.{body.name}.inertia, radii_of_gyration",
                    f"a radius of gyration of {radius:.3g} m in {name}",
                    f"usual is above {SMALLEST_RADIUS * limit:.3g} m for a hull of this size",
                    "Check its unit.",
                )


def ask_about_trim(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about hulls that float level although weight and buoyancy are not on one vertical."""
    for _, body, db in about.afloat():
        if body.weight == Weight.CARRIED or db.centre_of_buoyancy is None:
            continue
        weight = body.mass * about.scene.environment.gravity
        off = np.array(body.centre_of_gravity) - db.centre_of_buoyancy[0]
        moment = weight * np.array([0.0, -off[1], off[0]])
        tilt = _static_tilt(body, require_array(db, "hydrostatic_stiffness"), moment)
        if np.abs(tilt).max() > TILT:
            limit = float(np.degrees(TILT))
            roll, pitch = (
                query.text_beyond(angle, np.copysign(limit, angle), ".2g")
                for angle in np.degrees(tilt)
            )
            yield query.Query(
                f"bodies.{body.name}.centre_of_gravity",
                f"{off[0]:.3g} m along x and {off[1]:.3g} m along y from the centre of buoyancy"
                f" of its database, which would cause a roll of {roll} deg and a pitch of"
                f" {pitch} deg",
                f"usual is up to {limit:.2g} deg",
                "The simulation starts level, because weight: balanced cancels that moment. Move"
                " one of the two centres, or use weight: carried.",
            )


def _static_tilt(body: Body, stiffness: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """Roll and pitch (2,) [rad] of a hull under a ``moment`` (3,) on heave, roll, pitch; zero for a
    hull that would capsize."""
    free = np.array([k for k in range(3) if DOFS[2 + k] in body.dofs], dtype=int)
    angles = np.zeros(3)
    free_stiffness = stiffness[2:5, 2:5][np.ix_(free, free)]
    if free.size and np.linalg.eigvalsh(free_stiffness)[0] > 0.0:
        angles[free] = np.linalg.solve(free_stiffness, moment[free])
    return angles[1:]


def ask_about_stability(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about hulls that capsize, or whose centre of gravity is a draught above the water."""
    yield from _ask_about_high_centres(about)
    gravity = about.scene.environment.gravity
    for _, body, db in about.afloat():
        stiffness = require_array(db, "hydrostatic_stiffness")
        for dof in (3, 4):
            height = stiffness[dof, dof] / (body.mass * gravity)
            if height < 0.0 and DOFS[dof] in body.dofs:
                found_text = f"a metacentric height of {height:.3g} m in {DOFS[dof]}"
                usual = "usual is above 0.15 m"
                advice = "The body capsizes: check the height of its centre of gravity."
                yield query.Query(
                    f"bodies.{body.name}.centre_of_gravity", found_text, usual, advice
                )


def _ask_about_high_centres(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about closed hulls with a centre of gravity more than a draught above the water."""
    for _, body, db in about.afloat():
        size = query.extents(body, db)
        height = body.centre_of_gravity[2]
        capsizes = np.any(np.diag(require_array(db, "hydrostatic_stiffness"))[3:5] < 0.0)
        if size is None or size.filled < query.COMPACT or capsizes:
            continue
        if height > size.draught:
            found_text = (
                f"a centre of gravity {query.text_beyond(height, size.draught)} m above the water"
            )
            usual = f"usual is less than the draught of about {size.draught:.3g} m above it"
            advice = (
                "Is it the height above the keel? z counts from the origin of the database,"
                " which is in the still water."
            )
            yield query.Query(f"bodies.{body.name}.centre_of_gravity", found_text, usual, advice)


def ask_about_natural_periods(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about natural periods that are too short or too long, for each degree of freedom by
    itself."""
    for i, body, db in about.afloat():
        for name, period in query.natural_periods(about, i, body, db).items():
            if not MIN_NATURAL_PERIOD_S <= period <= MAX_NATURAL_PERIOD_S:
                text = query.text_outside_range(period, MIN_NATURAL_PERIOD_S, MAX_NATURAL_PERIOD_S)
                found_text = f"a natural period of {text} s in {name}"
                usual = f"usual is {MIN_NATURAL_PERIOD_S:g} to {MAX_NATURAL_PERIOD_S:g} s"
                advice = "Check stiffness, mass and their units."
                yield query.Query(f"bodies.{body.name}", found_text, usual, advice)


def ask_about_lift(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about applied forces that lift a hull out of the water, or sink it, or that push it with
    more than its weight."""
    for _, body, db in about.floating_bodies():
        yield from _ask_about_sideways_forces(about, body)
        if body.hydrostatics is not None or _is_mass_asked(about, body, db):
            continue  # with another mass, the weight is another
        extremes = [
            _extremes_of_signal(e.force["heave"], about.scene.duration)
            for e in about.scene.forces.values()
            if isinstance(e, AppliedForce) and e.body == body.name and "heave" in e.force
        ]
        weight = body.mass * about.scene.environment.gravity
        up, down = sum(high for _, high in extremes), -sum(low for low, _ in extremes)
        for force, what in ((up, "lift"), (down, "load")):
            if force > LIFTED * weight:
                share = query.text_beyond(force / weight, LIFTED, ".0%")
                found_text = f"applied forces that {what} by {share} of the weight"
                usual = f"usual is up to {LIFTED:.0%}"
                advice = (
                    "Hydrostatics are linear, and ignore how much of the hull is left in the water."
                )
                out = what == "lift" and force >= weight
                yield query.Query(f"bodies.{body.name}", found_text, usual, advice, out)


def _ask_about_sideways_forces(about: query.SceneContext, body: Body) -> Iterator[query.Query]:
    """Ask about applied forces along the water that exceed the weight."""
    weight = body.mass * about.scene.environment.gravity
    for name, of in about.scene.forces.items():
        if isinstance(of, AppliedForce) and of.body == body.name:
            for dof in DOFS[:2]:
                ends = (
                    _extremes_of_signal(of.force[dof], about.scene.duration)
                    if dof in of.force
                    else (0.0,)
                )
                most = max(map(abs, ends))
                if most > weight:
                    found_text = (
                        f"{query.text_beyond(most, weight)} N, for a weight of {weight:.3g} N"
                    )
                    usual = "usual is a force along the water far below the weight"
                    yield query.Query(
                        f"forces.{name}.force.{dof}", found_text, usual, "Check its unit."
                    )


def _extremes_of_signal(signal: Signal, duration: float) -> tuple[float, float]:
    """Smallest and largest force [N] of a signal in a run; zero is included."""
    if isinstance(signal, Harmonic):
        range_ends = np.array([-1.0, 1.0]) * signal.amplitude + signal.mean
    else:
        time, value = signal.time, signal.value
        ends = np.interp([0.0, duration], time, value)
        range_ends = np.concatenate([ends, value[time <= duration]])
    return min(float(range_ends.min()), 0.0), max(float(range_ends.max()), 0.0)


# Hulls and tanks beside the centre of gravity, and drag beside a hull.

# Drag over 0.5 rho times the projected area under water: surge, sway, heave. A ship in surge has
# little more than friction; a flat plate has about 2, edges and bilge keels more
# in yaw, of cross flow over the length: T L^4 / 32 in place of the area
LEAST_DRAG = {"surge": 0.001, "sway": 0.02, "heave": 0.02, "yaw": 0.005}
MOST_DRAG = 30.0
TANK_MARGIN = 0.5  # of the half length and breadth of the water plane


def ask_about_hulls(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about hulls aside of the centre of gravity, and about tanks far outside a hull."""
    for body in about.scene.bodies:
        if body.hydrostatics is None:
            continue
        corners = body.hydrostatics.corners.reshape(-1, 3)[:, :2]
        low, high = corners.min(axis=0), corners.max(axis=0)
        centre = np.array(body.centre_of_gravity[:2])
        off = float(np.linalg.norm(np.maximum(np.maximum(low - centre, centre - high), 0.0)))
        size = float(np.linalg.norm(high - low))
        if off > 0.5 * size:
            yield query.Query(
                f"bodies.{body.name}.hydrostatics",
                f"a hull {query.text_beyond(off, 0.5 * size)} m aside of the centre of gravity of"
                f" {body.name}",
                "usual is a centre of gravity above or within the hull",
                "Its file is in the frame of centre_of_gravity; location moves both.",
            )
    for _, body, db in about.floating_bodies():
        size_of = query.extents(body, db)
        for tank in body.tanks:
            if size_of is None or not isinstance(tank.shape, Box):
                continue
            middle = np.mean([tank.shape.low, tank.shape.high], axis=0) - body.centre_of_gravity
            aside = np.abs(middle - size_of.centre)[:2] / size_of.half
            if aside.max() > 1.0 + TANK_MARGIN:
                axis = int(aside.argmax())
                found_text = (
                    f"a tank whose middle is {aside[axis] * size_of.half[axis]:.3g} m from the"
                    f" middle of the water plane along {'xy'[axis]}"
                )
                usual = f"usual is up to {size_of.half[axis]:.3g} m, half of its size"
                yield query.Query(f"bodies.{body.name}.tanks.{tank.name}", found_text, usual)


def ask_about_drag(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about quadratic damping that is not that of a hull of this size."""
    density = about.scene.environment.water_density
    wet = {body.name: (body, db) for _, body, db in about.floating_bodies()}
    for name, of in about.scene.forces.items():
        if not isinstance(of, QuadraticDamping) or of.body not in wet:
            continue
        size = query.extents(*wet[of.body])
        if size is None:
            continue
        length, breadth = 2.0 * size.half
        areas = {
            "surge": (breadth * size.draught, "m^2"),
            "sway": (length * size.draught, "m^2"),
            "heave": (length * breadth, "m^2"),
            "yaw": (size.draught * max(length, breadth) ** 4 / 32.0, "m^5"),
        }
        for dof, (area, unit) in areas.items():
            least = LEAST_DRAG[dof]
            k = DOFS.index(dof)
            coefficient_given = float(of.damping[k, k])
            coefficient = coefficient_given / (0.5 * density * area)
            if coefficient_given > 0.0 and not least <= coefficient <= MOST_DRAG:
                text = query.text_outside_range(coefficient, least, MOST_DRAG, ".2g")
                yield query.Query(
                    f"forces.{name}.damping.{dof}",
                    f"{coefficient_given:.3g}, a drag coefficient of {text} on {area:.3g} {unit}",
                    f"usual is {least:g} to {MOST_DRAG:g}",
                    "Is it in kN?",
                )


# Hulls close to each other.

NEIGHBOUR_BREADTHS = 2.0  # times the larger breadth
DIRECTIONS = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
DIRECTION_VECTORS = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)], axis=1)


def ask_about_shielding(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about hulls close to each other in waves whose databases do not include each other."""
    if not about.sea:
        return
    sizes = {
        body.name: query.extents(body, db)
        for body in about.scene.bodies
        if (db := about.derived.databases.get(body.name)) is not None and db.heading.size
    }
    sized_bodies = [body for body in about.scene.bodies if sizes.get(body.name)]
    for body, neighbour in combinations(sized_bodies, 2):
        first, second = sizes[body.name], sizes[neighbour.name]
        if (
            first is None
            or second is None
            or _share_database(body, neighbour)
            or not (body.dofs or neighbour.dofs)
        ):
            continue
        breadth = 2.0 * max(first.half.min(), second.half.min())
        gap = _gap_between_bodies(about, (body, first), (neighbour, second))
        if gap < NEIGHBOUR_BREADTHS * breadth:
            length = query.peak_wavelength(about.sea)
            yield query.Query(
                f"bodies.{body.name}, bodies.{neighbour.name}",
                f"hulls with separate databases that are {_gap_text(gap)}, with a breadth of"
                f" {breadth:.3g} m and waves of {length:.3g} m",
                f"usual is more than {NEIGHBOUR_BREADTHS:g} breadths",
                "Neither hull shields the other from waves, and neither feels the waves radiated"
                " by the other. Compute one database of both with `hydrosim db build` (bodies:"
                " in the recipe).",
            )


def _gap_text(gap: float) -> str:
    return f"about {gap:.3g} m apart" if gap > 0.0 else "overlapping in plan"


def _share_database(body: Body, neighbour: Body) -> bool:
    """Whether two bodies belong to one database."""
    places = ((tuple(b.location), b.heading, b.hydrodynamics) for b in (body, neighbour))
    first, second = places
    return first == second and body.database_body != neighbour.database_body


def _gap_between_bodies(
    about: query.SceneContext, first: tuple[Body, query.Extents], second: tuple[Body, query.Extents]
) -> float:
    """Distance of the rectangles of two hulls at the start [m]; 0 if they overlap."""
    middles, reaches = zip(
        *(_projected_extents(about, *body_and_size) for body_and_size in (first, second)),
        strict=True,
    )
    apart = DIRECTION_VECTORS @ (middles[1] - middles[0]) - reaches[0] - reaches[1]
    return max(float(apart.max()), 0.0)


def _projected_extents(
    about: query.SceneContext, body: Body, size: query.Extents
) -> tuple[np.ndarray, np.ndarray]:
    """Centre of a hull's rectangle (2,), and its extent from there in all directions
    `DIRECTION_VECTORS`."""
    b = about.body_numbers[body.name]
    R = about.motion.rotation[b]
    middle = (about.centre(b) + R @ size.centre)[:2]
    return middle, np.abs(DIRECTION_VECTORS @ R[:2, :2]) @ size.half
