"""How often do 90 % intervals of decay tests hold the truth, and is the damping right?

500 made decays (`tests/decay/made_decays.py`: an independent solver; noise none, white, with a
memory, or of waves in the basin) are fitted, each by itself, and 100 records that are no decays.
"""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor

import numpy as np

from benchmarks.report import Answer
from tests.decay.made_decays import DISTURBANCES, NAMES, Outcome, draw, draw_no_decay, try_fit

COUNT = 500
NO_DECAY_COUNT = 100
FIRST_SEED = 1000
WORKERS = 2


def answer() -> Answer:
    """Shares of the decays whose intervals hold, and their largest error."""
    seeds = range(FIRST_SEED, FIRST_SEED + COUNT)
    with ProcessPoolExecutor(WORKERS) as pool:
        outcomes = list(pool.map(_fit_decay, seeds, chunksize=10))
        others = list(pool.map(_fit_no_decay, seeds[:NO_DECAY_COUNT], chunksize=10))
    fitted = [k for k, outcome in enumerate(outcomes) if not outcome.refusal]
    rows = []
    for name, kinds in (("all", DISTURBANCES), *((kind, (kind,)) for kind in DISTURBANCES)):
        chosen = [
            outcomes[k] for k in fitted if DISTURBANCES[seeds[k] % len(DISTURBANCES)] in kinds
        ]
        shares = 100.0 * np.mean([outcome.holds for outcome in chosen], axis=0)
        errors = 100.0 * np.abs([outcome.error for outcome in chosen])
        rows.append(
            {
                "noise": name,
                "fitted": len(chosen),
                **{f"{label} [%]": float(x) for label, x in zip(NAMES, shares, strict=True)},
                "beyond 15 %": int(np.sum(errors > 15.0)),
                "largest error [%]": float(errors.max()),
            }
        )
    refused = sum(bool(outcome.refusal) for outcome in others)
    notes = [
        f"{COUNT - len(fitted)} of {COUNT} decays are refused",
        f"{refused} of {NO_DECAY_COUNT} records that are no decays are refused",
    ]
    return Answer({"90 % intervals of 500 made decays hold in": rows}, notes)


def _fit_decay(seed: int) -> Outcome:
    return try_fit(draw(seed))


def _fit_no_decay(seed: int) -> Outcome:
    return try_fit(draw_no_decay(seed))
