"""Memory and result size of a scene, estimated before it is computed."""

from __future__ import annotations

import os
from collections import Counter
from collections.abc import Iterator
from math import inf, pi
from pathlib import Path
from typing import NamedTuple

from hydrosim.errors import InputError
from hydrosim.scene import (
    AutomaticRadiation,
    Body,
    Coefficients,
    ConvolutionRadiation,
    Density,
    Scene,
    StateSpaceRadiation,
)
from hydrosim.scene.hydrodynamics import LENGTH
from hydrosim.water.radiation.retardation import FINER
from hydrosim.water.spectra import cut_off

NUMBER = 8  # bytes
MOST_STEPS = 1e12  # steps of a run that takes months
MOST_ROWS = 20_000  # rows of a table of retardation functions: 100 s every 5 ms
MOST_WAVES = 2e6  # waves of all trains
CONTAINER = Path("/sys/fs/cgroup/memory.max")


class MemoryUse(NamedTuple):
    """A use of memory: the key and value that cause it, the ``bytes``, and the remedy."""

    key: str
    memory: float
    remedy: str


def memory_needed(scene: Scene) -> float:
    """Memory [bytes] that a run needs, within a factor of about two."""
    return sum(part.memory for part in _parts(scene))


def result_size(scene: Scene) -> float:
    """Approximate size [bytes] of the result of a run."""
    states = _states(scene) if scene.output_states else 0.0
    return NUMBER * _records(scene) * (_channels(scene) + states)


def check_sizes(scene: Scene) -> None:
    """Raises InputError if a scene does not fit into the memory, or would take months."""
    steps = scene.duration / scene.solver.step
    if not scene.solver.method.adapts and steps > MOST_STEPS:
        raise InputError(
            f"duration: found {scene.duration:g} s in steps of {scene.solver.step:g} s, {steps:.1e}"
            f" steps; expected at most {MOST_STEPS:g}, which take months. Shorten the duration."
        )
    for body in scene.bodies:
        if _rows(body) > MOST_ROWS:
            raise InputError(
                f"bodies.{body.name}.radiation: found a table of {_rows(body):.3g} rows (length"
                f" over step); expected at most {MOST_ROWS:,}. Choose a larger step; it does not"
                " depend on the step of the run."
            )
    count = sum(_waves(scene))
    if count > MOST_WAVES:
        raise InputError(
            f"environment.waves.repeat_period: found {count:.1e} waves in all trains, and"
            f" components of gusts; expected at most {MOST_WAVES:g}. Choose periods about as long"
            " as the run, or fewer trains."
        )
    largest = max(_parts(scene), key=lambda part: part.memory)
    most = _available()
    if memory_needed(scene) > most:
        raise InputError(
            f"{largest.key}: the run needs about {size_text(memory_needed(scene))} of memory,"
            f" {size_text(largest.memory)} of it for this; only {size_text(most)} exist."
            f" {largest.remedy}."
        )


def size_text(size: float) -> str:
    """Number of bytes as text with a unit."""
    for unit in ("kB", "MB", "GB"):
        size /= 1000.0
        if size < 1000.0:
            return f"{size:.3g} {unit}"
    return f"{size / 1000.0:.3g} TB"


def _parts(scene: Scene) -> Iterator[MemoryUse]:
    motions = 6 * len(scene.bodies)
    # records are copied once for the dataset
    recorded = NUMBER * _records(scene) * (2.0 * _channels(scene) + _states(scene))
    yield MemoryUse("output.step", recorded, "Record less often, or make a shorter run")
    # components, their loads, and a table over time of both
    wave = NUMBER * (6 + 8 * (1 + motions))
    waves = wave * sum(_waves(scene))
    yield MemoryUse("environment.waves.repeat_period", waves, "Shorten it")
    tables = NUMBER * 3 * FINER * 36 * _rows_of_pairs(scene)
    yield MemoryUse("bodies.radiation", tables, "Choose a larger step or a shorter length")


def _records(scene: Scene) -> float:
    return scene.duration / scene.output_step + 1.0


def _channels(scene: Scene) -> float:
    """Numbers in a stored record."""
    motions = 6 * len(scene.bodies)
    forces = 4 + len(scene.forces)
    points = sum(len(element.unit_names(name)) for name, element in scene.forces.items())
    rates = 2.0 + float(scene.output_accelerations)
    return 6.0 + rates * motions + forces * (2.0 + motions) + 20.0 * points + len(scene.wave_probes)


def _states(scene: Scene) -> float:
    """Estimated number of states of a scene, with a usual number of radiation states."""
    return sum(12.0 + (60.0 if body.hydrodynamics is not None else 0.0) for body in scene.bodies)


def _rows(body: Body) -> float:
    table = body.radiation
    if body.hydrodynamics is None or not isinstance(
        table, AutomaticRadiation | StateSpaceRadiation | ConvolutionRadiation
    ):
        return 0.0
    length = LENGTH if table.length is None else table.length
    return length / table.step


def _rows_of_pairs(scene: Scene) -> float:
    """Rows of the tables of all pairs of bodies of one database; others do not feel each other."""
    wet = [body for body in scene.bodies if _rows(body) > 0.0]
    pairs = Counter(_database_key(body) for body in wet)
    return sum(_rows(body) * pairs[_database_key(body)] for body in wet)


def _database_key(body: Body) -> tuple[object, ...]:
    """What bodies of one database have in common; a body of its own coefficients is alone."""
    if isinstance(body.hydrodynamics, Coefficients):
        return (body.name,)
    return (body.hydrodynamics, *body.location, body.heading)


def _waves(scene: Scene) -> Iterator[float]:
    """Number of waves in each random sea, and of components of gusts."""
    for train in scene.environment.waves:
        if isinstance(train.spectrum, Density):
            yield cut_off(train.spectrum) * train.repeat_period / (2.0 * pi)
    if (gusts := scene.environment.gusts) is not None:
        yield gusts.highest * gusts.repeat_period / (2.0 * pi)


def _available() -> float:
    """Memory of the machine [bytes], or of the container."""
    most = inf
    if hasattr(os, "sysconf"):
        most = float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    try:
        return min(most, float(CONTAINER.read_text()))
    except (OSError, ValueError):  # missing, or "max"
        return most
