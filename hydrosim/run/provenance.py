"""Where the numbers of a run are from, as attributes, and the case that repeats it from them."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import UTC, datetime
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.compile.restart import HEADINGS, MET, started_from
from hydrosim.errors import InputError
from hydrosim.files.cache import program_version, versions
from hydrosim.files.layers import apply_setting, settings_of, yaml_text
from hydrosim.files.yaml_nodes import compose_nodes, plain_values
from hydrosim.results.dataset import FORMAT, KIND, LATEST, ResultKind
from hydrosim.results.ledger import ACCURACY
from hydrosim.run.functions import EXTERNAL_FORCES

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.compile.compiled import Compiled
    from hydrosim.scene import Scene


def _longest_ramp(scene: Scene) -> float:
    """Time [s] over which waves and gusts grow."""
    water = scene.environment
    gusts = 0.0 if water.gusts is None else water.gusts.ramp
    return max([gusts, *(wave.ramp for wave in water.waves)])


def provenance(compiled: Compiled) -> dict[str, object]:
    """Attributes on the origin of the numbers: case, databases, seeds, radiation, solver."""
    scene = compiled.scene
    notes = compiled.notes
    return {
        "Conventions": "CF-1.11",
        KIND: ResultKind.RUN.value,
        "format": f"{FORMAT} {LATEST}",
        "date_created": datetime.now(UTC).isoformat(timespec="seconds"),
        "title": scene.title,
        **scene.source,
        "program": f"hydrosim {program_version()}",
        "versions": versions(),
        "seeds": scene.environment.seeds or None,
        "wave_ramp": _longest_ramp(scene) or None,
        "solver_method": str(scene.solver.method),
        "solver_step": scene.solver.step,
        ACCURACY: scene.solver.accuracy,
        "solver_chosen": notes.method or None,
        "skipped": "\n".join(notes.skipped) or None,
        "solver_symmetry": notes.symmetry or None,
        "zero_by_symmetry": "\n".join(notes.zero) or None,
        **started_from(scene),
        HEADINGS: compiled.derived.headings if np.any(compiled.model.headings.stream) else None,
        "seas": "\n".join(notes.seas) or None,
        "records": "\n".join(notes.records) or None,
        "meetings": "\n".join(notes.meetings) or None,
        "line_drag": "\n".join(notes.drag) or None,
        "streams": "\n".join(notes.streams) or None,
        "radiation_errors": "\n".join(notes.memory) or None,
        "radiation_error": notes.radiation_error if isfinite(notes.radiation_error) else None,
        **_wave_position_attributes(compiled),
        **{
            f"{key}_{name}": value
            for wet in compiled.wet
            for name in wet.names
            for key, value in wet.provenance().items()
        },
    }


def _wave_position_attributes(compiled: Compiled) -> dict[str, str]:
    """Positions where waves act on each wet body, for runs that continue this one."""
    met = compiled.derived.met
    wet = [name for name in met if name in compiled.derived.databases]
    return {f"{MET}_{name}": f"{met[name].position} {met[name].headings}" for name in wet}


# `case_of`: the case that repeats a run, from the data in its result.

RESOLVED_CASE, RUN_DIM = "case_resolved", "run"


def case_of(result: xr.Dataset, number: int | None = None) -> str:
    """Case file (YAML) with every default of a run and all automatic choices. For a file of many
    runs, it is the case of run ``number``, from 0 on.

    The choice of radiation: automatic is only a comment, because it follows from database and
    settings. Raises InputError if the result is not from a case file.
    """
    run = _select_run(result, number)
    text = run.attrs.get(RESOLVED_CASE)
    document = compose_nodes(str(text), RESOLVED_CASE) if text else None
    if document is None or "body" not in run:
        raise InputError("found no resolved case; expected the result of a case file.")
    settings = [
        *_wave_position_settings(run),
        *_checksum_settings(run),
        *_seed_settings(run, plain_values(document)),
    ]
    for setting in settings_of(dict(settings)):
        document = apply_setting(document, setting)
    remarks = "".join(f"# {' '.join(line.split())}\n" for line in _remarks(run))
    return f"{remarks}{yaml_text(document)}"


def _select_run(result: xr.Dataset, number: int | None) -> xr.Dataset:
    """One run of many, with its own texts as attributes."""
    if RUN_DIM not in result.dims:
        if number is not None:
            raise InputError(
                f"`number`: found {number}, but the file holds one run, so there is nothing to"
                " choose; expected no `number`. Leave it out."
            )
        return result
    last = result.sizes[RUN_DIM] - 1
    if number is None or not 0 <= number <= last:
        found_text = "no option, but the file holds many runs" if number is None else f"{number}"
        raise InputError(
            f"`number`: found {found_text}; expected the number of one run, from 0 to {last}."
        )
    run = result.isel({RUN_DIM: number})
    texts = {
        str(name): str(variable.values)
        for name, variable in run.variables.items()
        if variable.dtype.kind in "OU"
    }
    return run.assign_attrs(texts)


def _wave_position_settings(run: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Keys for the position where waves act on bodies."""
    for body in map(str, run.body.values):
        chosen = str(run.attrs.get(f"{MET}_{body}", "")).split()
        for key, place in zip(("position", "headings"), chosen, strict=False):
            yield f"bodies.{body}.wave_forces.{key}", place


def _checksum_settings(run: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Keys for the checksums of the databases."""
    for body in map(str, run.body.values):
        if checksum := run.attrs.get(f"database_checksum_{body}"):
            yield f"bodies.{body}.database_checksum", str(checksum)


def _seed_settings(run: xr.Dataset, case: Any) -> Iterator[tuple[str, int]]:
    """Keys of one run of many, to which a study may have given other seeds than its case."""
    if "seed" in run.variables:
        keys = list(_keys_of_seeds(case["environment"]))
        several = [f"seed_{k}" for k in range(2, len(keys) + 1) if f"seed_{k}" in run.variables]
        seeds = np.concatenate([np.ravel(run[name].values) for name in ("seed", *several)])
        run_seeds = np.repeat(seeds, len(keys)) if seeds.size == 1 else seeds
        for key, seed in zip(keys, run_seeds, strict=True):
            if key:
                yield key, int(seed)


def _keys_of_seeds(water: Any) -> Iterator[str]:
    """Key of the seed of each wave train, empty if it has none, and of the gusts."""
    for k, train in enumerate(water["waves"]):
        if train["spectrum"] != "none":
            yield f"environment.waves.{k}.seed" if "seed" in train else ""
    if (water.get("wind") or {}).get("gusts"):
        yield "environment.wind.gusts.seed"


def _remarks(run: xr.Dataset) -> Iterator[str]:
    yield f"case of {run.attrs['case_file']} with all defaults, in SI and radians"
    yield f"as used by {run.attrs['program']}, with {run.attrs['versions']}"
    for body in map(str, run.body.values):
        if chosen := run.attrs.get(f"radiation_{body}"):
            yield f"radiation of {body}: {chosen}"
    for line in str(run.attrs.get(EXTERNAL_FORCES, "")).splitlines():
        yield f"not in this file, but from Python by simulate(case, forces=...): {line}"
