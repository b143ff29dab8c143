"""How long does it take to read and check a database, by format?

Of the barge's own file, and of other programs' files, those that the tests read.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from statistics import median
from time import perf_counter

from benchmarks.report import ROOT, Answer, Row
from hydrosim.database import check
from hydrosim.database.load import read
from hydrosim.scene.given import Given
from tests.validation_data import unpacked

REPEATS = 5
FILES = {
    "hydrosim netCDF, barge": ROOT / "hydro_db" / "h851.nc",
    "WAMIT, sphere": unpacked("sphere/wamit/sphere.1"),
    "WAMIT, hemisphere": unpacked("hemisphere/hemisphere.1"),
    "WAMIT with a QTF, VolturnUS": unpacked("volturnus/volturnus.1"),
    "BEMIO, sphere": unpacked("sphere/sphere.h5"),
}


def answer() -> Answer:
    """Seconds to read each file, and to check what is in it."""
    rows = [_row(name, path) for name, path in FILES.items()]
    return Answer({f"Medians of {REPEATS}": rows}, [])


def _row(name: str, path: Path) -> Row:
    given = Given(length=1.0, water_density=1025.0, gravity=9.81)
    db = read(path, given)
    return {
        "file": name,
        "MB": sum(p.stat().st_size for p in path.parent.glob(f"{path.stem}.*")) / 1e6,
        "read [s]": _seconds(lambda: read(path, given)),
        "check [s]": _seconds(lambda: check(db)),
    }


def _seconds(call: Callable[[], object]) -> float:
    times = []
    for _ in range(REPEATS):
        start = perf_counter()
        call()
        times.append(perf_counter() - start)
    return median(times)
