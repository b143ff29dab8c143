"""Do the intervals of extremes hold what they promise, of a record and over seeds, and how wide are
they?

2000 records of one hour and of three of each kind (`tests.random_records`). Of those that get
intervals, a confidence interval is to hold the most probable maximum, a prediction interval the
largest value of another record; wrong are the shares of all records whose intervals do not. The
width of prediction is over that between the true 5 and 95 % of the largest; that of confidence over
2 x 1.645 times the scatter of the most probable maximum by one who knows the distribution but for
mean and standard deviation. True figures are quantiles of the largest values of three hours, and
where none are known of the records themselves.

Over seeds: 4000 studies of 6, 20 and 50 runs, their largest values drawn from those of 4000
records, whose quantiles are the true ones.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from benchmarks.report import Answer, Row
from hydrosim.statistics.extremes import LAWS, ExtremeModel, RecordExtremes, extremes
from hydrosim.statistics.gumbel import fit_maxima, length_ratio
from tests.random_records import DURATION, HARD, KINDS, MOST_PROBABLE, Kind, of_draw

RECORDS = 2000
STUDIES = 4000
HOURS = (1, 3)
SEEDS = (6, 20, 50)
NORMAL = 1.645  # 5 % of a normal distribution are beyond
QUANTILES = (0.05, MOST_PROBABLE, 0.95)


def answer() -> Answer:
    """Coverage, widths and laws by the kind of record; coverage over seeds."""
    tables = {}
    for hours in HOURS:
        title = f"{RECORDS} records of {hours} h each: shares that hold, widths"
        kinds = {**KINDS, **{name: of_draw(draw) for name, draw in HARD.items()}}
        tables[title] = [_of_kind(name, kind, hours) for name, kind in kinds.items()]
    over = [_over_seeds(name, _largest(kind)) for name, kind in KINDS.items()]
    tables[f"{STUDIES} studies over seeds each: shares that hold"] = over
    return Answer(tables)


def _of_kind(name: str, kind: Kind, hours: int) -> Row:
    """The row of a kind: the first hours of its records."""
    random = np.random.default_rng(51)
    count = round(3600.0 * hours / kind.step)
    found, drawn, guessed = [], [], []
    for _ in range(RECORDS):
        whole = kind.draw(random)[:count]
        found.append(extremes(kind.record(whole), kind.step, None, kind.slowest)[1])
        drawn.append(whole.max())
        guessed.append(kind.oracle(whole))
    largest = np.array(drawn)
    known = np.isfinite(kind.quantiles).all() and count * kind.step >= DURATION
    true = kind.quantiles if known else np.quantile(largest, QUANTILES)
    oracle = 2.0 * NORMAL * np.std(guessed)
    hold = Holding(found, largest, true[1])
    return {
        "record": name,
        "intervals": hold.given.mean(),
        "confidence": hold.confidence(),
        "wrong": np.mean(hold.given & ~hold.confident),
        "width": hold.width("mpm_lower", "mpm_upper") / oracle,
        "prediction": hold.prediction(),
        "wrong ": np.mean(hold.given & ~hold.predicted),
        "width ": hold.width("predicted_lower", "predicted_upper") / (true[2] - true[0]),
        "mostly": hold.mostly(),
    }


class Holding:
    """Which intervals of extremes that are ``found`` of records are ``given`` at all, which hold
    the ``true`` most probable maximum, and which the ``largest`` value of another record."""

    def __init__(self, found: Sequence[RecordExtremes], largest: np.ndarray, true: float) -> None:
        self._found = found
        other = np.roll(largest, 1)
        self.given = np.array([each.basis in LAWS for each in found])
        self.confident = (self._all("mpm_lower") <= true) & (true <= self._all("mpm_upper"))
        above = self._all("predicted_lower") <= other
        self.predicted = above & (other <= self._all("predicted_upper"))

    def confidence(self) -> float:
        """The share of those given whose confidence interval holds."""
        return float(self.confident[self.given].mean()) if self.given.any() else np.nan

    def prediction(self) -> float:
        """The share of those given whose prediction interval holds."""
        return float(self.predicted[self.given].mean()) if self.given.any() else np.nan

    def width(self, low: str, high: str) -> float:
        """The median width of those given, between two figures of `RecordExtremes`."""
        widths = (self._all(high) - self._all(low))[self.given]
        return float(np.median(widths)) if widths.size else np.nan

    def mostly(self) -> str:
        """The most frequent basis, in words."""
        bases = [each.basis for each in self._found]
        return max(ExtremeModel, key=bases.count).name.lower().replace("_", " ")

    def _all(self, figure: str) -> np.ndarray:
        return np.array([getattr(each, figure) for each in self._found])


def _largest(kind: Kind) -> np.ndarray:
    random = np.random.default_rng(51)
    return np.array([kind.draw(random).max() for _ in range(STUDIES)])


def _over_seeds(name: str, largest: np.ndarray) -> Row:
    """How often the intervals of the most probable and of the P90 value, and that of another run,
    hold; how wide that of P90 is of 20 runs."""
    random, true = np.random.default_rng(52), np.quantile(largest, (MOST_PROBABLE, 0.9))
    row: dict[str, str | float] = {"record": name}
    for seeds in SEEDS:
        drawn = random.choice(largest, (STUDIES, seeds + 1))
        laws = [fit_maxima(each[:-1]) for each in drawn]
        sure = np.array([[law.confidence(r) for r in (1.0, length_ratio(0.9))] for law in laws])
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
