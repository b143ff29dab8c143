"""How long a database takes, from samples of its panels.

Each pair of panels takes the same time in the matrices of influence, and each panel the same in
far fields and pressures. So a frequency of n panels takes a n^2 + b n, and two samples of panels
give a and b. Samples are solved at one of the frequencies; their results have no meaning.
"""

from __future__ import annotations

from dataclasses import replace
from time import perf_counter

import numpy as np

from hydrosim.cache import stored
from hydrosim.database.build.bem import Hull, solution_key, solve
from hydrosim.database.build.drift import Real
from hydrosim.database.build.store import entry_name
from hydrosim.database.build.water import Water

SAMPLES = (80, 240)  # panels
SHORTEST_S = 1e-3  # of a sample, by the resolution of clocks


def estimated_seconds(hull: Hull, water: Water, frequencies: Real, headings: Real) -> float:
    """Time [s] that one process takes for all ``frequencies`` [rad/s] that are not stored."""
    missing = [
        frequency
        for frequency in frequencies
        if stored(entry_name(solution_key(hull, water, float(frequency), headings))) is None
    ]
    if not missing:
        return 0.0
    middle = float(missing[len(missing) // 2])
    _sample_seconds(hull, water, middle, headings, min(SAMPLES))  # loads tables
    counts = []
    times = []
    for k, wanted in enumerate(SAMPLES):
        # another frequency each time: the solver remembers its last matrices
        count, seconds = _sample_seconds(hull, water, middle * (1.01 + 0.01 * k), headings, wanted)
        counts.append(count)
        times.append(seconds)
    size = len(hull.panels) + len(hull.lid)
    if counts[0] == counts[1]:  # a hull of few panels
        return times[0] * len(missing)
    powers = np.array([[count**2, count] for count in counts], dtype=float)
    quadratic, linear = np.linalg.solve(powers, times)
    each = max(quadratic, 0.0) * size**2 + max(linear, 0.0) * size
    return float(each) * len(missing)


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
