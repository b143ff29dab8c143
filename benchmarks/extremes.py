"""Do the intervals of extremes hold what they promise, and how wide are they?

2000 records of three hours of each kind (`tests.random_records`). A confidence interval is to hold
the true most probable maximum, a prediction interval the largest value of the record itself and of
another one; a record that is refused counts as one that does not. Widths are over those of an
oracle that knows the distribution but for mean and standard deviation: 2 x 1.645 times the scatter
of its most probable maximum, and the true 5 and 95 % of the largest.
"""

from __future__ import annotations

import numpy as np

from benchmarks.report import Answer, Row
from hydrosim.results.extremes import LAWS, Basis, extremes
from tests.random_records import KINDS, MOST_PROBABLE, Kind

RECORDS, DRAWN = 2000, 20000
NORMAL = 1.645  # 5 % of a normal distribution are beyond


def answer() -> Answer:
    """Coverage, widths and laws by the kind of record; what their largest values are."""
    rows = [_row(name, kind) for name, kind in KINDS.items()]
    drawn = [_drawn(name, kind) for name, kind in KINDS.items() if kind.floor == -np.inf]
    title = f"{RECORDS} records each: shares that hold, widths over the oracle's"
    return Answer({title: rows, f"Largest of {DRAWN} records each": drawn})


def _row(name: str, kind: Kind) -> Row:
    random, true = np.random.default_rng(2), kind.quantiles
    found, drawn, guessed = [], [], []
    for _ in range(RECORDS):
        whole = kind.draw(random)
        found.append(extremes(kind.record(whole), kind.step, None, kind.slowest)[1])
        drawn.append(whole.max())
        guessed.append(kind.oracle(whole))
    low, high, least, most = np.array([each[1:5] for each in found]).T
    largest, oracle = np.array(drawn), 2.0 * NORMAL * np.std(guessed)
    return {
        "record": name,
        "confidence": np.mean((low <= true[1]) & (true[1] <= high)),
        "width": np.nanmean(high - low) / oracle,
        "prediction, own": np.mean((least <= largest) & (largest <= most)),
        "another": np.mean((least[1:] <= largest[:-1]) & (largest[:-1] <= most[1:])),
        "width ": np.nanmean(most - least) / (true[2] - true[0]),
        "refused": np.mean([each.basis not in LAWS for each in found]),
        "Gumbel": np.mean([each.basis == Basis.GUMBEL for each in found]),
    }


def _drawn(name: str, kind: Kind) -> Row:
    random = np.random.default_rng(1)
    largest = [kind.draw(random).max() for _ in range(DRAWN)]
    quantiles = np.quantile(largest, (0.05, MOST_PROBABLE, 0.95))
    return {
        "record": name,
        "5 %": quantiles[0],
        "most probable": quantiles[1],
        "95 %": quantiles[2],
    }
