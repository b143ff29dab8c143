"""Errors of motions by the fits of retardation functions and by their truncation: estimated before
a run, and printed."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import block_diag

from hydrosim.dofs import about_z
from hydrosim.integrate.names import coordinate_names
from hydrosim.linear.impedance import Admittance, Change, at_frequencies, find_admittances
from hydrosim.linear.linearise import Linear, linearise
from hydrosim.multibody.kinematics import moving_dofs, slopes_at_rest
from hydrosim.scene import ConstantRadiation, Scene
from hydrosim.water.radiation.convolution import convolution_model
from hydrosim.water.radiation.retardation import LONGER, Spectra, resolved_length, spectra
from hydrosim.water.radiation.threads import one_thread

if TYPE_CHECKING:
    from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup
    from hydrosim.integrate.dynamics import Model
    from hydrosim.integrate.state import State

# points for each frequency of the spectra, because resonances are narrower than the spacing
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
        cut = f"{told} change motions by at most {_size(self.cut)}"
        if self._is_all:
            cut += f" ({self._limit})"
        return f"{cut}; the fits do so by at most {_size(self.fit)}" if self.fit else cut

    def warnings(self) -> Iterator[str]:
        """Warnings about changes that are too large to ignore."""
        if self.fit and self.fit[0].size > FIT_WARNED:
            yield (
                f"radiation of {self.names}: the state-space fits may change motions by"
                f" {_size(self.fit)}; give a smaller `tolerance` or `model: convolution`."
            )
        if self.cut[0].size > CUT_WARNED:
            yield (
                f"radiation of {self.names}: truncation of its memory at {self.length:g} s may"
                f" change motions by {_size(self.cut)}; {self._remedy}."
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
    scene: Scene, wet: Sequence[HydrodynamicGroup], model: Model, state: State, time: float
) -> tuple[MemoryErrors, ...]:
    """Errors of all databases with a memory, with all other forces linearised about ``state``."""
    moving = moving_dofs(model.bodies)
    groups = [group for group in wet if np.isin(group.dofs, moving).any() and _remembers(group)]
    if not groups:
        return ()
    duration = time + scene.duration  # a continued run remembers earlier velocities
    spectra = [_spectra(group, duration) for group in groups]
    w = np.unique(np.concatenate([_refine_frequencies(of.w) for of in spectra]))
    K = [
        _to_body_coordinates(group, at_frequencies(w, of.w, of.K))
        for group, of in zip(groups, spectra, strict=True)
    ]
    s = 1.0 / duration + 1j * w
    linear = _without_memory(model, state, time)
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
            change(group, group_errors, at_frequencies(w, of.w, of.cut)),
        )
        for group, of, group_errors in zip(groups, spectra, admittances, strict=True)
    )


def _without_memory(model: Model, state: State, time: float) -> Linear:
    """Linearised matrices of positions and rates, with all forces except the memory."""
    others = model._replace(convolution=convolution_model(1.0, np.zeros((2, 0, 0))))
    return linearise(others, state, time=time, states=np.arange(2 * model.bodies.active.size))


def _remembers(group: HydrodynamicGroup) -> bool:
    return group.radiation is not None and not isinstance(group.radiation, ConstantRadiation)


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
    return at_frequencies(w, of.w, missed)


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


def _size(change: tuple[Change, str]) -> str:
    largest, name = change
    return f"{largest.size:.1e} ({name}, at {2.0 * np.pi / largest.w:.3g} s)"
