"""Responses of a scene to waves in the frequency domain: RAOs, spectra, short-term extremes.

Near a position at rest, with contacts held as they are there, motions q of amplitude per wave
amplitude are

    D(w) q = X(w),   D(w) = K - w^2 (M + A(w)) + i w B(w),

K, M and the damping come from the linearised equation of motion of the scene (`linear`). A(w) and
B(w) are those of the radiation model or of the database. A Gaussian sea of density S(w) gives the
response density |q|^2 S. Its most probable largest value is that of
`hydrosim.statistics.excursions`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from scipy import linalg

from hydrosim.compiling.compile import Radiation, compile_for_linear
from hydrosim.compiling.compiled import Compiled
from hydrosim.compiling.without_waves import wave_bodies
from hydrosim.dofs import about_z
from hydrosim.forces import heights_of_wind, with_linear_rolls
from hydrosim.linear.contacts import Contacts, with_contacts
from hydrosim.linear.impedance import at_frequencies
from hydrosim.linear.linearise import Linear, linearise
from hydrosim.linear.modes import NaturalMode, modes_of_stiffness, natural_modes
from hydrosim.rigid.free import coordinate_map, positions_at, slopes_at
from hydrosim.scene import Body, Environment, Place, Scene
from hydrosim.stepping.names import contact_names
from hydrosim.streams.gusts import gust_components
from hydrosim.streams.wind import mean_wind
from hydrosim.studies.ballast.loading import state_with_contents_at
from hydrosim.studies.linear.gusts import change_with_wind
from hydrosim.waves.build import first_order
from hydrosim.waves.components import WaveComponents
from hydrosim.waves.dispersion import wavenumber
from hydrosim.waves.wave_reference import met_by_waves

if TYPE_CHECKING:
    from hydrosim.compiling.hydrodynamic_groups import HydrodynamicGroup
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.state import State
    from hydrosim.waves.body import WaveBody

MIN_RELATIVE_MOTION = 1e-12  # of the largest motion: smaller ones count as none


@dataclass(frozen=True)
class Responder:
    """A scene linearised about a state, and its ``bodies`` in waves.

    ``linear`` has all matrices; with ``databases``, it lacks added mass and damping. ``map`` S (6
    nb, n) maps velocities, v = S q', and loads, S^T F. Added mass and damping are in axes that are
    turned by the headings of the ``bodies``. ``wind_loads`` (nh, n) are the changes of loads with
    the wind speed at the ``wind_heights`` [m], see `hydrosim.studies.linear.gusts`.
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
        `hydrosim.studies.linear.gusts`."""
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
                at_frequencies(omega, db.frequency, x)
                for x in (db.added_mass, db.radiation_damping)
            )
            radiated[:, wet.dofs[:, None], wet.dofs] += -(w**2) * A + 1j * w * B
        turned = linalg.block_diag(*(about_z(b.heading) for b in self.bodies for _ in range(2)))
        along = turned.T @ self.map
        return np.asarray(D + along.T @ radiated @ along)

    def modes(self) -> list[NaturalMode]:
        """Natural modes, with the same added mass and damping."""
        if self.databases:
            return modes_of_stiffness(self.dynamic_stiffness, self.linear)
        return natural_modes(self.linear)


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
        about = _of_model(model, state, about)
    if contacts is not None:
        model, about = with_contacts(model, about, contacts, contact_names(scene))
    if roll_rates is not None:
        model = model._replace(elements=with_linear_rolls(model.elements, roll_rates))
    linear = linearise(model, about, time=time)
    n = model.bodies.active.size
    at_rest = replace(scene, bodies=tuple(map(_met_at_rest, scene.bodies)))
    databases = compiled.facts.databases
    met = wave_bodies(at_rest, databases, met_by_waves(at_rest, databases))
    place = positions_at(model.bodies, about.y[:n])
    bodies = [body.moved_by(at) for body, at in zip(met, place, strict=True)]
    groups = compiled.wet if radiation == Radiation.DATABASE else ()
    S = slopes_at(model.bodies, about.y[:n])
    displacements = coordinate_map(model.bodies, about.y[:n])
    water = scene.environment
    heights = heights_of_wind(model.elements) if water.gusts is not None else []
    loads = change_with_wind(linear, model, about, time) if heights else np.zeros((0, n))
    return Responder(
        *(linear, bodies, water, S, displacements, model.added_mass, groups),
        wind_heights=heights,
        wind_loads=loads,
    )


def _met_at_rest(body: Body) -> Body:
    loads = replace(body.wave_forces, headings=Place.MEAN, position=Place.MEAN)
    return replace(body, wave_forces=loads)


def _of_model(model: Model, state: State, start: State) -> State:
    """Position and contacts of a state at rest, for a model with another memory, with the tank
    contents at the ``start``."""
    y = np.zeros(model.size)
    n = model.bodies.active.size
    tanks = model.tanks
    held = slice(tanks.state, tanks.state + tanks.each.size)
    y[:n] = state.y[:n]
    y[held] = start.y[held]
    return state._replace(y=y)
