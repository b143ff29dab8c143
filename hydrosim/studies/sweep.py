"""Studies: a case over parameters and seeds, all combinations of them, as a file says.

case: base.yaml
parameters:
  forces.interface.friction.static: [0.2, 0.4]
  environment.waves.significant_height: [1 m, 1.5 m, 2 m]
seeds: 1-100
duration: 3 hour
output: {step: 1 s, variables: [position]}
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path
from typing import Annotated, Any

import xarray as xr
from pydantic import AfterValidator, BeforeValidator, Field, StrictInt, StrictStr

from hydrosim.case.load import load_case
from hydrosim.documents import quantities as of
from hydrosim.documents.layers import read_case
from hydrosim.documents.units import problem
from hydrosim.documents.validate import validated
from hydrosim.errors import InputError
from hydrosim.outputs import Output
from hydrosim.scene import Scene
from hydrosim.studies.many import Progress, prepared, simulate_many

SPAN = re.compile(r"(\d+)\s*-\s*(\d+)", re.ASCII)
SEEDS = 'whole numbers from 0, as in 1-100 or [1, 5, 9]; or one, as in "7"'


def _spelled_out(value: Any) -> Any:
    """The numbers of "1-100", or of a single one."""
    if isinstance(value, int):
        return [value]
    span = SPAN.fullmatch(value.strip()) if isinstance(value, str) else None
    if span is not None and int(span[1]) <= int(span[2]):
        return list(range(int(span[1]), int(span[2]) + 1))
    if isinstance(value, str):
        raise problem(f'"{value}"', SEEDS)
    return value


def _some_once(values: tuple[Any, ...]) -> tuple[Any, ...]:
    texts = [json.dumps(value) for value in values]
    if not values or len(set(texts)) < len(texts):
        raise problem(f"[{', '.join(texts)}]", "one value or more, each once")
    return values


Seed = Annotated[StrictInt, Field(ge=0)]
Seeds = Annotated[tuple[Seed, ...], AfterValidator(_some_once), BeforeValidator(_spelled_out)]
Values = Annotated[tuple[Any, ...], AfterValidator(_some_once)]


class Kept(of.Strict):
    """What is kept of each run: ``variables`` every ``step``, statistics ``start`` [s] on."""

    step: of.Period | None = None
    variables: tuple[StrictStr, ...] = ("position",)
    start: of.Instant = 0.0


class StudyFile(of.Strict):
    """A whole study file; parameters are keys of the case, as with `--set`."""

    case: StrictStr
    parameters: dict[StrictStr, Values] = Field(default_factory=dict)
    seeds: Seeds | None = None
    duration: of.Period | None = None
    output: Kept = Kept()


@dataclass(frozen=True)
class Study:
    """The ``scenes`` of a study and their ``labels``, by parameter, of each its value; what is kept
    of the runs; the files that are read, ``inputs``."""

    scenes: tuple[Scene, ...]
    labels: dict[str, list[Any]]
    kept: Kept
    inputs: tuple[Path, ...] = ()


def load_study(path: Path | str) -> Study:
    """All combinations of the parameters and seeds of the study in the YAML file ``path``, the
    seeds of one combination after each other.

    Raises InputError where the study, or the case with some combination, is not valid.
    """
    path = Path(path)
    data = validated(read_case(path)[1], StudyFile)
    fixed = {"duration": data.duration, "output.step": data.output.step}
    fixed = {key: value for key, value in fixed.items() if value is not None}
    rows, scenes, inputs = [], [], {path: None}
    for values in product(*data.parameters.values()):
        settings = dict(zip(data.parameters, values, strict=True))
        case = load_case(path.parent / data.case, {**fixed, **settings})
        scene = prepared(case)
        inputs |= dict.fromkeys(case.inputs())
        if data.seeds is not None and not scene.environment.waves:
            raise InputError(f"{path}: seeds: the case {data.case} has no waves; remove the key")
        for sea in [scene] if data.seeds is None else _seas(scene, data.seeds):
            rows.append(values)
            scenes.append(sea)
    columns = zip(*rows, strict=True) if data.parameters else ()
    labels = {key: _column(c) for key, c in zip(data.parameters, columns, strict=True)}
    return Study(tuple(scenes), labels, data.output, (*inputs,))


def run_study(
    study: Study,
    output: Path | Output,
    workers: int | None = None,
    progress: Progress | None = None,
    resume: bool = False,
) -> xr.Dataset:
    """Run a study into the file ``output``, see `simulate_many`."""
    return simulate_many(
        study.scenes,
        output,
        variables=study.kept.variables,
        labels=study.labels,
        start=study.kept.start,
        workers=workers,
        progress=progress,
        resume=resume,
    )


def _seas(scene: Scene, seeds: Iterable[int]) -> list[Scene]:
    """The scene with each of the seeds for all of its wave trains, which tell themselves apart."""
    water = scene.environment
    return [
        replace(
            scene,
            environment=replace(
                water, waves=tuple(replace(train, seed=seed) for train in water.waves)
            ),
        )
        for seed in seeds
    ]


def _column(values: Iterable[Any]) -> list[Any]:
    """Numbers as they are if all are; else texts."""
    values = list(values)
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in values):
        return values
    return [value if isinstance(value, str) else json.dumps(value) for value in values]
