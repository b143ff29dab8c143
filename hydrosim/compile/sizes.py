"""Estimates before a run: memory, size of its result, and errors of its fits of retardation."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from math import inf, pi
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.linalg import block_diag

from hydrosim import scene as scenes
from hydrosim.dofs import about_z
from hydrosim.errors import InputError
from hydrosim.integrate.names import coordinate_names
from hydrosim.linear.linearise import Linear, linearise
from hydrosim.linear.modes import Admittance, Change, find_admittances, interpolate_frequencies
from hydrosim.multibody.kinematics import moving_dofs, slopes_at_rest
from hydrosim.scene.hydrodynamics import LENGTH
from hydrosim.water.radiation.convolution import convolution_model
from hydrosim.water.radiation.retardation import FINER, LONGER, Spectra, resolved_length, spectra
from hydrosim.water.radiation.threads import one_thread
from hydrosim.water.spectra import cut_off

if TYPE_CHECKING:
    from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup
    from hydrosim.integrate.dynamics import Model
    from hydrosim.integrate.state import State

NUMBER = 8  # bytes
MOST_STEPS = 1e12  # steps of a run that takes months
MOST_ROWS = 20_000  # rows of a table of retardation functions: 100 s every 5 ms
MOST_WAVES = 2e6  # waves of all trains
CONTAINER = Path("/sys/fs/cgroup/memory.max")


class RamUse(NamedTuple):
    """A use of memory: the key and value that cause it, the ``bytes``, and the remedy."""

    key: str
    memory: float
    remedy: str


def memory_needed(scene: scenes.Scene) -> float:
    """Memory [bytes] that a run needs, within a factor of about two."""
    return sum(part.memory for part in _ram_uses(scene))


def result_size(scene: scenes.Scene) -> float:
    """Approximate size [bytes] of the result of a run."""
    states = _estimated_states(scene) if scene.output.states else 0.0
    return NUMBER * _record_count(scene) * (_numbers_per_record(scene) + states)


def check_sizes(scene: scenes.Scene) -> None:
    """Raises InputError if a scene does not fit into the memory, or would take months."""
    steps = scene.duration / scene.solver.step
    if not scene.solver.method.adapts and steps > MOST_STEPS:
        raise InputError(
            f"duration: found {scene.duration:g} s in steps of {scene.solver.step:g} s, {steps:.1e}"
            f" steps; expected at most {MOST_STEPS:g}, which take months. Shorten the duration."
        )
    for body in scene.bodies:
        if _row_count(body) > MOST_ROWS:
            raise InputError(
                f"bodies.{body.name}.radiation: found a table of"
                f" {_row_count(body):.3g} rows (length"
                f" over step); expected at most {MOST_ROWS:,}. Choose a larger step; it does not"
                " depend on the step of the run."
            )
    count = sum(_wave_counts(scene))
    if count > MOST_WAVES:
        raise InputError(
            f"environment.waves.repeat_period: found {count:.1e} waves in all trains, and"
            f" components of gusts; expected at most {MOST_WAVES:g}. Choose periods about as long"
            " as the run, or fewer trains."
        )
    largest = max(_ram_uses(scene), key=lambda part: part.memory)
    most = _available_bytes()
    if memory_needed(scene) > most:
        raise InputError(
            f"{largest.key}: the run needs about {size_text(memory_needed(scene))} of memory,"
            f" {size_text(largest.memory)} of it for this; only {size_text(most)} exist."
            f" {largest.remedy}."
        )


def size_text(size: float) -> str:
    """Number of bytes as text with a unit."""
    for unit in ("kB", "MB", "GB"):
        size /= 1000.0
        if size < 1000.0:
            return f"{size:.3g} {unit}"
    return f"{size / 1000.0:.3g} TB"


def _ram_uses(scene: scenes.Scene) -> Iterator[RamUse]:
    motions = 6 * len(scene.bodies)
    # records are copied once for the dataset
    recorded = (
        NUMBER
        * _record_count(scene)
        * (2.0 * _numbers_per_record(scene) + _estimated_states(scene))
    )
    yield RamUse("output.step", recorded, "Record less often, or make a shorter run")
    # components, their loads, and a table over time of both
    wave = NUMBER * (6 + 8 * (1 + motions))
    waves = wave * sum(_wave_counts(scene))
    yield RamUse("environment.waves.repeat_period", waves, "Shorten it")
    tables = NUMBER * 3 * FINER * 36 * _rows_of_pairs(scene)
    yield RamUse("bodies.radiation", tables, "Choose a larger step or a shorter length")


def _record_count(scene: scenes.Scene) -> float:
    return scene.duration / scene.output_step + 1.0


def _numbers_per_record(scene: scenes.Scene) -> float:
    """Numbers in a stored record."""
    motions = 6 * len(scene.bodies)
    forces = 4 + len(scene.forces)
    points = sum(len(element.unit_names(name)) for name, element in scene.forces.items())
    rates = 2.0 + float(scene.output.accelerations)
    return (
        6.0
        + rates * motions
        + forces * (2.0 + motions)
        + 20.0 * points
        + len(scene.output.wave_probes)
    )


def _estimated_states(scene: scenes.Scene) -> float:
    """Estimated number of states of a scene, with a usual number of radiation states."""
    return sum(12.0 + (60.0 if body.hydrodynamics is not None else 0.0) for body in scene.bodies)


def _row_count(body: scenes.Body) -> float:
    table = body.radiation
    if body.hydrodynamics is None or not isinstance(
        table, scenes.AutomaticRadiation | scenes.StateSpaceRadiation | scenes.ConvolutionRadiation
    ):
        return 0.0
    length = LENGTH if table.length is None else table.length
    return length / table.step


def _rows_of_pairs(scene: scenes.Scene) -> float:
    """Rows of the tables of all pairs of bodies of one database; others do not feel each other."""
    wet = [body for body in scene.bodies if _row_count(body) > 0.0]
    pairs = Counter(_database_key(body) for body in wet)
    return sum(_row_count(body) * pairs[_database_key(body)] for body in wet)


def _database_key(body: scenes.Body) -> tuple[object, ...]:
    """What bodies of one database have in common; a body of its own coefficients is alone."""
    if isinstance(body.hydrodynamics, scenes.Coefficients):
        return (body.name,)
    return (body.hydrodynamics, *body.location, body.heading)


def _wave_counts(scene: scenes.Scene) -> Iterator[float]:
    """Number of waves in each random sea, and of components of gusts."""
    for train in scene.environment.waves:
        if isinstance(train.spectrum, scenes.Density):
            yield cut_off(train.spectrum) * train.repeat_period / (2.0 * pi)
    if (gusts := scene.environment.gusts) is not None:
        yield gusts.highest_frequency * gusts.repeat_period / (2.0 * pi)


def _available_bytes() -> float:
    """Memory of the machine [bytes], or of the container."""
    most = inf
    if hasattr(os, "sysconf"):
        most = float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    try:
        return min(most, float(CONTAINER.read_text()))
    except (OSError, ValueError):  # missing, or "max"
        return most


# Errors of motions by fits of retardation functions and by their truncation.

# Points for each frequency of the spectra, because resonances are narrower than the spacing
POINTS_PER_FREQUENCY_STEP = 3
FIT_WARNED, CUT_WARNED = 0.01, 0.05  # changes of motion that are worth a warning
COMPLETE_MEMORY_FRACTION = 0.98  # of the resolved length: a memory this long counts as complete


@dataclass(frozen=True)
class MemoryErrors:
    """Errors of the databases ``names`` in a scene: change of motions by their fits (none if all
    memory is convolved), and by a memory of length ``longer`` instead of ``length`` [s].

    ``resolved`` [s] is the length of memory that the frequencies of the database resolve. If the
    memory ends there, a longer one contains an echo: its later part is the mirror image of the
    earlier part. The earlier part is larger if the memory decays.
    """

    names: str
    length: float
    longer: float
    resolved: float
    fit: tuple[Change, str] | None
    cut: tuple[Change, str]

    def __str__(self) -> str:
        told = f"{self.names}: a memory of {self.longer:g} s instead of {self.length:g} s would"
        cut = f"{told} change motions by at most {_size_text(self.cut)}"
        if self._is_all:
            cut += f" ({self._limit})"
        return f"{cut}; the fits do so by at most {_size_text(self.fit)}" if self.fit else cut

    def warnings(self) -> Iterator[str]:
        """Warnings about changes that are too large to ignore."""
        if self.fit and self.fit[0].size > FIT_WARNED:
            yield (
                f"radiation of {self.names}: the state-space fits may change motions by"
                f" {_size_text(self.fit)}; give a smaller `tolerance` or `model: convolution`."
            )
        if self.cut[0].size > CUT_WARNED:
            yield (
                f"radiation of {self.names}: truncation of its memory at {self.length:g} s may"
                f" change motions by {_size_text(self.cut)}; {self._remedy}."
            )

    @property
    def largest(self) -> float:
        """Largest change of motions, by the fits or by the truncation."""
        return max(change.size for change, _ in filter(None, (self.fit, self.cut)))

    @property
    def _is_all(self) -> bool:
        """Whether the frequencies resolve no longer memory."""
        return self.length > COMPLETE_MEMORY_FRACTION * self.resolved

    @property
    def _limit(self) -> str:
        step = np.pi / self.resolved
        return f"frequencies {step:.3g} rad/s apart resolve {self.resolved:.3g} s"

    @property
    def _remedy(self) -> str:
        if self._is_all:
            return f"{self._limit}: compute the database at frequencies in between"
        return f"increase `length`: its frequencies resolve {self.resolved:.3g} s"


@one_thread
def memory_errors(
    scene: scenes.Scene, wet: Sequence[HydrodynamicGroup], model: Model, state: State, time: float
) -> tuple[MemoryErrors, ...]:
    """Errors of all databases with a memory, with all other forces linearised about ``state``."""
    moving = moving_dofs(model.bodies)
    groups = [group for group in wet if np.isin(group.dofs, moving).any() and _has_memory(group)]
    if not groups:
        return ()
    duration = time + scene.duration  # a continued run remembers earlier velocities
    spectra = [_spectra(group, duration) for group in groups]
    w = np.unique(np.concatenate([_refine_frequencies(of.w) for of in spectra]))
    K = [
        _to_body_coordinates(group, interpolate_frequencies(w, of.w, of.K))
        for group, of in zip(groups, spectra, strict=True)
    ]
    s = 1.0 / duration + 1j * w
    linear = _linearise_without_memory(model, state, time)
    slopes = slopes_at_rest(model.bodies)
    admittances = find_admittances(s, [slopes[group.dofs] for group in groups], K, linear)
    names = coordinate_names(scene)

    def change(
        group: HydrodynamicGroup, admittance: Admittance, missed: np.ndarray
    ) -> tuple[Change, str]:
        largest = admittance.largest_change(w, _to_body_coordinates(group, missed))
        return largest, names[int(np.searchsorted(model.bodies.active, largest.coordinate))]

    return tuple(
        MemoryErrors(
            ", ".join(group.names),
            float(group.memory.time[-1]),
            LONGER * float(group.memory.time[-1]),
            resolved_length(group.database.frequency),
            change(group, group_errors, _fit_error(group, w, of, duration)) if group.fits else None,
            change(group, group_errors, interpolate_frequencies(w, of.w, of.cut)),
        )
        for group, of, group_errors in zip(groups, spectra, admittances, strict=True)
    )


def _linearise_without_memory(model: Model, state: State, time: float) -> Linear:
    """Linearised matrices of positions and rates, with all forces except the memory."""
    others = model._replace(convolution=convolution_model(1.0, np.zeros((2, 0, 0))))
    return linearise(others, state, time=time, states=np.arange(2 * model.bodies.active.size))


def _has_memory(group: HydrodynamicGroup) -> bool:
    return group.radiation is not None and not isinstance(group.radiation, scenes.ConstantRadiation)


def _spectra(group: HydrodynamicGroup, duration: float) -> Spectra:
    db = group.database
    coefficients = db.frequency, db.added_mass, db.radiation_damping
    return spectra(group.memory, *coefficients, db.checksum, duration)


def _fit_error(group: HydrodynamicGroup, w: np.ndarray, of: Spectra, duration: float) -> np.ndarray:
    """Difference of K^ between the fits and the memory, (nw, n, n)."""
    missed, s = np.zeros_like(of.K), 1.0 / duration + 1j * of.w
    for fit in group.fits:
        block = fit.dofs[:, None], fit.dofs
        missed[:, *block] = fit.modes.transfer_function(s) - of.K[:, *block]
    return interpolate_frequencies(w, of.w, missed)


def _to_body_coordinates(group: HydrodynamicGroup, values: np.ndarray) -> np.ndarray:
    """Transform ``values`` (nw, n, n) from the headings of the bodies to their coordinates:
    positions along the earth's axes, angles about the body's."""
    headings = (body.heading + body.position[5] for body in group.bodies)
    P = block_diag(*(part for psi in headings for part in (about_z(psi), np.eye(3))))
    return np.asarray(P @ values @ P.T)


def _refine_frequencies(w: np.ndarray) -> np.ndarray:
    return np.interp(
        np.arange(POINTS_PER_FREQUENCY_STEP * (w.size - 1) + 1) / POINTS_PER_FREQUENCY_STEP,
        np.arange(w.size),
        w,
    )


def _size_text(change: tuple[Change, str]) -> str:
    largest, name = change
    return f"{largest.size:.1e} ({name}, at {2.0 * np.pi / largest.w:.3g} s)"
