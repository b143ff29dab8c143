"""Responses of a scene to waves and gusts in the frequency domain, about its place at rest.

Near a position at rest, with contacts held as they are there, motions q of amplitude per wave
amplitude are

    D(w) q = X(w),   D(w) = K - w^2 (M + A(w)) + i w B(w),

K, M and the damping come from the linearised equation of motion of the scene (`linear`). A(w) and
B(w) are those of the radiation model or of the database. A Gaussian sea of density S(w) gives the
response density |q|^2 S. Its most probable largest value is that of
`hydrosim.statistics.gaussian`.

Response to gusts in the frequency domain, linear about the mean wind.

    D(w) q = sum_z F_z u_z(w),   F_z = dF / du_z

D(w): dynamic stiffness of the scene (`hydrosim.analysis.response`), with the damping that the
mean wind gives; u_z: amplitudes of the gusts at each height that a load feels; F_z: change of all
loads with the wind speed there. Gusts and waves are independent, so their variances add.

Limits: the square of the gusts is left out, |U + u|^2 = U^2 + 2 U u. The mean load is larger than
that of the mean wind by (s / U)^2, with the standard deviation s of the gusts.

Viscous roll damping in the frequency domain, by stochastic linearisation.

The damping B2 |p| p + B3 p^3 of a Gaussian roll rate p of standard deviation s takes the same mean
power as (sqrt(8/pi) s B2 + 3 s^2 B3) p (`hydrosim.elements.viscous_roll.linearise_damping`).
The rate depends on the damping in turn, so both are iterated in the random waves of the scene. In a
scene without random waves, the linear part B1 alone is there, for motions that are small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy import linalg

from hydrosim.analysis.ballast import state_with_contents_at
from hydrosim.compile.compile import Radiation, compile_for_linear
from hydrosim.compile.compiled import Compiled
from hydrosim.compile.waves import wave_bodies
from hydrosim.dofs import DOFS, about_z
from hydrosim.elements import heights_of_wind, in_gusts, with_linear_rolls, without_friction
from hydrosim.elements.contact.fender import normal_load_of
from hydrosim.elements.contact.geometry import EARTH, ContactKinematics, contact_kinematics
from hydrosim.elements.contact.law import STICK
from hydrosim.elements.contact.laws import COULOMB, FRICTIONLESS, friction
from hydrosim.elements.viscous_roll import VISCOUS_ROLL_KIND
from hydrosim.errors import InputError
from hydrosim.integrate.dynamics import Model, new_work, rhs
from hydrosim.integrate.names import contact_names
from hydrosim.linear import modes
from hydrosim.linear.equilibrium import (
    RESIDUAL_RTOL,
    Contacts,
    Rest,
    equilibrium,
    find_rigid_tractions,
    pressed_points,
    with_contacts,
)
from hydrosim.linear.linearise import Linear, linearise
from hydrosim.multibody.kinematics import coordinate_map, place_bodies, positions_at, slopes_at
from hydrosim.scene import Body, Environment, Place, Scene, SecondOrder, WaveForces
from hydrosim.water.build import first_order, wave_loads_model
from hydrosim.water.components import WaveComponents, sea
from hydrosim.water.displaced_loads import following_model, met_by_waves
from hydrosim.water.spectra import wavenumber
from hydrosim.water.wind import NO_GUSTS, GustTable, gust_components, mean_wind

if TYPE_CHECKING:
    from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup
    from hydrosim.integrate.state import State
    from hydrosim.water.body import WaveBody

WIND_SPEED_STEP = 1e-3  # m/s, of differences


def stiffness_change_by_wind(linear: Linear, model: Model, state: State, time: float) -> np.ndarray:
    """Change (nh, n) [N s/m, N s] of the generalised loads with the wind speed at each height."""
    n = model.bodies.active.size
    count = len(heights_of_wind(model.elements))
    work = new_work(model)
    slope = np.empty(model.size)
    change = np.zeros((count, n))
    for column in range(count):
        for sign in (1.0, -1.0):
            values = np.zeros((1, count))
            values[0, column] = sign * WIND_SPEED_STEP
            steady = GustTable(time, 1.0, 0.0, 0.0, values)
            there = model._replace(elements=in_gusts(model.elements, steady))
            rhs(time, state.y, state.modes, state.history, there, work, slope)
            change[column] += sign * slope[n : 2 * n]
    return np.asarray(change @ linear.inertia.T / (2.0 * WIND_SPEED_STEP))


MIN_RELATIVE_MOTION = 1e-12  # of the largest motion: smaller ones count as none


@dataclass(frozen=True)
class Responder:
    """A scene linearised about a state, and its ``bodies`` in waves.

    ``linear`` has all matrices; with ``databases``, it lacks added mass and damping. ``map`` S (6
    nb, n) maps velocities, v = S q', and loads, S^T F. Added mass and damping are in axes that are
    turned by the headings of the ``bodies``. ``wind_loads`` (nh, n) are the changes of loads with
    the wind speed at the ``wind_heights`` [m], see `hydrosim.analysis.response`.
    """

    linear: Linear
    bodies: Sequence[WaveBody]
    environment: Environment
    map: np.ndarray
    displacements: np.ndarray
    added_mass_infinite: np.ndarray
    databases: Sequence[HydrodynamicGroup] = ()
    wind_heights: Sequence[float] = ()
    wind_loads: np.ndarray = field(default_factory=lambda: np.zeros((0, 0)))

    def raos(self, heading: float, omega: np.ndarray) -> np.ndarray:
        """Complex amplitudes (nw, 6 nb) of all coordinates [m, rad] in waves of 1 m amplitude to
        ``heading`` [rad] at frequencies ``omega`` (nw,) [rad/s]. The time factor is exp(+i w t),
        with elevations at the earth's origin."""
        return self.expand_amplitudes(self.unit_motions(heading, omega))

    @property
    def joints(self) -> int:
        """Number of the motions of joints among the free coordinates, the last ones."""
        return int((self.linear.active >= self.map.shape[0]).sum())

    def unit_motions(self, heading: float, omega: np.ndarray) -> np.ndarray:
        """Complex amplitudes (nw, n) of the free coordinates [m, rad] in the waves of `raos`; those
        of joints come last."""
        k = wavenumber(omega, self.environment.water_depth, self.environment.gravity)
        ones = np.ones(omega.size)
        return self.free_motions(
            WaveComponents(omega, ones, 0.0 * ones, k, heading * ones, 0.0, 0.0)
        )

    def motions(self, waves: WaveComponents) -> np.ndarray:
        """Complex amplitudes (nw, 6 nb) of all coordinates [m, rad] in each of the given waves."""
        return self.expand_amplitudes(self.free_motions(waves))

    def in_gusts(self) -> np.ndarray:
        """Standard deviations (6 nb,) [m, rad] of all coordinates in the gusts of the scene, see
        `hydrosim.analysis.response`."""
        water = self.environment
        if water.gusts is None:
            return np.zeros(len(self.displacements))
        gusts = gust_components(water.gusts, mean_wind(water), self.wind_heights)
        D = self.dynamic_stiffness(gusts.omega)
        loads = gusts.amplitude @ self.wind_loads + 0j
        free = self.expand_amplitudes(self.linear.freedom.solve_motions(D, loads))
        return np.asarray(np.sqrt(0.5 * np.sum(np.abs(free) ** 2, axis=0)))

    def expand_amplitudes(self, free: np.ndarray) -> np.ndarray:
        """Amplitudes (nw, 6 nb) of all coordinates for those of the ``free`` ones (nw, n)."""
        amplitudes = free @ self.displacements.T
        amplitudes[
            np.abs(amplitudes) <= MIN_RELATIVE_MOTION * np.abs(amplitudes).max(initial=0.0)
        ] = 0.0
        return amplitudes

    def free_motions(self, waves: WaveComponents) -> np.ndarray:
        """Complex amplitudes (nw, n) of the free coordinates in each of the given waves."""
        D = self.dynamic_stiffness(waves.omega)
        return self.linear.freedom.solve_motions(D, self.loads(waves))

    def reactions(self, waves: WaveComponents) -> np.ndarray:
        """Complex amplitudes (nw, m) of the constraint forces in each of the given waves."""
        loads = self.loads(waves)
        D = self.dynamic_stiffness(waves.omega)
        q = self.linear.freedom.solve_motions(D, loads)
        return self.linear.freedom.solve_reactions((D @ q[:, :, None])[:, :, 0] - loads)

    def loads(self, waves: WaveComponents) -> np.ndarray:
        """Complex amplitudes (nw, n) of the generalised loads of each of the given waves."""
        return np.asarray(first_order(waves, self.bodies).amplitude @ self.map)

    def dynamic_stiffness(self, omega: np.ndarray) -> np.ndarray:
        """D(w), (nw, n, n), at ``omega`` (nw,) [rad/s]."""
        D = self.linear.dynamic_stiffness(omega)
        if not self.databases:
            return D
        w = omega[:, None, None]
        radiated = w**2 * self.added_mass_infinite + 0j
        for wet in self.databases:
            db = wet.database
            A, B = (
                modes.interpolate_frequencies(omega, db.frequency, x)
                for x in (db.added_mass, db.radiation_damping)
            )
            radiated[:, wet.dofs[:, None], wet.dofs] += -(w**2) * A + 1j * w * B
        turned = linalg.block_diag(*(about_z(b.heading) for b in self.bodies for _ in range(2)))
        along = turned.T @ self.map
        return np.asarray(D + along.T @ radiated @ along)

    def natural_modes(self) -> list[modes.NaturalMode]:
        """Natural modes, with the same added mass and damping."""
        if self.databases:
            return modes.modes_of_stiffness(self.dynamic_stiffness, self.linear)
        return modes.natural_modes(self.linear)


def responder(
    scene: Scene | Compiled,
    state: State | None = None,
    radiation: Radiation = Radiation.MODEL,
    time: float = 0.0,
    contacts: Contacts | None = None,
    roll_rates: np.ndarray | None = None,
) -> Responder:
    """Linearise a scene (or the output of `compile_for_linear`) about ``state``, that of its start
    or `at_rest`, with applied forces at ``time`` [s]. Contacts are as they are there, or as
    ``contacts`` sets those that are pressed there. Viscous roll damping is linear for Gaussian
    ``roll_rates`` of these standard deviations [rad/s], one per element; without them its linear
    part is taken.

    A convolution is replaced by its state-space model, and waves act on all bodies at rest. Raises
    InputError if the scene cannot be compiled, or if its contacts cannot be linearised.
    """
    compiled = scene if isinstance(scene, Compiled) else compile_for_linear(scene, radiation, time)
    scene = compiled.scene
    model = compiled.model
    about = state_with_contents_at(compiled, time)
    if state is not None:
        about = _state_for_model(model, state, about)
    if contacts is not None:
        model, about = with_contacts(model, about, contacts, contact_names(scene))
    if roll_rates is not None:
        model = model._replace(elements=with_linear_rolls(model.elements, roll_rates))
    linear = linearise(model, about, time=time)
    n = model.bodies.active.size
    at_rest = replace(scene, bodies=tuple(map(_met_at_rest, scene.bodies)))
    databases = compiled.derived.databases
    met = wave_bodies(at_rest, databases, met_by_waves(at_rest, databases))
    place = positions_at(model.bodies, about.y[:n])
    bodies = [body.moved_by(at) for body, at in zip(met, place, strict=True)]
    groups = compiled.wet if radiation == Radiation.DATABASE else ()
    S = slopes_at(model.bodies, about.y[:n])
    displacements = coordinate_map(model.bodies, about.y[:n])
    water = scene.environment
    heights = heights_of_wind(model.elements) if water.gusts is not None else []
    loads = stiffness_change_by_wind(linear, model, about, time) if heights else np.zeros((0, n))
    return Responder(
        *(linear, bodies, water, S, displacements, model.added_mass, groups),
        wind_heights=heights,
        wind_loads=loads,
    )


def _met_at_rest(body: Body) -> Body:
    loads = replace(body.wave_forces, headings=Place.MEAN, position=Place.MEAN)
    return replace(body, wave_forces=loads)


def _state_for_model(model: Model, state: State, start: State) -> State:
    """Position and contacts of a state at rest, for a model with another memory, with the tank
    contents at the ``start``."""
    y = np.zeros(model.size)
    n = model.bodies.active.size
    tanks = model.tanks
    held = slice(tanks.state, tanks.state + tanks.each.size)
    y[:n] = state.y[:n]
    y[held] = start.y[held]
    return state._replace(y=y)


# Equilibrium of a scene under its mean loads, without friction.


def at_rest(
    scene: Scene | Compiled, time: float = 0.0, mean_drift: bool = False, free: bool = False
) -> Rest:
    """Equilibrium near the start of the scene, with applied forces at ``time`` [s].

    ``mean_drift`` includes the mean second-order loads of the sea. Raises InputError with the
    remaining loads if there is no equilibrium. With ``free``, only directions with a stiffness must
    be in equilibrium. The others keep their position, and `Rest.drift` has the loads along them.
    """
    calm = (
        scene
        if isinstance(scene, Compiled)
        else compile_for_linear(scene, Radiation.DATABASE, time)
    )
    elements = in_gusts(without_friction(calm.model.elements), NO_GUSTS)
    model = calm.model._replace(elements=elements, following=following_model((), ()))
    weight = model.bodies.each["mass"].sum() * calm.scene.environment.gravity
    rest = equilibrium(model, state_with_contents_at(calm, time), time, weight)
    if mean_drift:
        model = _add_mean_drift(model, calm, time)
        rest = equilibrium(model, rest.state, time, weight, rest.held)
    if not free and np.abs(rest.drift).max(initial=0.0) > RESIDUAL_RTOL * weight:
        share = np.abs(rest.drift).max() / weight
        raise InputError(
            f"equilibrium at {time:g} s: none found, because loads of {share:.1e} of the weight"
            " act in directions without stiffness. Look for an unbalanced force, or hold the"
            " bodies by a mooring."
        )
    return rest


def _add_mean_drift(model: Model, calm: Compiled, time: float) -> Model:
    """Model with the mean second-order loads of the whole sea."""
    scene = calm.scene
    seas = calm.sea or sea(calm.scene.environment)
    pushed = replace(scene, bodies=tuple(map(_with_drift_loads_only, scene.bodies)))
    databases = calm.derived.databases
    drifting = wave_bodies(pushed, databases, met_by_waves(pushed, databases))
    steady = [replace(waves, ramp=0.0) for waves in seas]
    loads = wave_loads_model(steady, drifting, time, scene.solver.step / 2, 0.0)
    return model._replace(waves=loads)


def _with_drift_loads_only(body: Body) -> Body:
    """Body with mean second-order loads only, if it has any."""
    any_order = body.wave_forces.second_order != SecondOrder.NONE
    load = SecondOrder.MEAN_DRIFT if any_order else SecondOrder.NONE
    drift = WaveForces(False, load, headings=Place.MEAN, position=Place.MEAN)
    return replace(body, wave_forces=drift)


ROLL_INDEX = DOFS.index("roll")
MAX_ITERATIONS = 50  # iterations
RATE_RTOL = 1e-6  # relative change of the rates at which they end


def respond(
    compiled: Compiled,
    respond_at: Callable[[np.ndarray | None], Responder],
    seas: Sequence[WaveComponents],
) -> tuple[Responder, np.ndarray | None]:
    """Linearise a scene by ``respond_at`` the roll rates [rad/s] in its ``seas``, one per element
    with viscous roll damping; the rates are None if they do not matter."""
    rolling = VISCOUS_ROLL_KIND.constants_in(compiled.model)
    about = respond_at(None)
    if not seas or not (rolling["quadratic"].any() or rolling["cubic"].any()):
        return about, None
    rates = _roll_rates(about, seas, rolling["body"])
    for _ in range(MAX_ITERATIONS):
        about = respond_at(rates)
        new_rates = _roll_rates(about, seas, rolling["body"])
        if np.abs(new_rates - rates).max() <= RATE_RTOL * rates.max():
            break
        rates = np.sqrt(new_rates * rates)
    return about, rates


def _roll_rates(about: Responder, seas: Sequence[WaveComponents], bodies: np.ndarray) -> np.ndarray:
    """Standard deviations (ne,) [rad/s] of the roll rate of each of the ``bodies`` (ne,)."""
    energy = sum(
        0.5 * np.sum(np.abs(waves.omega[:, None] * about.motions(waves)) ** 2, axis=0)
        for waves in seas
    )
    return np.sqrt(np.asarray(energy)[6 * bodies + ROLL_INDEX])


def rolling_remarks(compiled: Compiled, rates: np.ndarray | None) -> Iterator[str]:
    """Remarks on viscous roll damping that is linear for the sea, or left out."""
    rolling = VISCOUS_ROLL_KIND.constants_in(compiled.model)
    if rates is not None:
        values = ", ".join(f"{np.degrees(rate):.3g}" for rate in rates)
        yield (
            "quadratic and cubic roll damping is linearised for the roll rates in this sea, of"
            f" {values} deg/s (std). RAOs and natural modes are those of this sea; another height"
            " gives others."
        )
    elif rolling["quadratic"].any() or rolling["cubic"].any():
        yield (
            "quadratic and cubic roll damping is left out, because there are no random waves to"
            " linearise it for. Roll near resonance is too large: simulate it."
        )


# Contacts that are pressed at rest: how long their state lasts in waves.

LARGEST_OVER_STD = 3.7  # standard deviations: most probable largest value of a thousand waves


class Grip(NamedTuple):
    """A contact point at rest: the `ContactKinematics`, its normal force N [N], the friction limit
    mu_s N, and the traction per displacement and per velocity along the plane."""

    contact: ContactKinematics
    normal: float
    holds: float
    stiffness: float
    damping: float


def contact_remarks(
    compiled: Compiled, rest: Rest, about: Responder, contacts: Contacts
) -> Iterator[str]:
    """Remarks on the assumed state of contacts, and on whether the waves of the scene would change
    it."""
    names = contact_names(compiled.scene)
    points = pressed_points(rest.model, rest.state)
    if not points.size:
        return
    which = _join_names([names[i] for i in points])
    if contacts != Contacts.STUCK:
        what = "slide without friction" if contacts == Contacts.SLIDING else "are taken as open"
        yield f"pressed at rest, {which} {what}, as requested."
        return
    rigid = compiled.model.elements.fenders.points["law"] == COULOMB
    how = "springs and dampers along the plane"
    if rigid[points].any():
        held = _join_names([names[i] for i in points if rigid[i]])
        how = "no motion along the plane" if rigid[points].all() else f"{how}, none at {held}"
    yield (
        f"pressed at rest, {which} hold by friction: {how}. The position at rest is computed"
        " without friction."
    )
    waves = [(w.omega, about.free_motions(w) @ about.map.T) for w in compiled.sea]
    if not waves:
        return
    omega = np.concatenate([w for w, _ in waves])
    motions = np.concatenate([x for _, x in waves])
    model, stuck = with_contacts(compiled.model, rest.state, contacts, names)
    forces = np.concatenate([about.reactions(w) for w in compiled.sea])
    held_by = find_rigid_tractions(model, stuck, forces)
    for i in points:
        point_grip = grip(int(i), compiled, rest)
        traction = _friction_traction(point_grip, int(i), compiled, omega, motions) + held_by[:, i]
        yield from _let_go(names[i], point_grip, int(i), compiled, motions, traction)


def grip(i: int, compiled: Compiled, rest: Rest) -> Grip:
    """Grip of point ``i`` at ``rest``."""
    model = compiled.model
    y = rest.state.y
    n = rest.model.bodies.active.size
    motion = new_work(model).motion
    fenders = model.elements.fenders
    place_bodies(y[:n], np.zeros(n), model.bodies, motion)
    point = fenders.points[i]
    contact = contact_kinematics(point, model.bodies, motion)
    load = normal_load_of(i, rest.time, rest.state.y, rest.state.modes, contact, fenders)
    still = (0.0, 0.0)
    slip_direction = (1.0, 0.0)
    if point["law"] == FRICTIONLESS:
        return Grip(contact, load.N, np.inf, 0.0, 0.0)
    stiffness, damping = (
        -friction(STICK, load, v, s, point).force[0]
        for v, s in ((still, slip_direction), (slip_direction, still))
    )
    return Grip(contact, load.N, float(point["static"]) * load.N, stiffness, damping)


def _relative_displacements(
    i: int, grip: Grip, compiled: Compiled, motions: np.ndarray
) -> np.ndarray:
    """Complex displacements (nw, 3) of point ``i`` relative to its plane."""
    point = compiled.model.elements.fenders.points[i]
    moved = _point_displacements(int(point["body"]), grip.contact.arm, motions)
    if point["plane_body"] != EARTH:
        moved = moved - _point_displacements(
            int(point["plane_body"]), grip.contact.plane_arm, motions
        )
    return moved


def _friction_traction(
    grip: Grip, i: int, compiled: Compiled, omega: np.ndarray, motions: np.ndarray
) -> np.ndarray:
    """Complex traction (nw, 2) of the node of point ``i``; zero for rigid friction."""
    moved = _relative_displacements(i, grip, compiled, motions)
    along = moved @ np.array([grip.contact.tangent1, grip.contact.tangent2]).T
    return np.asarray((grip.stiffness + 1j * omega * grip.damping)[:, None] * along)


def _let_go(
    name: str,
    grip: Grip,
    i: int,
    compiled: Compiled,
    motions: np.ndarray,
    traction: np.ndarray,
) -> Iterator[str]:
    """Remarks if the most probable largest value of a thousand waves of the ``traction`` (nw, 2)
    exceeds the friction limit, or that of the normal motion exceeds the compression."""
    point = compiled.model.elements.fenders.points[i]
    moved = _relative_displacements(i, grip, compiled, motions)
    apart = LARGEST_OVER_STD * float(
        np.sqrt(0.5 * np.sum(np.abs(moved @ grip.contact.normal) ** 2))
    )
    largest = LARGEST_OVER_STD * float(np.sqrt(0.5 * np.sum(np.abs(traction) ** 2, axis=0).max()))
    if largest > grip.holds:
        yield (
            f"in these waves {name} would slip: its friction would reach {largest:.3g} N, but the"
            f" limit is {grip.holds:.3g} N. The linear analysis holds for smaller waves; use"
            " `hydrosim run` for these."
        )
    if not point["prescribed"] and apart > grip.contact.compression:
        yield (
            f"in these waves {name} would open: it moves by {apart:.3g} m across the plane, but"
            f" is compressed by only {grip.contact.compression:.3g} m. The linear analysis holds"
            " for smaller waves; use `hydrosim run` for these."
        )


def _point_displacements(body: int, arm: tuple[float, ...], motions: np.ndarray) -> np.ndarray:
    """Complex displacements (nw, 3) of a body's point."""
    q = motions[:, 6 * body : 6 * body + 6]
    return np.asarray(q[:, :3] + np.cross(q[:, 3:], np.asarray(arm)))


def _join_names(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
