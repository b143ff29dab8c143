"""State-space models of a database, kept on disk so that each is fitted once."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import astuple, fields
from functools import lru_cache
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from hydrosim.cache import cache_root, store
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.radiation.passivity import ROUNDING
from hydrosim.radiation.retardation import Retardation
from hydrosim.radiation.state_space import (
    TOLERANCE,
    FitReport,
    StateSpace,
    coupled_groups,
    fit_group,
)

ARRAYS = tuple(field.name for field in fields(StateSpace) if field.name != "report")


REFUSED = 10.0  # times the tolerance: a larger error of a passive fit is refused


def fit(
    checksum: str,
    source: str,
    memory: Retardation,
    frequency: np.ndarray,
    tolerance: float = TOLERANCE,
) -> tuple[StateSpace, ...]:
    """State-space models of all coupled groups of DOFs of a database, see `fit_group`.

    Raises InputError, which names the database's ``source``, where no passive fit has an error
    below ten times the tolerance.

    They are kept in the cache folder by the database's ``checksum``, the table of K, the band of
    ``frequency`` [rad/s], the tolerance and this package's sources. A file that cannot be read is
    made again; a folder that cannot be written costs only the time of the next fit.
    """
    band = float(frequency[-1])
    settings = (checksum, memory.time.size, float(memory.time[-1]), band, tolerance, _version())
    key = hashlib.sha256(repr(settings).encode()).hexdigest()[:24]
    path = cache_root() / "fits" / f"{key}.npz"
    models = _cached(path)
    if models is None:
        groups = coupled_groups(memory.kernel, tolerance)
        models = tuple(fit_group(memory, dofs, band, tolerance) for dofs in groups)
        with suppress(OSError):
            _write(path, models)
    for model in models:
        _check(model, source)
    return models


def _check(model: StateSpace, source: str) -> None:
    report = model.report
    if (
        report.passivity_margin >= -ROUNDING
        and report.frequency_error <= REFUSED * report.tolerance
    ):
        return
    dofs = ", ".join(
        DOFS[dof % 6] + (f" of body {dof // 6 + 1}" if dof > 5 else "") for dof in model.dofs
    )
    raise InputError(
        f"{source}: found no state-space model of the radiation in {dofs} that is passive within"
        f" {REFUSED:g} times the tolerance {report.tolerance:g}: the nearest, of {model.order}"
        f" states, is {report.frequency_error:.1e} off (passivity {report.passivity_margin:.1e},"
        f" {report.passivity_before:.1e} before); expected damping that is nowhere negative and"
        " smooth. Run `hydrosim db check`; set radiation: {model: state_space, tolerance:"
        f" {_rounded_up(report.frequency_error):g}}} or radiation: convolution."
    )


def _rounded_up(error: float) -> float:
    """A tolerance of one digit that this error is within."""
    size = 10.0 ** np.floor(np.log10(error))
    return float(np.ceil(error / size) * size)


@lru_cache
def _version() -> str:
    """Hash of this package's sources: another way of fitting is another file."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.glob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _cached(path: Path) -> tuple[StateSpace, ...] | None:
    with suppress(OSError, ValueError, KeyError, TypeError, EOFError, BadZipFile):
        return _read(path)
    return None


def _read(path: Path) -> tuple[StateSpace, ...]:
    with np.load(path, allow_pickle=False) as data:
        return tuple(
            StateSpace(
                **{name: data[f"{name}_{k}"] for name in ARRAYS},
                report=FitReport(*map(float, data[f"report_{k}"])),
            )
            for k in range(int(data["groups"]))
        )


def _write(path: Path, models: Sequence[StateSpace]) -> None:
    arrays: dict[str, Any] = {"groups": np.array(len(models))}
    for k, model in enumerate(models):
        arrays |= {f"{name}_{k}": getattr(model, name) for name in ARRAYS}
        arrays[f"report_{k}"] = np.array(astuple(model.report))
    store(path, lambda file: np.savez(file, **arrays))
