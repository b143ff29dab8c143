"""The linear analysis of a scene as one dataset: rest, natural modes, RAOs, response in its sea.

Dimensions: body, dof, mode, heading, frequency. Angles in rad, phases of RAOs in rad for
exp(+i w t), relative to the elevation at the earth's origin.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from hydrosim.dofs import DOFS
from hydrosim.linear.equilibrium import Rest
from hydrosim.linear.linearise import Linear, natural_modes
from hydrosim.scene import Scene
from hydrosim.studies.response import Radiation, Responder, compile_for_linear, responder
from hydrosim.studies.rest import at_rest
from hydrosim.waves import Components, sea

BINS = 200  # of a response spectrum
EXPOSURE = 10800.0  # s
MOTION = ("body", "dof")


@dataclass(frozen=True)
class Wanted:
    """What to analyse: at ``time`` [s] of the applied forces; RAOs for ``headings`` [rad] at
    ``frequencies`` [rad/s], by default those of the sea and of the databases; whose added mass and
    damping; extremes of an ``exposure`` [s]."""

    time: float = 0.0
    headings: Sequence[float] = ()
    frequencies: Sequence[float] = ()
    radiation: Radiation = Radiation.MODEL
    exposure: float = EXPOSURE


def linear_analysis(scene: Scene, wanted: Wanted) -> xr.Dataset:
    """Everything linear about a scene's place at rest; raises InputError if there is none."""
    compiled = compile_for_linear(scene, wanted.radiation, wanted.time)
    seas = sea(scene.environment)
    rest = at_rest(compiled, wanted.time)
    drifted = at_rest(replace(compiled, sea=seas), wanted.time, mean_drift=True)
    about = responder(compiled, rest.state, wanted.radiation, wanted.time)
    dataset = xr.merge(
        [
            _at_rest(scene, rest, drifted),
            _modes(scene, about.linear),
            _raos(scene, about, wanted),
            _in_sea(scene, seas, about, wanted.exposure),
        ]
    )
    dataset.attrs.update(
        title=scene.title, time=wanted.time, residual=rest.residual, radiation=str(wanted.radiation)
    )
    return dataset


def _at_rest(scene: Scene, rest: Rest, drifted: Rest) -> xr.Dataset:
    """Place at rest, and how far mean drift takes the bodies from it."""
    return xr.Dataset(
        {
            "position_at_rest": (MOTION, rest.position, _motion("displacement at rest")),
            "mean_drift_offset": (
                MOTION,
                drifted.position - rest.position,
                _motion("offset by the mean second-order loads of the sea"),
            ),
        },
        coords=_bodies(scene),
    )


def _modes(scene: Scene, linear: Linear) -> xr.Dataset:
    modes = natural_modes(linear)
    shapes = np.zeros((len(modes), 6 * len(scene.bodies)), dtype=complex)
    values, vectors = np.linalg.eig(linear.jacobian)
    for shape, mode in zip(shapes, modes, strict=True):
        vector = vectors[: linear.active.size, np.argmin(np.abs(values - mode.eigenvalue))]
        shape[linear.active] = vector
        shape /= shape[mode.coordinate]
    names = [f"{scene.bodies[m.coordinate // 6].name} {m.dof}" for m in modes]
    by_body = shapes.reshape(len(modes), -1, 6)
    own = "over that of the mode's own coordinate"
    return xr.Dataset(
        {
            "natural_period": ("mode", [m.natural_period for m in modes], _said("", "s")),
            "damped_period": ("mode", [m.damped_period for m in modes], _said("", "s")),
            "damping_ratio": ("mode", [m.damping_ratio for m in modes], _said("of critical", "1")),
            "mode_amplitude": (("mode", *MOTION), np.abs(by_body), _motion(f"amplitude {own}")),
            "mode_phase": (("mode", *MOTION), np.angle(by_body), _said(f"phase {own}", "rad")),
        },
        coords={**_bodies(scene), "mode": names},
    )


def _raos(scene: Scene, about: Responder, wanted: Wanted) -> xr.Dataset:
    omega = np.array(wanted.frequencies or _frequencies(about), dtype=float)
    headings = list(wanted.headings) or _headings(scene)
    found = np.array([about.raos(heading, omega) for heading in headings])
    found = found.reshape(len(headings), omega.size, -1, 6)
    of = ("heading", "frequency", *MOTION)
    return xr.Dataset(
        {
            "rao_amplitude": (of, np.abs(found), _said("motion per wave amplitude", "m/m, rad/m")),
            "rao_phase": (of, np.angle(found), _said("phase lead over the elevation", "rad")),
        },
        coords={
            **_bodies(scene),
            "heading": ("heading", headings, _said("where the waves go to", "rad")),
            "frequency": ("frequency", omega, _said("angular frequency", "rad/s")),
        },
    )


def _in_sea(
    scene: Scene, seas: Sequence[Components], about: Responder, exposure: float
) -> xr.Dataset:
    """Spectrum and short-term statistics of every motion in the sea of the scene."""
    if not seas:
        return xr.Dataset()
    omega = np.concatenate([waves.omega for waves in seas])
    energy = 0.5 * np.abs(np.concatenate([about.motions(waves) for waves in seas])) ** 2
    m0, m2 = energy.sum(axis=0), (omega**2) @ energy
    period = 2.0 * np.pi * np.sqrt(np.divide(m0, m2, out=np.full_like(m0, np.nan), where=m2 > 0))
    largest = np.sqrt(2.0 * m0 * np.log(np.maximum(exposure / period, 1.0)))
    edges = np.linspace(0.0, omega.max(), BINS + 1)
    density = [np.histogram(omega, edges, weights=e)[0] / edges[1] for e in energy.T]

    def of(values: np.ndarray, what: str, unit: str = "m or rad") -> tuple[object, ...]:
        return (MOTION, values.reshape(-1, 6), _said(what, unit))

    return xr.Dataset(
        {
            "response_std": of(np.sqrt(m0), "standard deviation"),
            "response_period": of(period, "mean zero-crossing period", "s"),
            "response_maximum": of(largest, f"most probable maximum of {exposure:g} s"),
            "response_spectrum": (
                ("sea_frequency", *MOTION),
                np.array(density).T.reshape(BINS, -1, 6),
                _said("one-sided spectral density", "m^2 s/rad, rad s"),
            ),
        },
        coords={**_bodies(scene), "sea_frequency": 0.5 * (edges[1:] + edges[:-1])},
    )


def _frequencies(about: Responder) -> np.ndarray:
    """All frequencies of the bodies' databases."""
    databases = [body.database for body in about.bodies if body.database is not None]
    return np.unique(np.concatenate([np.zeros(0), *(db.frequency for db in databases)]))


def _headings(scene: Scene) -> list[float]:
    return sorted({train.heading for train in scene.environment.waves}) or [0.0]


def _bodies(scene: Scene) -> dict[str, object]:
    return {"body": [body.name for body in scene.bodies], "dof": list(DOFS)}


def _motion(what: str) -> dict[str, str]:
    return _said(what, "m or rad")


def _said(what: str, unit: str) -> dict[str, str]:
    return {"long_name": what, "units": unit}
