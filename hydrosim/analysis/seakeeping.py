"""Linear analysis of a scene as one dataset: equilibrium, natural modes, RAOs, response in its sea.

Dimensions: body, dof, mode, heading, frequency. Angles are in rad. Phases of RAOs are in rad for
exp(+i w t), relative to the elevation at the earth's origin.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import exp, sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from hydrosim.analysis import response
from hydrosim.compile.compile import Radiation, compile_for_linear
from hydrosim.compile.questions import describe_doubts
from hydrosim.compile.questions.query import describe_start
from hydrosim.dofs import DOFS
from hydrosim.elements.line.kind import CATENARY_KIND as LINES
from hydrosim.integrate.names import coordinate_at, coordinate_names, coordinates, dofs_of
from hydrosim.linear.equilibrium import RESIDUAL_RTOL, Contacts, Rest
from hydrosim.linear.modes import ModeKind, NaturalMode
from hydrosim.multibody.kinematics import are_lengths, own_coordinates
from hydrosim.results.dataset import ResultKind
from hydrosim.results.variables import describe_coordinates, describe_values
from hydrosim.scene import FreeSurface, Question, Scene
from hydrosim.statistics.gaussian import find_excursions
from hydrosim.tanks.shapes import heel_and_trim
from hydrosim.tanks.timeline import contents_at
from hydrosim.water.components import WaveComponents, sea
from hydrosim.water.radiation.threads import one_thread
from hydrosim.water.wind import REFERENCE_HEIGHT, gust_band, mean_wind, variance

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled

SPECTRUM_BINS = 200  # of a response spectrum
DEFAULT_EXPOSURE_S = 10800.0  # s
MOTION_DIMS = ("body", "dof")
QUESTIONS_OF_RUNS = frozenset({Question.STEP, Question.RAMP, Question.FALL, Question.SPEED})
"""Questions about a run over time."""
MAX_FIT_ERROR = 1e-3  # error of radiation above which RAOs may show it


@dataclass(frozen=True)
class LinearRequest:
    """Settings of an analysis: ``time`` [s] of the applied forces; RAOs for ``headings`` [rad] at
    ``frequencies`` [rad/s] (default: those of the sea and of the databases); source of added mass
    and damping; ``exposure`` [s] of extremes; state of contacts that are pressed at rest."""

    time: float = 0.0
    headings: Sequence[float] = ()
    frequencies: Sequence[float] = ()
    radiation: Radiation = Radiation.MODEL
    exposure: float = DEFAULT_EXPOSURE_S
    contacts: Contacts = Contacts.STUCK


@one_thread
def linear_analysis(scene: Scene, wanted: LinearRequest) -> xr.Dataset:
    """Linear analysis about the equilibrium of a scene. Raises InputError if directions with a
    stiffness have no equilibrium. The attribute ``remarks`` names directions without a stiffness
    and other assumptions."""
    calm = compile_for_linear(scene, wanted.radiation, wanted.time)
    compiled = replace(calm, sea=sea(scene.environment))
    rest = response.at_rest(compiled, wanted.time, free=True)
    drifted = response.at_rest(compiled, wanted.time, mean_drift=True, free=True)
    regular = [waves for waves in compiled.sea if waves.omega.size == 1]
    random = [waves for waves in compiled.sea if waves.omega.size > 1]

    def respond_at(rates: np.ndarray | None) -> response.Responder:
        state = rest.state
        return response.responder(
            compiled, state, wanted.radiation, wanted.time, wanted.contacts, roll_rates=rates
        )

    about, roll_rates = response.respond(compiled, respond_at, random)
    modes = about.natural_modes()
    answer = _unit_wave_amplitudes(scene, about, wanted)
    dataset = xr.merge(
        [
            _rest_dataset(scene, rest, drifted),
            _mode_dataset(scene, about, modes),
            _rao_dataset(scene, about, answer),
            _joint_dataset(scene, about, answer, modes),
            _regular_wave_dataset(scene, regular, about),
            _sea_dataset(scene, random, about, wanted.exposure),
            _gust_dataset(scene, about),
        ]
    )
    start = describe_start(scene, compiled.derived, compiled.state, compiled.sea, scene.duration)
    remarks = [
        *describe_doubts(start, QUESTIONS_OF_RUNS),
        *(text for group in compiled.wet for text in group.cut_lengths),
        *_radiation_fit_remarks(compiled),
        *_missing_wave_load_remarks(compiled),
        *response.rolling_remarks(compiled, roll_rates),
        *_gust_remarks(scene),
        *_line_drag_remarks(compiled),
        *_drift_remarks(scene, drifted),
        *_instability_remarks(scene, modes),
        *_free_surface_remarks(scene, rest, dataset),
        *response.contact_remarks(compiled, rest, about, wanted.contacts),
    ]
    describe_coordinates(dataset)
    dataset.attrs.update(
        kind=ResultKind.ANALYSIS.value,
        title=scene.title,
        time=wanted.time,
        residual=rest.residual,
        radiation=str(wanted.radiation),
        contacts=str(wanted.contacts),
        remarks="\n".join(remarks),
    )
    return dataset


def _radiation_fit_remarks(compiled: Compiled) -> Iterator[str]:
    """Remarks on fits that replace convolutions and are so rough that RAOs show it."""
    for group in compiled.wet:
        for fit in group.fits:
            if not (fit.report.passive and fit.report.error <= MAX_FIT_ERROR):
                yield (
                    f"the radiation of {dofs_of(fit.dofs, group.names)} uses the nearest passive"
                    f" state-space model, with an error of {fit.report.frequency_error:.1e}. RAOs"
                    " need no such model with the added mass and damping of the databases"
                    " (`--database`)."
                )


def _missing_wave_load_remarks(compiled: Compiled) -> Iterator[str]:
    for group in compiled.wet:
        if not group.read.heading.size:
            yield (
                f"{group.read.source} has no wave loads: in these RAOs only the other bodies"
                f" drive {', '.join(group.names)}."
            )


def _drift_remarks(scene: Scene, drifted: Rest) -> Iterator[str]:
    """Remark on free coordinates with mean loads but without stiffness."""
    names, lengths = coordinate_names(scene), are_lengths(drifted.model.bodies)
    weight = drifted.model.bodies.each["mass"].sum() * scene.environment.gravity
    pushed = [
        f"{names[k]} ({drifted.drift[k]:.3g} {'N' if lengths[k] else 'N m'})"
        for k in np.flatnonzero(np.abs(drifted.drift) > RESIDUAL_RTOL * weight)
    ]
    if pushed:
        yield (
            "mean loads act in directions without stiffness, and make the bodies drift:"
            f" {', '.join(pushed)}. Modes and responses are computed at the initial position and"
            " heading."
        )


def _instability_remarks(scene: Scene, modes: Sequence[NaturalMode]) -> Iterator[str]:
    for mode in modes:
        if mode.kind == ModeKind.UNSTABLE:
            yield (
                f"{_mode_name(scene, mode)} is unstable, and grows by a factor e in"
                f" {1 / mode.eigenvalue.real:.3g} s, so the responses do not last. Check its"
                " stiffness (metacentric height, line, load) and its damping."
            )


def _free_surface_remarks(scene: Scene, rest: Rest, dataset: xr.Dataset) -> Iterator[str]:
    """Remarks on free surfaces that meet bottom or top of their tanks at the angles of the
    response."""
    angles = np.abs(dataset.position_at_rest.values[:, 3:5])
    if "response_maximum" in dataset:
        angles = angles + np.nan_to_num(dataset.response_maximum.values[:, 3:5])
    p = rest.model.tanks
    volumes = rest.state.y[p.state : p.state + p.each.size]
    for b, tank, volume in contents_at(scene.bodies, volumes):
        if tank.free_surface == FreeSurface.QUASI_STATIC and volume > 0.0:
            reach = heel_and_trim(tank.shape, np.array([volume]))[0]
            for k in np.flatnonzero(angles[b] > reach):
                yield (
                    f"the free surface in {tank.name} of {scene.bodies[b].name} is taken as at"
                    f" rest, and meets bottom or top at a {('heel', 'trim')[k]} of"
                    f" {np.degrees(reach[k]):.2g} deg. The response reaches"
                    f" {np.degrees(angles[b, k]):.2g} deg, where the surface reduces stability"
                    " less. Check it with `hydrosim analyse --ballast --heel`, and run the case."
                )


def _rest_dataset(scene: Scene, rest: Rest, drifted: Rest) -> xr.Dataset:
    """Position at rest, and the offset by mean drift."""
    loads = np.zeros(6 * len(scene.bodies))
    free = own_coordinates(drifted.model.bodies)
    loads[free] = drifted.drift[: free.size]
    return xr.Dataset(
        {
            "position_at_rest": describe_values(
                MOTION_DIMS, rest.position, "displacement at rest", "m or rad"
            ),
            "mean_drift_offset": describe_values(
                MOTION_DIMS,
                drifted.position - rest.position,
                "offset by the mean second-order loads of the sea",
                "m or rad",
            ),
            "drift_load": describe_values(
                MOTION_DIMS,
                loads.reshape(-1, 6),
                "mean loads in directions without stiffness",
                "N or N m",
            ),
        },
        coords=_bodies(scene),
    )


def _mode_dataset(
    scene: Scene, about: response.Responder, modes: Sequence[NaturalMode]
) -> xr.Dataset:
    size = 6 * len(scene.bodies)
    active = about.linear.active
    is_body_coordinate = active < size  # the others are motions of joints
    shapes = np.reshape([about.displacements @ mode.shape for mode in modes], (len(modes), size))
    share = np.zeros((len(modes), size))
    for k, mode in enumerate(modes):
        share[k, active[is_body_coordinate]] = mode.share[is_body_coordinate]
    free = [mode.kind == ModeKind.FREE for mode in modes]
    dims, by_body = ("mode", *MOTION_DIMS), (len(modes), len(scene.bodies), 6)
    damping = np.where(free, np.nan, [m.damping_ratio for m in modes])
    names = [_mode_name(scene, mode) for mode in modes]
    return xr.Dataset(
        {
            "mode_kind": describe_values("mode", [str(m.kind) for m in modes], "kind of decay"),
            "natural_period": describe_values(
                "mode", [m.natural_period for m in modes], "undamped natural period", "s"
            ),
            "damped_period": describe_values(
                "mode", [m.damped_period for m in modes], "damped period", "s"
            ),
            "damping_ratio": describe_values("mode", damping, "of critical", "1"),
            "mode_shape": describe_values(
                dims, shapes.reshape(by_body), "undamped motion", "m or rad"
            ),
            "mode_share": describe_values(
                dims, share.reshape(by_body), "fraction of the kinetic energy", "1"
            ),
        },
        coords={
            **_bodies(scene),
            "mode": describe_values("mode", names, "natural mode"),
        },
    )


def _mode_name(scene: Scene, mode: NaturalMode) -> str:
    coordinate = coordinate_at(scene, mode.coordinate)
    return f"{coordinate.body} {coordinate.dof}"


class UnitWaveAmplitudes(NamedTuple):
    """Amplitudes ``free`` (nh, nw, n) of the free coordinates in waves of 1 m to the ``headings``
    (nh,) [rad] at ``omega`` (nw,) [rad/s]."""

    headings: list[float]
    omega: np.ndarray
    free: np.ndarray


def _unit_wave_amplitudes(
    scene: Scene, about: response.Responder, wanted: LinearRequest
) -> UnitWaveAmplitudes:
    omega = np.array(wanted.frequencies or _database_frequencies(about), dtype=float)
    headings = list(wanted.headings) or _headings(scene)
    free = np.array([about.unit_motions(heading, omega) for heading in headings])
    return UnitWaveAmplitudes(headings, omega, free)


def _rao_dataset(scene: Scene, about: response.Responder, answer: UnitWaveAmplitudes) -> xr.Dataset:
    headings, omega, free = answer
    motions = np.array([about.expand_amplitudes(amplitudes) for amplitudes in free])
    motions = motions.reshape(len(headings), omega.size, len(scene.bodies), 6)
    dims = ("heading", "frequency", *MOTION_DIMS)
    return xr.Dataset(
        {
            "rao_amplitude": describe_values(
                dims, np.abs(motions), "motion per wave amplitude", "m/m or rad/m"
            ),
            "rao_phase": describe_values(
                dims, np.angle(motions), "phase lead over the elevation", "rad"
            ),
        },
        coords={
            **_bodies(scene),
            "heading": describe_values("heading", headings, "heading that the waves go to", "rad"),
            "frequency": describe_values("frequency", omega, "angular frequency", "rad/s"),
        },
    )


def _joint_dataset(
    scene: Scene,
    about: response.Responder,
    answer: UnitWaveAmplitudes,
    modes: Sequence[NaturalMode],
) -> xr.Dataset:
    """RAOs of the motions of joints, and their parts in the modes."""
    if not about.joints:
        return xr.Dataset()
    joints = [f"{q.body} {q.dof}" for q in coordinates(scene)[-about.joints :]]
    motions = answer.free[:, :, -about.joints :]
    dims = ("heading", "frequency", "joint_motion")
    mode_dims = ("mode", "joint_motion")
    shape = (len(modes), about.joints)
    return xr.Dataset(
        {
            "joint_rao_amplitude": describe_values(
                dims, np.abs(motions), "motion in a joint per wave amplitude", "m/m or rad/m"
            ),
            "joint_rao_phase": describe_values(
                dims, np.angle(motions), "phase lead over the elevation", "rad"
            ),
            "joint_mode_shape": describe_values(
                mode_dims,
                np.reshape([mode.shape[-about.joints :] for mode in modes], shape),
                "undamped motion in a joint",
                "m or rad",
            ),
            "joint_mode_share": describe_values(
                mode_dims,
                np.reshape([mode.share[-about.joints :] for mode in modes], shape),
                "fraction of the kinetic energy",
                "1",
            ),
        },
        coords={"joint_motion": joints},
    )


def _regular_wave_dataset(
    scene: Scene, waves: Sequence[WaveComponents], about: response.Responder
) -> xr.Dataset:
    """Amplitude and phase of every motion in each regular wave of the scene."""
    if not waves:
        return xr.Dataset()
    motions = np.concatenate([about.motions(wave) for wave in waves]).reshape(len(waves), -1, 6)
    lead = motions / np.array([wave.amplitudes_at(0.0, 0.0)[0] for wave in waves])[:, None, None]
    dims = ("wave", *MOTION_DIMS)
    first = [(w.omega[0], w.amplitude[0], w.heading[0]) for w in waves]
    omega, amplitude, heading = np.array(first).T
    return xr.Dataset(
        {
            "regular_amplitude": describe_values(
                dims, np.abs(motions), "amplitude in a regular wave", "m or rad"
            ),
            "regular_phase": describe_values(
                dims, np.angle(lead), "phase lead over the elevation", "rad"
            ),
        },
        coords={
            **_bodies(scene),
            "wave_period": describe_values("wave", 2.0 * np.pi / omega, "period of the wave", "s"),
            "wave_amplitude": describe_values("wave", amplitude, "amplitude of the wave", "m"),
            "wave_heading": describe_values(
                "wave", heading, "heading that the wave goes to", "rad"
            ),
        },
    )


def _most_probable(m0: float, m1: float, m2: float, exposure: float) -> float:
    """Largest value of a motion that is exceeded once on average in an ``exposure`` [s]; NaN for a
    motion without a period."""
    if not m2 > 0.0:
        return np.nan
    return sqrt(m0) * find_excursions(m0, m1, m2, exposure).level(exp(-1.0))


def _sea_dataset(
    scene: Scene, seas: Sequence[WaveComponents], about: response.Responder, exposure: float
) -> xr.Dataset:
    """Spectrum and short-term statistics of every motion in the random waves of the scene."""
    if not seas:
        return xr.Dataset()
    omega = np.concatenate([waves.omega for waves in seas])
    energy = 0.5 * np.abs(np.concatenate([about.motions(waves) for waves in seas])) ** 2
    m0 = energy.sum(axis=0)
    m1 = omega @ energy
    m2 = omega**2 @ energy
    period = 2.0 * np.pi * np.sqrt(np.divide(m0, m2, out=np.full_like(m0, np.nan), where=m2 > 0))
    largest = [_most_probable(*moments, exposure) for moments in zip(m0, m1, m2, strict=True)]
    edges = np.linspace(0.0, omega.max(), SPECTRUM_BINS + 1)
    density = [np.histogram(omega, edges, weights=e)[0] / edges[1] for e in energy.T]

    def motion_variable(values: np.ndarray, what: str, unit: str = "m or rad") -> Any:
        return describe_values(MOTION_DIMS, values.reshape(-1, 6), what, unit)

    return xr.Dataset(
        {
            "response_std": motion_variable(np.sqrt(m0), "standard deviation"),
            "response_period": motion_variable(period, "mean zero-crossing period", "s"),
            "response_maximum": motion_variable(
                np.array(largest), f"most probable maximum in {exposure:g} s"
            ),
            "response_spectrum": describe_values(
                ("sea_frequency", *MOTION_DIMS),
                np.array(density).T.reshape(SPECTRUM_BINS, -1, 6),
                "one-sided spectral density",
                "m^2 s/rad or rad s",
            ),
        },
        coords={
            **_bodies(scene),
            "sea_frequency": describe_values(
                "sea_frequency",
                0.5 * (edges[1:] + edges[:-1]),
                "angular frequency of waves",
                "rad/s",
            ),
        },
    )


def _gust_dataset(scene: Scene, about: response.Responder) -> xr.Dataset:
    """Standard deviations of every motion in the gusts of the scene, without waves."""
    if scene.environment.gusts is None:
        return xr.Dataset()
    std = about.in_gusts().reshape(-1, 6)
    gusts = describe_values(
        MOTION_DIMS, std, "standard deviation in gusts, linear about the mean wind", "m or rad"
    )
    return xr.Dataset({"gust_std": gusts}, coords=_bodies(scene))


def _line_drag_remarks(compiled: Compiled) -> Iterator[str]:
    """Remark on the drag of lines, which is left out."""
    if LINES.constants_in(compiled.model).lines["width"].any():
        yield (
            "drag of mooring lines is left out, because it depends on the sea. Slow motions near"
            " their resonance are too large: simulate them."
        )


def _gust_remarks(scene: Scene) -> Iterator[str]:
    """Remark on what a linear response to gusts leaves out."""
    water = scene.environment
    if water.gusts is not None:
        wind = mean_wind(water)
        lowest, highest = gust_band(water.gusts)
        _, square, _ = variance(water.gusts.spectrum, REFERENCE_HEIGHT, wind, lowest, highest)
        yield (
            "the response to gusts is linear about the mean wind, and its variance adds to that in"
            " waves. The squares of the gusts are left out. They raise the mean wind load by about"
            f" {square / wind.hour_mean**2:.1%}."
        )


def _database_frequencies(about: response.Responder) -> np.ndarray:
    """All frequencies of the bodies' databases."""
    databases = [body.database for body in about.bodies if body.database is not None]
    return np.unique(np.concatenate([np.zeros(0), *(db.frequency for db in databases)]))


def _headings(scene: Scene) -> list[float]:
    return sorted({train.heading for train in scene.environment.waves}) or [0.0]


def _bodies(scene: Scene) -> dict[str, object]:
    return {"body": [body.name for body in scene.bodies], "dof": list(DOFS)}
