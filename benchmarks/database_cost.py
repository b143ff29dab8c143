"""What does a database cost, and how fine is enough?

A box of 60 x 20 x 3 m, built by `hydrosim db build` with panels of several sizes, in deep water
and in 50 m. Costs are of one more frequency: the CPU time of twelve less that of two, over ten,
each with an empty cache. Errors are the largest difference from the finest panels, over the largest
value of the same degree of freedom.
"""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import yaml

from benchmarks.report import Answer, Row
from hydrosim.database import HydroDatabase, load

FREQUENCIES = tuple(0.2 * k for k in range(1, 13))  # rad/s
FEW = 2
SIZES = (4.0, 3.0, 2.0, 1.5, 1.0)  # m, of panels
DEPTHS = {"deep": "infinite", "50 m": 50}


def answer() -> Answer:
    """A row for each size and depth."""
    return Answer({f"database of a box, {name}": _rows(depth) for name, depth in DEPTHS.items()})


def _rows(depth: str | float) -> list[Row]:
    results = [build_twice(size, depth) for size in SIZES]
    finest = results[-1][0]
    return [_row(size, *result, finest) for size, result in zip(SIZES, results, strict=True)]


def _row(size: float, database: HydroDatabase, seconds: float, finest: HydroDatabase) -> Row:
    return {
        "panels [m]": size,
        "CPU of a frequency [s]": seconds,
        "added mass": _error(_diagonal(database.added_mass), _diagonal(finest.added_mass)),
        "damping": _error(
            _diagonal(database.radiation_damping), _diagonal(finest.radiation_damping)
        ),
        "loads": _error(database.excitation, finest.excitation),
        "mean drift": _error(_drift(database), _drift(finest)),
    }


def _diagonal(matrices: np.ndarray) -> np.ndarray:
    """Entries (nf, 6) of a degree of freedom with itself."""
    return np.diagonal(matrices, axis1=1, axis2=2)


def _drift(database: HydroDatabase) -> np.ndarray:
    """Mean drift in surge, sway and yaw, of the free body."""
    assert database.mean_drift is not None
    return database.mean_drift[..., [0, 1, 5]]


def _error(values: np.ndarray, finest: np.ndarray) -> float:
    """Largest difference over the largest value, each degree of freedom (last axis) by itself."""
    axes = tuple(range(values.ndim - 1))
    return float((np.abs(values - finest).max(axes) / np.abs(finest).max(axes)).max())


def build_twice(size: float, depth: str | float) -> tuple[HydroDatabase, float]:
    """The database of all frequencies, and the CPU time of one more [s]."""
    with TemporaryDirectory() as folder:
        few = _build(Path(folder) / "few.yaml", size, depth, FREQUENCIES[:FEW])
        full = _build(Path(folder) / "full.yaml", size, depth, FREQUENCIES)
        seconds = (full - few) / (len(FREQUENCIES) - FEW)
        return load(Path(folder) / "full.nc"), seconds


def _build(path: Path, size: float, depth: str | float, frequencies: tuple[float, ...]) -> float:
    """CPU time of a build with an empty cache [s]."""
    recipe = {
        "title": "Box of 60 x 20 x 3 m",
        "hull": {"type": "box", "length": 60, "beam": 20, "draught": 3, "panels": size},
        "water": {"depth": depth},
        "centre_of_gravity": [0, 0, 0],
        "radii_of_gyration": [7, 16, 17],
        "frequencies": list(frequencies),
        "headings": [float(np.radians(angle)) for angle in range(0, 181, 15)],
    }
    path.write_text(yaml.safe_dump(recipe), "utf-8")
    command = [sys.executable, "-m", "hydrosim", "db", "build", str(path)]
    before = _cpu()
    with TemporaryDirectory() as cache:
        environment = os.environ | {"HYDROSIM_CACHE_DIR": cache}
        subprocess.run(command, check=True, cwd=path.parent, env=environment, capture_output=True)
    return _cpu() - before


def _cpu() -> float:
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime
