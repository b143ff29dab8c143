"""What becomes of one random case: it is run, judged, and compared with itself at a finer step."""

from __future__ import annotations

import warnings
from copy import deepcopy
from math import cos, log
from pathlib import Path
from tempfile import TemporaryDirectory
from traceback import format_exc
from typing import NamedTuple

import numpy as np
import xarray as xr

import hydrosim as hs
from hydrosim.errors import HydrosimError, InputError
from tests.generators.random_cases import Case, text_of

FINER = 4.0  # the step of a run over that of the run that it is compared with
TIGHTER = 256.0  # the same of tolerances: errors per second go with FINER to the order 4
OPEN = 1e-4  # of the exchanged energy: what an unwarned run may have lost
WITHIN = 1e-3  # of the range of a motion: what agrees
LEAST = 1e-6  # m or rad: a smaller range is none
NEARBY = 1e-9  # m: how far two runs begin apart, to see how they part


class Outcome(NamedTuple):
    """How a run ended: "complete", "failed", "refused" or "crash"; what was said; the residual of
    the ledger relative to the energy exchanged."""

    status: str
    message: str = ""
    warnings: str = ""
    residual: float = 0.0
    steps: int = 0


class Convergence(NamedTuple):
    """How far motions are from those at the finer step, over their range; of those that are not
    within `WITHIN`, how many times farther apart two runs are at the end that began `NEARBY`, and
    the rate of that [1/s]; 0 if not measured."""

    apart: float
    grown: float = 0.0
    rate: float = 0.0
    remark: str = ""


def tried(case: Case) -> Outcome:
    """Run a case."""
    try:
        return _judged(_run(case))
    except InputError as error:
        return Outcome("refused", str(error))
    except HydrosimError as error:
        return Outcome("failed", str(error))
    except Exception:
        return Outcome("crash", format_exc(limit=-4))


def compared(case: Case) -> Convergence:
    """Compare a case that runs with the same at a finer step."""
    try:
        run, finer = _run(case), _run(_finer(case))
    except HydrosimError as error:
        return Convergence(float("inf"), remark=f"finer step: {error}")
    apart = distance(run.position.values, finer.position.values)
    if apart <= WITHIN:
        return Convergence(apart)
    near = _run(_moved(_finer(case)))
    parted = np.abs(near.position.values - finer.position.values)[..., :3].max(axis=(1, 2))
    grown = float(parted.max()) / NEARBY
    return Convergence(apart, grown, log(max(grown, 1e-300)) / case["duration"])


def _run(case: Case) -> xr.Dataset:
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        path = Path(folder, "case.yaml")
        path.write_text(text_of(case))
        return hs.simulate(hs.load_case(path))


def _judged(run: xr.Dataset) -> Outcome:
    finite = all(np.isfinite(x).all() for x in run.data_vars.values() if x.dtype.kind == "f")
    a = run.attrs
    status = str(a["status"]) if finite else "crash"
    message = "" if finite else "not finite, and complete"
    said, residual = str(a.get("warnings", "")), float(a["energy_residual_relative"])
    return Outcome(status, message, said, residual, int(a["solver_steps"]))


def _finer(case: Case) -> Case:
    """The case at a finer step, or a tighter tolerance."""
    finer = deepcopy(case)
    solver = finer["solver"]
    solver["step"] /= FINER
    if solver["method"] in ("dopri5", "esdirk4"):
        given = {"relative": 1e-6, "position": 1e-6, "angle": 1e-8} | solver.get("tolerance", {})
        solver["tolerance"] = {key: max(x / TIGHTER, 1e-12) for key, x in given.items()}
    return finer


def _moved(case: Case) -> Case:
    """The case with all bodies moved by about `NEARBY` in what is free, each another way."""
    moved = deepcopy(case)
    for k, body in enumerate(moved["bodies"].values()):
        position = body.setdefault("initial", {}).setdefault("position", [0.0] * 6)
        free = body.get("dofs", ("surge", "sway", "heave"))
        for i, dof in enumerate(("surge", "sway", "heave")):
            position[i] += NEARBY * cos(3 * k + i) if dof in free else 0.0
    return moved


def distance(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Largest difference of places (nt, nb, 6) over the range of a body's places in ``theirs``, and
    of angles alike."""
    worst = 0.0
    for part in (slice(0, 3), slice(3, 6)):
        ranges = np.ptp(theirs[..., part], axis=0).max(axis=1)
        differences = np.abs(ours - theirs)[..., part].max(axis=(0, 2))
        worst = max(worst, float((differences / np.maximum(ranges, LEAST)).max()))
    return worst
