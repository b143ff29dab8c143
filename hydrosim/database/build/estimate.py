"""How long a database takes, from samples of its panels.

Each pair of panels takes the same time in the matrices of influence, and each panel the same in
far fields and pressures. So a frequency of n panels takes a n^2 + b n + c n^3. Two samples of
panels give a and b; a matrix that is factorised gives c. Samples are solved near one of the
frequencies; their results have no meaning.
"""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter, process_time

import numpy as np
from scipy.linalg import lu_factor

from hydrosim.database.build.bem import Hull, entry_name, solution_key, solve
from hydrosim.database.build.drift import Real, Water
from hydrosim.files.cache import stored

SAMPLE_PANELS = (150, 600)  # panels
SAMPLE_MATRIX_SIZE = 700  # size of the sample of a matrix
FACTORISATION_TRIALS = 3  # factorisations that are timed
SHORTEST_S = 1e-3  # of a sample, by the resolution of clocks


def estimated_seconds(hull: Hull, water: Water, frequencies: Real, headings: Real) -> float:
    """Time [s] that one process takes for all ``frequencies`` [rad/s] that are not stored."""
    missing = [w for w in frequencies if not _is_stored(hull, water, float(w), headings)]
    if not missing:
        return 0.0
    seconds = _seconds_of_one(hull, water, float(missing[len(missing) // 2]), headings)
    return seconds * (len(missing) + _missing_limits(hull, water))


def _is_stored(hull: Hull, water: Water, frequency: float, headings: Real) -> bool:
    return stored(entry_name(solution_key(hull, water, frequency, headings))) is not None


def _missing_limits(hull: Hull, water: Water) -> int:
    """Number of the limits of added mass that are not stored; each takes about a frequency."""
    limits = [0.0, np.inf] if water.is_deep else [np.inf]
    return sum(not _is_stored(hull, water, w, np.empty(0)) for w in limits)


def _seconds_of_one(hull: Hull, water: Water, frequency: float, headings: Real) -> float:
    """Time [s] of one frequency near ``frequency`` [rad/s], in this process."""
    begin = perf_counter(), process_time()
    samples = [
        _sample_seconds(hull, water, frequency, headings, wanted) for wanted in SAMPLE_PANELS
    ]
    factorisations = _factorisation_seconds()
    # other programs delay short samples by chance, so that all share one delay
    delay = (perf_counter() - begin[0]) / max(process_time() - begin[1], SHORTEST_S)
    size = len(hull.panels) + len(hull.lid)
    if samples[0][0] == samples[1][0]:  # a hull of few panels
        return delay * samples[1][1]
    powers = np.array([[count**2, count] for count, _ in samples], dtype=float)
    quadratic, linear = np.linalg.solve(powers, [seconds for _, seconds in samples])
    matrices = (2 if hull.symmetric else 1) * (2 if hull.direct else 1)
    factorised = matrices * factorisations * (size / SAMPLE_MATRIX_SIZE) ** 3
    return delay * float(max(quadratic, 0.0) * size**2 + max(linear, 0.0) * size + factorised)


def _factorisation_seconds() -> float:
    """CPU time [s] of the factorisation of a matrix of the size `SAMPLE_MATRIX_SIZE`."""
    matrix = np.eye(SAMPLE_MATRIX_SIZE) + 1j / (1.0 + np.arange(SAMPLE_MATRIX_SIZE))
    begin = process_time()
    for _ in range(FACTORISATION_TRIALS):
        lu_factor(matrix)
    return max(process_time() - begin, SHORTEST_S) / FACTORISATION_TRIALS


def _sample_seconds(
    hull: Hull, water: Water, frequency: float, headings: Real, wanted: int
) -> tuple[int, float]:
    """Number of panels of a sample with about as many as ``wanted``, and its CPU time [s]."""
    size = len(hull.panels) + len(hull.lid)
    stride = max(size // wanted, 1)
    owner = np.array(hull.owner, dtype=int)
    sides = owner.reshape(2 if hull.symmetric else 1, -1)[:, ::stride]
    sample = replace(
        hull,
        panels=hull.panels[::stride],
        lid=hull.lid[::stride],
        owner=tuple(sides.ravel().tolist()),
    )
    # the first loads tables and makes the mesh, the second shows what all others take
    for share in (1.0, 1.01):
        begin = process_time()
        solve(sample, water, share * frequency, headings)
    return len(sample.panels) + len(sample.lid), max(process_time() - begin, SHORTEST_S)
