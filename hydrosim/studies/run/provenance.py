"""Attributes of a run on the origin of its numbers."""

from __future__ import annotations

from datetime import UTC, datetime
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.restart import HEADINGS, MET, started_from
from hydrosim.program import program_version, versions
from hydrosim.results.error_figures import ACCURACY
from hydrosim.results.netcdf import FORMAT, LATEST

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
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
        HEADINGS: compiled.facts.headings if np.any(compiled.model.headings.stream) else None,
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
    met = compiled.facts.met
    wet = [name for name in met if name in compiled.facts.databases]
    return {f"{MET}_{name}": f"{met[name].position} {met[name].headings}" for name in wet}
