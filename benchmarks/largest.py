"""What quantiles do the largest values of random records have? (If named: it takes half an hour.)

Of 20,000 records of three hours of each kind (`tests.random_records`), which says the same of them:
they are not clipped. What rises along a curve with another kind is left out.
"""

from __future__ import annotations

import numpy as np

from benchmarks.report import Answer, Row
from tests.random_records import KINDS, MOST_PROBABLE, Curved, Kind

DRAWN = 20000


def answer() -> Answer:
    """5 %, the most probable value and 95 %, by the kind of record."""
    apart = {
        name: kind
        for name, kind in KINDS.items()
        if kind.floor == -np.inf and not isinstance(kind.draw, Curved)
    }
    rows = [_row(name, kind) for name, kind in apart.items()]
    return Answer({f"Largest of {DRAWN} records each": rows})


def _row(name: str, kind: Kind) -> Row:
    random = np.random.default_rng(1)
    largest = [kind.draw(random).max() for _ in range(DRAWN)]
    low, middle, high = np.quantile(largest, (0.05, MOST_PROBABLE, 0.95))
    return {"record": name, "5 %": low, "most probable": middle, "95 %": high}
