"""Studies of a case over parameters and seeds, read from a file, and a trial before the runs.

case: base.yaml
parameters:
  forces.interface.friction.static: [0.2, 0.4]
  environment.waves.significant_height: [1 m, 1.5 m, 2 m]
seeds: 1-100
duration: 3 hour
output: {step: 1 s, variables: [position]}
figures: {crawl: {channel: position.barge.surge, statistic: end}}
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import xarray as xr

from hydrosim.case.checks import RELATIVE
from hydrosim.case.load import Case, laid_over
from hydrosim.errors import HydrosimError, InputError
from hydrosim.files.document_layout import letter_of
from hydrosim.files.layers import read_case
from hydrosim.files.messages import Problem, validate_document
from hydrosim.files.outputs import settings_text
from hydrosim.files.units import Scale, factor
from hydrosim.files.yaml_nodes import SETTING, compose_nodes, locating_in
from hydrosim.results.runs_file import KEY, LETTERS, RUN, TEXTS
from hydrosim.simulation import NotAskable, prepare_scene
from hydrosim.statistics.effects import CYCLIC
from hydrosim.statistics.figures import RequestedStatistic, ScalarResult
from hydrosim.statistics.results import MotionCauseResult, RunResults, StageResult
from hydrosim.study import designs, study_file
from hydrosim.study.designs import CaseValue, label_values, value_at_key
from hydrosim.study.run_layout import try_scene

if TYPE_CHECKING:
    from hydrosim.scene import Scene

# Coordinates of runs: the plan, and the parameter that it varies.
STUDY_LABEL = "study"
VARIED_LABEL = "varied"
MAX_RUNS = 1_000_000
RESERVED_NAMES = {*TEXTS, RUN, STUDY_LABEL, VARIED_LABEL, "seed"}  # names that files of runs have
RESERVED_NAME_MESSAGE = (
    "found such a name; expected one that is not taken"
    f" ({', '.join(sorted(RESERVED_NAMES))}), without /"
)


@dataclass(frozen=True)
class ParameterStudy:
    """The ``scenes`` of a study and their ``labels``, along the runs: parameters and seeds; what is
    kept of the runs and which ``figures`` are asked for; the files that are read, ``inputs``; the
    ``design`` in words of the file (JSON); the ``seeds`` of each combination, and ``until`` when
    there are to be more; the ``settings`` that its result is made with; the ``bounds`` of figures,
    see `StudyFile`; the number of the ``first`` run, if these are a part of a longer study."""

    scenes: tuple[Scene, ...]
    labels: dict[str, xr.Variable]
    kept: study_file.OutputSettings
    inputs: tuple[Path, ...] = ()
    figures: tuple[ScalarResult | StageResult | MotionCauseResult, ...] = ()
    design: str = "{}"
    seeds: tuple[int, ...] = ()
    until: study_file.SeedTarget | None = None
    settings: str = ""
    bounds: Mapping[str, tuple[str, Scale]] = field(default_factory=dict)
    first: int = 0


def read_study(path: Path) -> study_file.StudyFile:
    """The study in a YAML file; InputError says what is not valid, also what is too much."""

    def further(data: study_file.StudyFile) -> Iterator[Problem]:
        yield from _find_problems(data)
        if not os.path.isfile(path.parent / data.case):
            place = os.path.normpath(path.parent / data.case)
            text = f"found no such file at {place}; expected a case file; {RELATIVE}"
            yield Problem(("case",), text)

    return validate_document(read_case(path)[1], study_file.StudyFile, further)


def load_study(path: Path | str) -> ParameterStudy:
    """All combinations of the parameters and seeds of the study in the YAML file ``path``, the
    seeds of one combination after each other.

    Raises InputError where the study, or the case with some combination, is not valid.
    """
    path = Path(path)
    data = read_study(path)
    with locating_in(path):
        return _build_study(path, data)


def _build_study(path: Path, data: study_file.StudyFile) -> ParameterStudy:
    builder = _Builder(path, data)
    data = with_criteria_of(builder.base(), data)
    rows = [row for name, plan in data.plans().items() for row in builder.rows(name, plan)]
    _check_once(path, _parameter_labels(data, rows))
    runs = [(row, scene) for row in rows for scene in row.seas(path, data)]
    return ParameterStudy(
        tuple(scene for _, scene in runs),
        _parameter_labels(data, [row for row, _ in runs]),
        data.output,
        (*builder.inputs,),
        requested_figures(data),
        json.dumps(describe_study(data)),
        data.seeds or (),
        data.until,
        settings_with(data, rows[0].case),
        data.bounds(),
    )


def with_criteria_of(case: Case, data: study_file.StudyFile) -> study_file.StudyFile:
    """A study that also holds its runs against the criteria of its ``case``, under their names,
    where the study does not use these itself."""
    names = {*data.figures, *data.criteria, *RESERVED_NAMES}
    of_case = case.data.criteria
    taken = {
        name: study_file.as_study_criterion(criterion)
        for name, criterion in of_case.items()
        if name not in names
    }
    return data.model_copy(update={"criteria": {**taken, **data.criteria}}) if taken else data


def settings_with(data: study_file.StudyFile, case: Case) -> str:
    """What the result of a study is made with: all that its file sets, and one of its cases."""
    study = data.model_dump(mode="json", exclude_unset=True, warnings=False)
    of_case = json.loads(case.settings())
    return settings_text(study, {f"case.{key}": value for key, value in of_case.items()})


def requested_figures(
    data: study_file.StudyFile,
) -> tuple[ScalarResult | StageResult | MotionCauseResult, ...]:
    """What is asked of each run: the figures, and those of the criteria."""
    asked = {**data.figures, **data.criteria}
    return tuple(criterion.figure(name, data.output.start) for name, criterion in asked.items())


def figures_by_name(
    figures: Mapping[str, Mapping[str, object]], start: float
) -> tuple[ScalarResult | StageResult | MotionCauseResult, ...]:
    """Figures with the keys of a study file, from ``start`` [s] on. Raises InputError for keys or
    values that no figure has."""
    text = json.dumps({"figures": {name: {**keys} for name, keys in figures.items()}})
    node = compose_nodes(text, "figures")
    assert node is not None
    try:
        asked = validate_document(node, study_file.RequestedFigures).figures
    except InputError as error:
        raise InputError(str(error).replace("figures:1: ", "")) from None
    return tuple(figure.figure(name, start) for name, figure in asked.items())


def fixed_settings(data: study_file.StudyFile) -> dict[str, Any]:
    """What a study sets in its case whatever varies, by key. Impulses are recorded where a figure
    needs them."""
    output = data.output
    impulses = output.impulses
    if impulses is None and any(figure.needs_impulses for figure in requested_figures(data)):
        impulses = True
    fixed = {
        "duration": data.duration,
        "output.step": output.step,
        "output.impulses": impulses,
    }
    return {key: value for key, value in fixed.items() if value is not None}


def describe_study(data: study_file.StudyFile) -> dict[str, Any]:
    """What the file of runs says of a study: of each plan its design and the keys of its
    parameters; the figures; what is asked of criteria."""
    plans = {
        name: {
            "design": plan.design,
            "samples": plan.samples,
            "parameters": {n: [*designs.keys_of(n, p)] for n, p in plan.parameters.items()},
        }
        for name, plan in data.plans().items()
    }
    criteria = {
        name: _criterion_record(name, criterion) for name, criterion in data.criteria.items()
    }
    return {"plans": plans, "figures": [*data.figures, *data.criteria], "criteria": criteria}


def _criterion_record(name: str, criterion: study_file.Criterion) -> dict[str, Any]:
    """What `hydrosim.statistics.figures` judges a criterion by."""
    figure = criterion.figure(name, 0.0)
    return {
        "limit": criterion.limit.value,
        "source": criterion.source,
        "at_least": criterion.is_lower_limit(figure),
        "never_is_late": figure.is_late_if_missing,
    }


def scenes_with_seeds(scene: Scene, seeds: Iterable[int]) -> list[Scene]:
    """One scene per seed. Its wave trains and its gusts use independent streams of that seed."""
    water = scene.environment
    return [replace(scene, environment=water.with_seed(seed)) for seed in seeds]


def _find_problems(data: study_file.StudyFile) -> Iterator[Problem]:
    count = sum(map(designs.design_size, data.plans().values())) * len(data.seeds or (0,))
    if count > MAX_RUNS:
        yield Problem(
            (),
            f"found {count:,} runs, {count / len(data.seeds or (0,)):,.0f} combinations with"
            f" {len(data.seeds or (0,)):,} seeds; expected {MAX_RUNS:,} or fewer; at ten runs a"
            f" second they would take {count / 864_000:,.1f} days. Take a Latin hypercube, fewer"
            " values, or fewer seeds",
        )
    figure_names = [*data.figures, *data.criteria]
    if data.until is not None and data.until.figure not in figure_names:
        text = f"found {data.until.figure}; expected one of: {', '.join(figure_names) or 'none'}"
        yield Problem(("until", "figure"), text)
    if data.until is not None and data.until.most < (given := len(data.seeds or ())):
        text = f"found {data.until.most:,} and {given:,} seeds; expected as many as these, or more"
        yield Problem(("until", "most"), text)
    for name in data.figures.keys() & data.criteria.keys():
        yield Problem(("criteria", name), "found the name of a figure; expected another name")
    linked = {
        name: where
        for plan, plan_data in data.plans().items()
        for name, parameter in plan_data.parameters.items()
        if isinstance(parameter, study_file.LinkedKeys)
        for where in [(*(("studies", plan) if plan else ()), "parameters", name)]
    }
    for kind, names in (("figures", data.figures), ("criteria", data.criteria)):
        for name in names:
            if not name.isidentifier():
                yield Problem((kind, name), "found such a name; expected letters, digits and _")
            if name in RESERVED_NAMES or name in linked:
                yield Problem((kind, name), RESERVED_NAME_MESSAGE)
    for name, where in linked.items():
        if name in RESERVED_NAMES or "/" in name:
            yield Problem(where, RESERVED_NAME_MESSAGE)


@dataclass(frozen=True)
class _Combination:
    """A combination: the plan, what was set, the case and its scene."""

    plan: str
    row: designs.DesignRow
    case: Case
    scene: Scene

    def seas(self, path: Path, data: study_file.StudyFile) -> list[Scene]:
        if data.seeds is None:
            return [self.scene]
        water = self.scene.environment
        if not water.waves and water.gusts is None:
            raise InputError(
                f"{path}: seeds: the case {data.case} has neither waves nor gusts; remove the key"
            )
        return scenes_with_seeds(self.scene, data.seeds)


class _Builder:
    """Cases with what a study sets in them."""

    def __init__(self, path: Path, data: study_file.StudyFile) -> None:
        self.path = path
        self.case = path.parent / data.case
        self.read = read_case(self.case)
        self.fixed = fixed_settings(data)
        self.inputs: dict[Path, None] = {path: None}

    def base(self) -> Case:
        """The case of the study, without what is varied."""
        return self._case({})

    def rows(self, name: str, plan: study_file.DesignPlan) -> list[_Combination]:
        """The combinations of a plan. One at a time, the case itself is there once, also where it
        is among the values of parameters."""
        combinations: list[_Combination] = []
        for row in designs.design_rows(plan, self._range_ends):
            case = self._case(row.settings)
            if (
                plan.design == "one_at_a_time"
                and row.varied
                and _is_same(combinations[0].case, case, row)
            ):
                combinations[0].row.called.update(row.called)
                continue
            self.inputs |= dict.fromkeys(case.inputs())
            combinations.append(_Combination(name, row, case, prepare_scene(case)))
        return combinations

    def _case(self, settings: Mapping[str, Any]) -> Case:
        try:
            return laid_over(self.case, self.read, {**self.fixed, **settings})
        except InputError as error:
            raise InputError(str(error).replace(SETTING, f"{self.path}: ")) from None

    def _range_ends(self, key: str, spread: study_file.Range) -> tuple[float, float]:
        """The ends of a range in SI, each as the case reads it."""
        bounds = []
        for value in (spread.low, spread.high):
            number = value_at_key(self._case({key: value}).data, key).number
            if number is None:
                raise InputError(f"{self.path}: {key}: found {value}; expected a number")
            bounds.append(number)
        low, high = bounds
        if not low < high or (spread.scale == "logarithmic" and low <= 0.0):
            raise InputError(
                f"{self.path}: {key}: found from {low:g} to {high:g}; expected a range that rises"
                f"{', above zero' if low < high else ''}"
            )
        return low, high


def _is_same(base: Case, case: Case, row: designs.DesignRow) -> bool:
    """Whether a case has the values of the ``base`` for all that a row sets."""
    return all(value_at_key(base.data, key) == value_at_key(case.data, key) for key in row.settings)


def _parameter_labels(
    data: study_file.StudyFile, rows: list[_Combination]
) -> dict[str, xr.Variable]:
    """Coordinates of all runs: the values of all keys that are varied somewhere; names. A
    coordinate of a key has underscores for its dots, so that it can be an attribute in Python."""
    plans = data.plans()
    labels: dict[str, xr.Variable] = {}
    if data.studies:
        labels[STUDY_LABEL] = _label_variable(
            [row.plan for row in rows], {"long_name": "plan of the study"}
        )
    if any(plan.design == "one_at_a_time" for plan in plans.values()):
        attributes = {"long_name": "parameter that is varied, none in the case itself"}
        labels[VARIED_LABEL] = _label_variable([row.row.varied for row in rows], attributes)
    for plan in plans.values():
        for name, parameter in plan.parameters.items():
            variables = {key: _values_of_key(key, rows) for key in designs.keys_of(name, parameter)}
            if isinstance(parameter, study_file.LinkedKeys):
                values, attributes = _values_of_linked(
                    name, parameter, rows, next(iter(variables.values()))
                )
                labels[name] = _label_variable(
                    values, {"long_name": f"linked: {', '.join(variables)}", **attributes}
                )
            for key, (values, attributes) in variables.items():
                coordinate = key.replace(".", "_")
                key_there = labels.get(coordinate, _label_variable([])).attrs.get(KEY, key)
                is_taken = coordinate in RESERVED_NAMES or key_there != key
                label = _label_variable(values, {"long_name": key, KEY: key, **attributes})
                labels[key if is_taken else coordinate] = label
    return labels


def _values_of_linked(
    name: str,
    parameter: study_file.LinkedKeys,
    rows: list[_Combination],
    first: tuple[list[Any], dict[str, Any]],
) -> tuple[list[Any], dict[str, Any]]:
    """Values of what is linked: their names, or else the values of its first key."""
    if parameter.called is None:
        return first
    return [row.row.called.get(name, "") for row in rows], {}


def _label_variable(values: list[Any], attributes: Mapping[str, Any] | None = None) -> xr.Variable:
    """A coordinate of runs. Lists become letters, with a key to them."""
    texts = label_values(values)
    if not any(isinstance(value, list | tuple | dict) for value in values):
        return xr.Variable(RUN, texts, attributes)
    letters = {text: letter_of(k) for k, text in enumerate(dict.fromkeys(texts))}
    meaning = {letter: text for text, letter in letters.items()}
    return xr.Variable(
        RUN, [letters[text] for text in texts], {**(attributes or {}), LETTERS: json.dumps(meaning)}
    )


def _check_once(path: Path, labels: Mapping[str, xr.Variable]) -> None:
    """Refuse combinations that are the same, such as 1 m and 100 cm: their runs, which are the same
    too, would count as if they were of other seeds."""
    rows = list(zip(*(values.values.tolist() for values in labels.values()), strict=True))
    seen: set[tuple[Any, ...]] = set()
    for row in rows:
        if row in seen:
            names = (labels[name].attrs.get(KEY, name) for name in labels)
            text = ", ".join(f"{name} {value}" for name, value in zip(names, row, strict=True))
            raise InputError(
                f"{path}: parameters: found {text} twice; expected each combination of values once,"
                " as the same runs twice say no more than once."
            )
        seen.add(row)


def _values_of_key(key: str, rows: list[_Combination]) -> tuple[list[Any], dict[str, Any]]:
    """The values of a key in all cases, in SI if they are numbers, and what is said of these."""
    case_values = {id(row): value_at_key(row.case.data, key) for row in rows}
    values = [case_values[id(row)] for row in rows]
    if all(value.number is not None for value in values):
        with_units = [value for value in values if value.unit is not None]
        return [value.number for value in values], _attributes_of_parameter(
            with_units[0]
        ) if with_units else {}
    given = [row.row.settings.get(key, v.value) for row, v in zip(rows, values, strict=True)]
    return given, {}


def _attributes_of_parameter(of: CaseValue) -> dict[str, Any]:
    return {"units": of.unit or "1", **({CYCLIC: 1} if of.cyclic else {})}


# Trial: a few steps of a scene, to check before many runs that it has the figures asked for.


def check_figures(
    file: Path, scenes: Sequence[Scene], figures: Sequence[RequestedStatistic]
) -> dict[str, str]:
    """The units of the ``figures`` that a study ``file`` asks of runs like those of the ``scenes``,
    of which some may lack some; none where no scene can be run, which its own run will say. Raises
    InputError where no run has such a channel, or a case of the study has not those of its own
    criteria."""
    units: dict[str, str] = {}
    refused: dict[str, str] = {}
    for scene in scenes:
        left = [figure for figure in figures if figure.name not in units]
        if not left or scene.initial is not None:
            break
        for name, unit in _try_figures(scene, left).items():
            if isinstance(unit, InputError):
                refused.setdefault(name, f"{file}: {name}: {unit}")
            else:
                units[name] = unit
    for name, message in refused.items():
        if name not in units:
            raise InputError(message)
    return units


def _try_figures(
    scene: Scene, figures: Sequence[RequestedStatistic]
) -> dict[str, str | InputError]:
    """The unit of each figure in a few steps of a scene, or why there is none; nothing where the
    scene cannot be run."""
    run = try_scene(scene)
    if isinstance(run, NotAskable):
        raise run
    if isinstance(run, HydrosimError):
        return {}
    units: dict[str, str | InputError] = {}
    results = RunResults(run)
    for figure in figures:
        try:
            units[figure.name] = str(figure.evaluate(results).attrs["units"])
        except InputError as error:
            units[figure.name] = error
    return units


def check_units(
    file: Path, bounds: Mapping[str, tuple[str, Scale]], units: Mapping[str, str]
) -> None:
    """Refuse bounds of figures, by key of the study ``file``, of another kind than the figures,
    whose ``units`` are known."""
    for key, (figure, bound) in bounds.items():
        if figure not in units or bound.unit is None:
            continue
        what = "limit" if key.endswith("limit") else "width"
        unit = "" if units[figure] == "1" else units[figure]
        try:
            factor(bound.unit, unit)
        except ValueError as error:
            raise InputError(
                f'{file}: {key}: found "{bound.text}"; expected a {what} in'
                f" {unit or 'plain numbers'}, which {figure} has; {error}"
            ) from None
