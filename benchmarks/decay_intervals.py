"""How often do 90 % intervals of decay tests hold the truth?

500 made decays (`tests/decay/made_decays.py`: an independent solver, noise white or with a memory,
of 0.1 to 5 % of the largest roll) are fitted, each by itself.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import numpy as np

from benchmarks.report import Answer
from tests.decay.made_decays import which_hold

COUNT = 500
FIRST = 1000
"""First seed."""
WORKERS = 2
NAMES = ("p1", "p2", "p3", "natural period", "damping ratio at half of the largest roll")


def answer() -> Answer:
    """Share of the decays whose intervals hold."""
    seeds = range(FIRST, FIRST + COUNT)
    with ProcessPoolExecutor(WORKERS) as pool:
        found = list(pool.map(which_hold, seeds, chunksize=10))
    told = np.array([each for each in found if each is not None])
    shares = 100.0 * told.mean(axis=0)
    rows = [
        {"interval of": name, "holds in [%]": float(share)}
        for name, share in zip(NAMES, shares, strict=True)
    ]
    refused = f"{COUNT - len(told)} of {COUNT} are refused: their damping is not told from zero"
    return Answer({"90 % intervals of 500 made decays": rows}, [refused])
