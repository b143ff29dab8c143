"""How long a database takes, from samples of its panels.

Each pair of panels takes the same time in the matrices of influence, and each panel the same in
far fields and pressures. So a frequency of n panels takes a n^2 + b n + c n^3. Two samples of
panels give a and b; a matrix that is factorised gives c. Samples are solved near one of the
frequencies; their results have no meaning.
"""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np
from scipy.linalg import lu_factor

from hydrosim.cache import stored
from hydrosim.database.build.bem import Hull, solution_key, solve
from hydrosim.database.build.drift import Real
from hydrosim.database.build.store import entry_name
from hydrosim.database.build.water import Water

SAMPLES = (80, 240)  # panels
FACTORISED = 700  # size of the sample of a matrix
TRIALS = 3  # factorisations that are timed
SHORTEST_S = 1e-3  # of a sample, by the resolution of clocks


def estimated_seconds(hull: Hull, water: Water, frequencies: Real, headings: Real) -> float:
    """Time [s] that one process takes for all ``frequencies`` [rad/s] that are not stored."""
    missing = [w for w in frequencies if not _is_stored(hull, water, float(w), headings)]
    if not missing:
        return 0.0
    each = _seconds_of_one(hull, water, float(missing[len(missing) // 2]), headings)
    return each * (len(missing) + _missing_limits(hull, water))


def _is_stored(hull: Hull, water: Water, frequency: float, headings: Real) -> bool:
    return stored(entry_name(solution_key(hull, water, frequency, headings))) is not None


def _missing_limits(hull: Hull, water: Water) -> int:
    """Number of the limits of added mass that are not stored; each takes about a frequency."""
    limits = [0.0, np.inf] if water.is_deep else [np.inf]
    return sum(not _is_stored(hull, water, w, np.empty(0)) for w in limits)


def _seconds_of_one(hull: Hull, water: Water, frequency: float, headings: Real) -> float:
    """Time [s] of one frequency near ``frequency`` [rad/s], in this process."""
    _sample_seconds(hull, water, frequency, headings, min(SAMPLES))  # loads tables
    counts = []
    times = []
    for k, wanted in enumerate(SAMPLES):
        # another frequency each time: the solver remembers its last matrices
        count, seconds = _sample_seconds(
            hull, water, frequency * (1.01 + 0.01 * k), headings, wanted
        )
        counts.append(count)
        times.append(seconds)
    size = len(hull.panels) + len(hull.lid)
    if counts[0] == counts[1]:  # a hull of few panels
        return times[0]
    powers = np.array([[count**2, count] for count in counts], dtype=float)
    quadratic, linear = np.linalg.solve(powers, times)
    each = max(quadratic, 0.0) * size**2 + max(linear, 0.0) * size
    return float(each) + _factorisation_seconds(hull, size)


def _factorisation_seconds(hull: Hull, size: int) -> float:
    """Time [s] of the factorisations of matrices of ``size`` in one frequency."""
    count = (2 if hull.symmetric else 1) * (2 if hull.direct else 1)
    matrix = np.eye(FACTORISED) + 1j / (1.0 + np.arange(FACTORISED))
    times = []
    for _ in range(TRIALS):  # other programs may delay a short one
        begin = perf_counter()
        lu_factor(matrix)
        times.append(perf_counter() - begin)
    return count * max(float(np.median(times)), SHORTEST_S) * (size / FACTORISED) ** 3


def _sample_seconds(
    hull: Hull, water: Water, frequency: float, headings: Real, wanted: int
) -> tuple[int, float]:
    """Number of panels of a sample with about as many as ``wanted``, and its time [s]."""
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
    begin = perf_counter()
    solve(sample, water, frequency, headings)
    return len(sample.panels) + len(sample.lid), max(perf_counter() - begin, SHORTEST_S)
