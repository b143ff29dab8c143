"""Questions about bodies: what they weigh, whether they float, how they swing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.questions.doubt import About, Doubt
from hydrosim.database.database import needed
from hydrosim.dofs import DOFS
from hydrosim.forces.applied_force import AppliedForce
from hydrosim.forces.signal import Harmonic, Signal
from hydrosim.scene import Weight
from hydrosim.tanks.loading import at_start, body_without, least_moment

MASS_TOLERANCE = 0.01  # relative difference of mass and displaced mass that is worth a word
HOPELESS = 10.0  # times heavier or lighter than what is displaced: nothing holds that
LIFTED = 0.5  # of the weight
SHORTEST, LONGEST = 1.0, 1000.0  # s, of natural periods


def mass(about: About) -> Iterator[Doubt]:
    """Bodies that do not weigh what they displace."""
    for _, body, db in about.wet():
        displaced = db.water_density * float(needed(db, "volume")[0])
        if abs(body.mass - displaced) > MASS_TOLERANCE * displaced:
            ratio = body.mass / displaced if displaced > 0.0 else np.inf
            hopeless = not 1.0 / HOPELESS < ratio < HOPELESS
            if body.weight == Weight.CARRIED and not hopeless:
                continue
            yield Doubt(
                f"bodies.{body.name}.mass",
                f"{body.mass:.4g} kg",
                f"its database displaces {displaced:.4g} kg",
                "No body of that mass floats there: look at its unit."
                if hopeless
                else "Weight and buoyancy are taken to balance.",
                hopeless,
            )


def inertia(about: About) -> Iterator[Doubt]:
    """Moments of inertia that no body has: one is at most the sum of the others."""
    for body in about.scene.bodies:
        small, middle, large = np.linalg.eigvalsh(body.inertia)
        if large > (small + middle) * (1.0 + 1e-6) and any(dof in body.dofs for dof in DOFS[3:]):
            found = f"principal moments of {small:.3g}, {middle:.3g} and {large:.3g} kg m^2"
            usual = "the largest of a rigid body is at most the sum of the others"
            yield Doubt(f"bodies.{body.name}.inertia, radii_of_gyration", found, usual)
        empty = least_moment(body, body_without(body, at_start(body.tanks)).inertia)
        if empty <= 0.0 and not body.constant_inertia:
            yield Doubt(
                f"bodies.{body.name}.inertia, radii_of_gyration",
                f"a moment of inertia of {empty:.3g} kg m^2 without what is in the tanks",
                "they are those of the body with it, and larger",
                "What is pumped out takes more than there is.",
            )


def stability(about: About) -> Iterator[Doubt]:
    """Hulls that capsize, or that no waterplane carries."""
    gravity = about.scene.environment.gravity
    for _, body, db in about.wet():
        stiffness = needed(db, "hydrostatic_stiffness")
        for dof in (3, 4):
            height = stiffness[dof, dof] / (body.mass * gravity)
            if height < 0.0 and DOFS[dof] in body.dofs:
                found = f"a metacentric height of {height:.3g} m in {DOFS[dof]}"
                usual = "usual is above 0.15 m"
                advice = "The body capsizes: look at the height of its centre of gravity."
                yield Doubt(f"bodies.{body.name}.centre_of_gravity", found, usual, advice)


def periods(about: About) -> Iterator[Doubt]:
    """Hulls that swing too fast or too slowly, each degree of freedom by itself."""
    model = about.model
    added, each = np.diag(model.added_mass), model.elements.linear_moorings
    for i, body, db in about.wet():
        moored = [e["stiffness"] for e in each if e["body"] == i]
        stiffness = np.diag(sum(moored, needed(db, "hydrostatic_stiffness")))
        inertia = np.array([body.mass] * 3 + list(np.diag(body.inertia))) + added[6 * i : 6 * i + 6]
        for dof, name in enumerate(DOFS):
            if name in body.dofs and stiffness[dof] > 0.0:
                period = 2.0 * np.pi * np.sqrt(inertia[dof] / stiffness[dof])
                if not SHORTEST <= period <= LONGEST:
                    found = f"a natural period of {period:.3g} s in {name}"
                    usual = f"usual is {SHORTEST:g} to {LONGEST:g} s"
                    advice = "Look at stiffness, mass and their units."
                    yield Doubt(f"bodies.{body.name}", found, usual, advice)


def lift(about: About) -> Iterator[Doubt]:
    """Applied forces that lift a hull out of the water, or sink it."""
    for _, body, _ in about.wet():
        if body.hydrostatics is not None:
            continue
        own = [
            _extremes(e.force["heave"], about.scene.duration)
            for e in about.scene.forces.values()
            if isinstance(e, AppliedForce) and e.body == body.name and "heave" in e.force
        ]
        weight = body.mass * about.scene.environment.gravity
        up, down = sum(high for _, high in own), -sum(low for low, _ in own)
        for force, what in ((up, "lift"), (down, "load")):
            if force > LIFTED * weight:
                found = f"applied forces that {what} by {force / weight:.0%} of the weight"
                usual = f"usual is up to {LIFTED:.0%}"
                advice = "Hydrostatics are linear, whatever is left of the hull in the water."
                out = what == "lift" and force >= weight
                yield Doubt(f"bodies.{body.name}", found, usual, advice, out)


def _extremes(signal: Signal, duration: float) -> tuple[float, float]:
    """The smallest and the largest force [N] of a signal in a run; zero is among them."""
    if isinstance(signal, Harmonic):
        found = np.array([-1.0, 1.0]) * signal.amplitude + signal.mean
    else:
        time, value = np.asarray(signal.time, float), np.asarray(signal.value, float)
        ends = np.interp([0.0, duration], time, value)
        found = np.concatenate([ends, value[time <= duration]])
    return min(float(found.min()), 0.0), max(float(found.max()), 0.0)
