"""Arrays for the kernel in `loads`, made from the sea and the databases.

The sea is one or several sets of waves, see `components.sea`. The loads of the sets are added.
Second-order loads from pairs of waves in different sets are left out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.scene import SecondOrder
from hydrosim.water.body import WaveBody, turned_bodies
from hydrosim.water.displaced_loads import is_followed_by_waves
from hydrosim.water.loads import SpectralLines, WaveLoads, add_sum, time_grid
from hydrosim.water.quadratic_loads import has_moving_second_order
from hydrosim.water.second_order import (
    Factors,
    QuadraticFunctions,
    difference_factors,
    difference_loads,
    mean_load,
    newman,
    newman_square_root,
    sum_factors,
    sum_loads,
)
from hydrosim.water.transfer import excitation_at, mean_drift_at

if TYPE_CHECKING:
    from hydrosim.water.components import WaveComponents


def wave_loads_model(
    seas: Sequence[WaveComponents],
    bodies: Sequence[WaveBody],
    start: float,
    dt: float,
    duration: float,
) -> WaveLoads:
    """Loads of all ``seas`` from ``start`` to start + ``duration`` [s]. No sea may repeat within
    that time, see `components.check_span`.

    Loads are exact at the multiples of ``dt`` [s], the distance of the solver's stages, if the
    repeat period is such a multiple and the waves do not permit a coarser table, see `loads`.
    Raises InputError if a database lacks the heading, the mean drift or the QTF that the scene asks
    for.
    """
    first = [first_order(waves, bodies) for waves in seas]
    second = [second_order(waves, bodies) for waves in seas]
    first_dof, second_dof = (
        _loaded_dofs(first),
        _loaded_dofs([line for lines in second for line in lines]),
    )
    widths = (1, first_dof.size, second_dof.size)
    tables, singles = [], []
    for waves, first_lines, second_lines in zip(seas, first, second, strict=True):
        columns = [
            [SpectralLines(waves.omega, waves.amplitudes_at(0.0, 0.0)[:, None])],
            [first_lines.restrict_columns(first_dof)],
            [line.restrict_columns(second_dof) for line in second_lines],
        ]
        if waves.spacing > 0.0:
            tables.append(_time_table(waves, columns, widths, start, dt, duration))
        else:
            singles.append(_spectral_lines(waves, columns, widths))
    return WaveLoads(
        start=np.array([at for at, _, _, _ in tables], dtype=float),
        step=np.array([step for _, step, _, _ in tables], dtype=float),
        ramp=np.array([ramp for _, _, ramp, _ in tables], dtype=float),
        offset=np.cumsum([0, *(len(values) for *_, values in tables)]),
        values=_stack_rows([values for *_, values in tables], sum(widths)),
        omega=np.concatenate([np.zeros(0), *(omega for omega, _, _ in singles)]),
        line_ramp=np.concatenate([np.zeros(0), *(ramp for _, ramp, _ in singles)]),
        lines=np.concatenate([np.zeros((0, 2, sum(widths))), *(values for *_, values in singles)]),
        first_dof=first_dof,
        second_dof=second_dof,
        turned=turned_bodies(bodies),
    )


def first_order(waves: WaveComponents, bodies: Sequence[WaveBody]) -> SpectralLines:
    """First-order loads X a exp(i e) of each wave on all DOFs of the bodies. They are zero for
    locked DOFs, where none are asked for, and where waves follow the body (`FollowingLoads`)."""
    total = np.zeros((waves.omega.size, _size(bodies)), dtype=complex)
    for body in bodies:
        if (
            body.database is not None
            and body.wave_forces.first_order
            and not is_followed_by_waves(body)
        ):
            transfer = excitation_at(body.database, body.relative_waves(waves).heading, waves.omega)
            elevation = waves.amplitudes_at(*body.location)[:, None]
            total[:, _dofs_of_body(body)] = elevation * body.in_earth_axes(transfer) * body.active
    return SpectralLines(waves.omega, total)


def second_order(waves: WaveComponents, bodies: Sequence[WaveBody]) -> list[SpectralLines]:
    """Second-order loads of each body on its own DOFs. They are zero for locked DOFs; there are
    none where none are asked for, and where the waves follow the body (`quadratic_loads`)."""
    lines = []
    for body in bodies:
        if body.database is not None and not (
            is_followed_by_waves(body) and has_moving_second_order(body)
        ):
            for body_lines in _second_order(waves, body, body.database):
                load = np.where(body.active, body.in_earth_axes(body_lines.amplitude), 0.0)
                lines.append(SpectralLines(body_lines.omega, load, body.offset))
    return lines


def _second_order(
    waves: WaveComponents, body: WaveBody, database: QuadraticFunctions
) -> list[SpectralLines]:
    """Slow and fast loads on the DOFs of one body, in its heading axes."""
    elevation, wanted = waves.amplitudes_at(*body.location), body.wave_forces
    waves = body.relative_waves(waves)
    slow: list[SpectralLines] = []
    match wanted.second_order:
        case SecondOrder.MEAN_DRIFT:
            slow = [mean_load(elevation, mean_drift_at(database, waves.heading, waves.omega))]
        case SecondOrder.NEWMAN | SecondOrder.NEWMAN_SQUARE_ROOT | SecondOrder.QTF:
            slow = [difference_loads(waves, elevation, _slow_factors(waves, body, database))]
    if wanted.sum_frequency:
        return [*slow, sum_loads(waves, elevation, sum_factors(database, waves))]
    return slow


def _slow_factors(waves: WaveComponents, body: WaveBody, database: QuadraticFunctions) -> Factors:
    if body.wave_forces.second_order == SecondOrder.QTF:
        return difference_factors(database, waves)
    drift = mean_drift_at(database, waves.heading, waves.omega)
    plain = body.wave_forces.second_order == SecondOrder.NEWMAN
    return newman(drift) if plain else newman_square_root(drift)


def _size(bodies: Sequence[WaveBody]) -> int:
    return max((body.offset + body.active.size for body in bodies), default=0)


def _dofs_of_body(body: WaveBody) -> slice:
    return slice(body.offset, body.offset + body.active.size)


def _loaded_dofs(lines: Sequence[SpectralLines]) -> np.ndarray:
    """DOFs (m,) on which any of the lines has a load."""
    return np.unique(
        np.concatenate(
            [np.zeros(0, dtype=int), *(body_lines.loaded_columns for body_lines in lines)]
        )
    )


def _time_table(
    waves: WaveComponents,
    columns: list[list[SpectralLines]],
    widths: tuple[int, ...],
    start: float,
    dt: float,
    duration: float,
) -> tuple[float, float, float, np.ndarray]:
    """Start, step and ramp of a table, and its rows, the sums of the lines of every column."""
    highest = max(line.highest for lines in columns for line in lines)
    grid = time_grid(waves.spacing, highest, start, dt, duration)
    values = np.zeros((grid.rows, sum(widths)))
    ends = np.cumsum((0, *widths))
    for k, lines in enumerate(columns):
        for line in lines:
            add_sum(grid, line, values[:, ends[k] : ends[k + 1]])
    return grid.start, grid.step, waves.ramp, values


def _stack_rows(tables: Sequence[np.ndarray], width: int) -> np.ndarray:
    """The rows of all tables. A single table is not copied, because tables of long runs are
    large."""
    if len(tables) == 1:
        return tables[0]
    return np.concatenate([np.zeros((0, width)), *tables])


def _spectral_lines(
    waves: WaveComponents, columns: list[list[SpectralLines]], widths: tuple[int, ...]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Frequencies, ramps and rows of the lines of all columns; lines of one frequency are
    merged."""
    omega = np.unique(np.concatenate([line.omega for lines in columns for line in lines]))
    total = np.zeros((omega.size, sum(widths)), dtype=complex)
    ends = np.cumsum((0, *widths))
    for k, lines in enumerate(columns):
        for line in lines:
            rows = np.searchsorted(omega, line.omega)
            np.add.at(total[:, ends[k] : ends[k + 1]][:, line.columns], rows, line.amplitude)
    return omega, np.full(omega.size, waves.ramp), np.stack([total.real, total.imag], axis=1)
