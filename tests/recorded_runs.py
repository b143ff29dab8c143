"""Datasets that look like runs, made of sums of waves: nothing is simulated."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import xarray as xr

from hydrosim.dofs import DOFS

SIZE = {"surge": 0.3, "sway": 0.2, "heave": 0.8, "roll": 0.03, "pitch": 0.02, "yaw": 0.01}


def sea(time: np.ndarray, seed: int, slow: float = 0.2) -> np.ndarray:
    """A random series (nt,) of std 1 about: waves of 6 to 12 s, and ``slow`` of about 100 s."""
    rng = np.random.default_rng(seed)
    omega = np.concatenate([rng.uniform(0.5, 1.0, 80), rng.uniform(0.04, 0.08, 5)])
    size = np.concatenate([np.full(80, np.sqrt(2.0 / 80)), np.full(5, slow * np.sqrt(2.0 / 5))])
    phase = rng.uniform(0.0, 2.0 * np.pi, omega.size)
    return np.cos(np.multiply.outer(time, omega) + phase) @ size


def made_run(seed: int = 1, duration: float = 600.0, step: float = 0.2) -> xr.Dataset:
    """A barge that moves in all degrees of freedom and knocks against two fenders from 300 s on."""
    time = step * np.arange(round(duration / step) + 1)
    motions = np.stack([SIZE[dof] * sea(time, 10 * seed + i) for i, dof in enumerate(DOFS)], axis=1)
    rates = np.gradient(motions, time, axis=0)
    press = np.stack([motions[:, 2] + y * motions[:, 3] for y in (20.0, -20.0)], axis=1)
    press += 2.0 * (time[:, None] / (duration / 2) - 1.0) - 0.5
    body, point, units = ("time", "body", "dof"), ("time", "fender"), {"units": "m or rad"}
    modes = {"units": "1", "flag_values": np.array([0, 1, 2], np.int8)}
    return xr.Dataset(
        {
            "position": (body, motions[:, None], units),
            "velocity": (body, rates[:, None], {"units": "m/s or rad/s"}),
            "reference_position": (("body", "axis"), np.zeros((1, 3)), {"units": "m"}),
            "wave_elevation": ("time", sea(time, 10 * seed + 7, 0.0), {"units": "m"}),
            "force_mooring": (body, -4e5 * motions[:, None], {"units": "N or N m"}),
            "force_lift": (body, np.zeros((time.size, 1, 6)), {"units": "N or N m"}),
            "fender_normal_force": (point, 1e6 * np.maximum(press, 0.0), {"units": "N"}),
            "fender_compression": (point, press, {"units": "m"}),
            "fender_mode": (point, (press > 0.0).astype(np.int8), modes),
            "energy_kinetic": ("time", np.full(time.size, 1e6), {"units": "J"}),
            "energy_residual": ("time", np.zeros(time.size), {"units": "J"}),
        },
        coords={
            "time": ("time", time, {"units": "s"}),
            "body": ["barge"],
            "dof": list(DOFS),
            "axis": ["x", "y", "z"],
            "fender": ["interface 1", "interface 2"],
        },
        attrs={"title": "A made-up barge", "program": "hydrosim 0", "status": "complete"},
    )


def position(run: xr.Dataset, dof: str) -> np.ndarray:
    """What the barge does in a degree of freedom."""
    return run.position.sel(body="barge", dof=dof).values


def write_csv(path: Path, columns: Mapping[str, np.ndarray], fmt: str = "%.9e") -> Path:
    """Columns with their names in a text file, separated by commas."""
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="", fmt=fmt)
    return path
