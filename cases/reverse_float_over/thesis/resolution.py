"""How finely to record the first stage, and how finely to step the second.

The independent code has no error of its own. So the change by a coarser record is the error of the
record, and the difference of hydrosim on the same record is the error of its step.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cases.reverse_float_over.thesis.one_dimension import VARIANTS as OF_MODEL
from cases.reverse_float_over.thesis.one_dimension import Settings, independent, simulated

TABLE = "One-dimensional model: interval of the record and step"
FINEST = 0.1  # s, the step of the first stage
VARIANTS: Mapping[str, Mapping[str, float]] = {
    **{f"recorded every {s} s": {"interval": s, "step": 0.0} for s in (0.2, 0.5, 1.0)},
    **{f"steps of {h} s": {"interval": 0.5, "step": h} for h in (0.1, 0.05, 0.025)},
}


def figures(variant: str, seed: int) -> dict[str, float]:
    """Difference in surge at 2000 s, and the largest one until then [m]."""
    settings = Settings(**OF_MODEL["mean, 0.2/0.1 of N"])  # type: ignore[arg-type]
    interval, step = VARIANTS[variant]["interval"], VARIANTS[variant]["step"]
    if step > 0.0:
        surge = simulated(settings, seed, step).position.isel(body=0).sel(dof="surge").values
        apart = surge - independent(settings, seed)[:, 0]
    else:
        every = round(interval / FINEST)
        fine = independent(settings, seed, FINEST)[::every, 0]
        apart = independent(settings, seed, FINEST, every)[:, 0] - fine
    return {"end": float(apart[-1]), "largest": float(np.abs(apart).max())}
