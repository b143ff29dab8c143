"""Do the intervals of extremes hold what they promise, of a record and over seeds, and how wide are
they?

4000 records of three hours of each kind (`tests.random_records`). A confidence interval is to hold
the true most probable maximum, a prediction interval the largest value of the record itself and of
another one; a record that is refused counts as one that does not. Widths are over those of an
oracle that knows the distribution but for mean and standard deviation: 2 x 1.645 times the scatter
of its most probable maximum, and the true 5 and 95 % of the largest.

Over seeds: 4000 studies of 6, 20 and 50 runs, their largest values drawn from those of the 4000
records, whose quantiles are the true ones.
"""

from __future__ import annotations

import numpy as np

from benchmarks.report import Answer, Row
from hydrosim.statistics.extremes import LAWS, Basis, extremes
from hydrosim.statistics.gumbel import exceeding, fit_maxima
from tests.random_records import KINDS, MOST_PROBABLE, Kind

RECORDS = STUDIES = 4000
SEEDS = (6, 20, 50)
NORMAL = 1.645  # 5 % of a normal distribution are beyond


def answer() -> Answer:
    """Coverage, widths and laws by the kind of record; coverage over seeds."""
    rows: list[Row] = []
    over: list[Row] = []
    for name, kind in KINDS.items():
        row, largest = _of_kind(name, kind)
        rows.append(row)
        over.append(_over_seeds(name, largest))
    title = f"{RECORDS} records each: shares that hold, widths over the oracle's"
    return Answer({title: rows, f"{STUDIES} studies over seeds each: shares that hold": over})


def _of_kind(name: str, kind: Kind) -> tuple[Row, np.ndarray]:
    """The row of a kind, and the largest values of its records."""
    random, true = np.random.default_rng(51), kind.quantiles
    found, drawn, guessed = [], [], []
    for _ in range(RECORDS):
        whole = kind.draw(random)
        found.append(extremes(kind.record(whole), kind.step, None, kind.slowest)[1])
        drawn.append(whole.max())
        guessed.append(kind.oracle(whole))
    low, high, least, most = np.array([each[1:5] for each in found]).T
    largest, oracle = np.array(drawn), 2.0 * NORMAL * np.std(guessed)
    row = {
        "record": name,
        "confidence": np.mean((low <= true[1]) & (true[1] <= high)),
        "width": np.nanmean(high - low) / oracle,
        "prediction, own": np.mean((least <= largest) & (largest <= most)),
        "another": np.mean((least[1:] <= largest[:-1]) & (largest[:-1] <= most[1:])),
        "width ": np.nanmean(most - least) / (true[2] - true[0]),
        "refused": np.mean([each.basis not in LAWS for each in found]),
        "Gumbel": np.mean([each.basis == Basis.GUMBEL for each in found]),
    }
    return row, largest


def _over_seeds(name: str, largest: np.ndarray) -> Row:
    """How often the intervals of the most probable and of the P90 value, and that of another run,
    hold; how wide that of P90 is of 20 runs."""
    random, true = np.random.default_rng(52), np.quantile(largest, (MOST_PROBABLE, 0.9))
    row: dict[str, str | float] = {"record": name}
    for seeds in SEEDS:
        drawn = random.choice(largest, (STUDIES, seeds + 1))
        laws = [fit_maxima(each[:-1]) for each in drawn]
        sure = np.array([[law.confidence(r) for r in (1.0, exceeding(0.9))] for law in laws])
        inside = (sure[..., 0] <= true) & (true <= sure[..., 1])
        ends = np.array([law.prediction(1.0) for law in laws]).T
        another = (ends[0] <= drawn[:, -1]) & (drawn[:, -1] <= ends[1])
        known = drawn[:, :-1].mean(axis=1), drawn[:, :-1].std(axis=1)
        guessed = known[0] + (true[1] - largest.mean()) / largest.std() * known[1]
        width = np.ptp(sure[:, 1], axis=1).mean() / (2.0 * NORMAL * guessed.std())
        figures = {
            "most probable": inside[:, 0].mean(),
            "P90": inside[:, 1].mean(),
            "width": width,
            "another": another.mean(),
        }
        row |= {f"{what}, {seeds}": value for what, value in figures.items()}
    return row
