"""From the sea and the databases to the arrays that the kernel in `loads` reads.

Wave trains are treated separately: their loads are added, and the slow second-order loads from
the interaction of one train with another are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from hydrosim.errors import InputError
from hydrosim.scene import Environment, Jonswap, SecondOrder, WaveForces
from hydrosim.waves.components import Components, sea
from hydrosim.waves.loads import WaveLoads
from hydrosim.waves.synthesis import Grid, newman_sum, real_sum, time_grid
from hydrosim.waves.transfer import TransferFunctions, excitation_at, mean_drift_at


@dataclass(frozen=True, eq=False)
class WaveBody:
    """What the waves need to know of a body.

    ``database``: transfer functions of n loads, about the centre of gravity, for all headings;
    None for a dry body. ``location`` (2,): where the origin of the database's frame is at rest, in
    the earth's x, y [m]. ``offset``: index of the body's first DOF among those of the scene.
    ``active`` (n,): which DOFs are not locked.
    """

    database: TransferFunctions | None
    location: tuple[float, ...]
    wave_forces: WaveForces
    offset: int
    active: np.ndarray


@dataclass(frozen=True, eq=False)
class TrainLoads:
    """Loads of one wave train on the n DOFs of a scene, component by component.

    ``first`` (nw, n): complex amplitudes X a e^(i e) of the first-order loads [N, N m]; ``local``
    (nw, n): those of the elevation at the body of each DOF [m]; ``drift`` (nw, n): mean drift
    transfer functions [N/m^2, N m/m^2]; ``newman`` (n,): whether the drift load varies.
    """

    waves: Components
    first: np.ndarray
    local: np.ndarray
    drift: np.ndarray
    newman: np.ndarray

    @property
    def mean(self) -> np.ndarray:
        """Mean second-order loads sum_i D_i a_i^2, (n,)."""
        return self.waves.amplitude**2 @ self.drift


class _Rows(NamedTuple):
    """Rows of one wave train in `loads.WaveLoads`."""

    start: float
    step: float
    values: np.ndarray


def wave_loads_model(
    environment: Environment, bodies: Sequence[WaveBody], start: float, dt: float, duration: float
) -> WaveLoads:
    """Wave loads for the time from ``start`` to start + ``duration`` [s].

    They are exact at the multiples of ``dt`` [s], the distance of the solver's stages, if the
    repeat period is one of them. Raises InputError if the sea would repeat itself within the run,
    or if a database lacks the heading or the mean drift that the scene asks for.
    """
    _check_repetition(environment, start + duration)
    trains = [train_loads(waves, bodies) for waves in sea(environment)]
    first_dof = _loaded([train.first for train in trains])
    second_dof = _loaded([train.drift for train in trains])
    parts = [
        _regular(train, first_dof, second_dof)
        if train.waves.spacing == 0.0
        else _irregular(train, time_grid(train.waves, start, dt, duration), first_dof, second_dof)
        for train in trains
    ]
    none = np.zeros((0, 1 + first_dof.size + second_dof.size))
    return WaveLoads(
        start=np.array([part.start for part in parts], dtype=float),
        step=np.array([part.step for part in parts], dtype=float),
        ramp=np.array([train.waves.ramp for train in trains], dtype=float),
        regular=np.array([train.waves.spacing == 0.0 for train in trains], dtype=bool),
        offset=np.cumsum([0, *(part.values.shape[0] for part in parts)]),
        values=np.concatenate([none, *(part.values for part in parts)]),
        first_dof=first_dof,
        second_dof=second_dof,
    )


def train_loads(waves: Components, bodies: Sequence[WaveBody]) -> TrainLoads:
    """Loads of one wave train on all DOFs of the bodies; zero where locked or not wanted."""
    size = max((body.offset + body.active.size for body in bodies), default=0)
    shape = (waves.omega.size, size)
    first, local, drift = np.zeros(shape, complex), np.zeros(shape, complex), np.zeros(shape)
    newman = np.zeros(size, dtype=bool)
    for body in bodies:
        dofs = slice(body.offset, body.offset + body.active.size)
        local[:, dofs] = waves.at(*body.location)[:, None]
        if body.database is None:
            continue
        if body.wave_forces.first_order:
            transfer = excitation_at(body.database, waves.heading, waves.omega)
            first[:, dofs] = local[:, dofs] * transfer * body.active
        if body.wave_forces.second_order != SecondOrder.NONE:
            transfer = mean_drift_at(body.database, waves.heading, waves.omega)
            drift[:, dofs] = transfer * body.active
            newman[dofs] = body.wave_forces.second_order == SecondOrder.NEWMAN
    return TrainLoads(waves, first, local, drift, newman)


def _check_repetition(environment: Environment, end: float) -> None:
    for train in environment.waves:
        if isinstance(train.spectrum, Jonswap) and end > train.repeat_period * (1.0 + 1e-9):
            raise InputError(
                f"environment.waves.repeat_period: {train.repeat_period:g} s is shorter than the"
                f" run, which ends at {end:g} s, so that the sea would repeat itself; raise it to"
                " that or more"
            )


def _loaded(amplitudes: list[np.ndarray]) -> np.ndarray:
    """DOFs (m,) on which any wave train has a load, out of the n of ``amplitudes`` (nw, n)."""
    return np.flatnonzero(np.any([np.any(a != 0.0, axis=0) for a in amplitudes], axis=0))


def _irregular(
    train: TrainLoads, grid: Grid, first_dof: np.ndarray, second_dof: np.ndarray
) -> _Rows:
    """A table on the grid."""
    first = real_sum(grid, train.waves, _with_elevation(train, first_dof))
    slow = np.tile(train.mean[second_dof], (grid.rows, 1))
    varying = train.newman[second_dof]
    dofs = second_dof[varying]
    slow[:, varying] = newman_sum(grid, train.waves, train.local[:, dofs], train.drift[:, dofs])
    return _Rows(grid.start, grid.step, np.hstack([first, slow]))


def _regular(train: TrainLoads, first_dof: np.ndarray, second_dof: np.ndarray) -> _Rows:
    """One component: real part, imaginary part, and the drift load, which is constant."""
    amplitude = _with_elevation(train, first_dof)[0]
    values = np.zeros((3, amplitude.size + second_dof.size))
    values[0, : amplitude.size] = amplitude.real
    values[1, : amplitude.size] = amplitude.imag
    values[2, amplitude.size :] = train.mean[second_dof]
    return _Rows(0.0, 1.0 / train.waves.omega[0], values)


def _with_elevation(train: TrainLoads, dofs: np.ndarray) -> np.ndarray:
    """Complex amplitudes of the elevation at the earth's origin and of the loads on ``dofs``."""
    return np.hstack([train.waves.at(0.0, 0.0)[:, None], train.first[:, dofs]])
