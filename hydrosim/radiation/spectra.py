"""Spectra of radiation with the memory cut at its end, and cut later. They give estimates of the
effect of a fit and of the cut on motions, without a run.

A run of T s does not distinguish frequencies closer than 1/T, and does not depend on later times.
So its motions are multiplied by exp(-t/T), with spectra at s = 1/T + i w.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np

from hydrosim.radiation.kept import Arrays, kept
from hydrosim.radiation.retardation import Retardation, retardation, transfer_function
from hydrosim.radiation.threads import one_thread

LONGER = 1.5  # times the memory: the change by this extension is as large as the cut, if K decays
SLOWEST, COUNT = 0.01, 400  # rad/s, number of frequencies


class Spectra(NamedTuple):
    """``K`` (nw, n, n), K^(s) of a memory at s = 1/T + i ``w`` (nw,). ``cut`` (nw, n, n) is the
    change of K^ + s A_inf by a memory `LONGER` times as long."""

    w: np.ndarray
    K: np.ndarray
    cut: np.ndarray


def spectra(
    memory: Retardation,
    frequency: np.ndarray,
    added_mass: np.ndarray,
    damping: np.ndarray,
    checksum: str,
    duration: float,
) -> Spectra:
    """Spectra of ``memory`` for runs of a ``duration`` T [s], up to the highest of the database's
    ``frequency`` (nw,). For the coefficients see `retardation`. The result is stored in the cache
    folder by the ``checksum``, the memory and the duration."""
    settings = (checksum, memory.time.size, float(memory.time[-1]), duration)
    make = partial(_spectra, memory, frequency, added_mass, damping, 1.0 / duration)
    return kept("spectra", settings, make, Spectra._asdict, _of_arrays)


@one_thread
def _spectra(
    memory: Retardation,
    frequency: np.ndarray,
    added_mass: np.ndarray,
    damping: np.ndarray,
    fading: float,
) -> Spectra:
    length, step = float(memory.time[-1]), float(memory.time[1])
    late = retardation(frequency, added_mass, damping, length=LONGER * length, step=step)
    w = np.geomspace(min(SLOWEST, frequency[0]) or SLOWEST, frequency[-1], COUNT)
    K, longer = (
        transfer_function(of.time, np.exp(-fading * of.time)[:, None, None] * of.kernel, w)
        for of in (memory, late)
    )
    more = late.added_mass_infinite - memory.added_mass_infinite
    return Spectra(w, K, longer - K + (fading + 1j * w[:, None, None]) * more)


def _of_arrays(arrays: Arrays) -> Spectra:
    return Spectra(*(arrays[name] for name in Spectra._fields))
