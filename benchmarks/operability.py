"""Are limits of operation, found by few runs, those of all runs of a grid?

The limit of the base case, |crawl| at most 1 m with 90 %, by bisection on common seeds, against all
heights with all of these seeds, for all peak periods of the study.
"""

from __future__ import annotations

from dataclasses import replace
from os import cpu_count

import numpy as np

from benchmarks.report import ROOT, Answer, Row
from hydrosim.studies.operability.seas import Sea, in_sea
from hydrosim.studies.operability.study import Limits, limits_of, load_limits
from hydrosim.studies.operability.trials import Trials

STUDY = ROOT / "cases" / "reverse_float_over" / "studies" / "limits.yaml"
PERIODS = (6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0)  # s


def answer() -> Answer:
    """A table: limits by both, intervals, and how many runs they took."""
    study = load_limits(STUDY)
    return Answer({"limits of the base case": [_row(study, period) for period in PERIODS]})


def _row(study: Limits, period: float) -> Row:
    wanted = study.wanted.model_copy(update={"peak_periods": (period,)})
    found = limits_of(replace(study, wanted=wanted), cpu_count() or 1).isel(swell=0, heading=0)
    few = found.sel(stage="all", peak_period=period)
    heights, failing = _failing(study, period)
    allowed = len(study.seeds) * (1.0 - study.wanted.probability)
    beyond = np.flatnonzero(failing > allowed + 1e-9)
    brute = heights[beyond[0] - 1] if beyond.size else heights[-1]
    row: Row = {
        "Tp [s]": period,
        "limit [m]": f"{float(few.limit):.2f}",
        "90 % [m]": f"{float(few.low):.2f} to {float(few.high):.2f}",
        "all runs [m]": f"{brute:.2f}",
        "within": bool(few.low <= brute <= few.high),
        "inferred otherwise": f"{int(few.otherwise)} of {int(few.inferred)}",
        "runs": int(few.runs),
        "of": failing.size * len(study.seeds),
        "failing, by height": " ".join(map(str, failing)),
    }
    print(row, flush=True)
    return row


def _failing(study: Limits, period: float) -> tuple[np.ndarray, np.ndarray]:
    """How many seeds fail at each height, all run."""
    trials, counts = Trials(study.figures, cpu_count() or 1), []
    heights = study.wanted.heights.values()
    sea = Sea(period, study.headings[0])
    for height in heights:
        scenes = [in_sea(study.scene, sea, height, seed) for seed in study.seeds]
        counts.append(int(np.sum(~study.limits_hold(*trials.values(scenes)).all(axis=1))))
    return np.array(heights), np.array(counts)
