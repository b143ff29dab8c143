"""Studies of a case over parameters and seeds, read from a file.

case: base.yaml
parameters:
  forces.interface.friction.static: [0.2, 0.4]
  environment.waves.significant_height: [1 m, 1.5 m, 2 m]
seeds: 1-100
duration: 3 hour
output: {step: 1 s, variables: [position]}
figures: {crawl: {channel: position.barge.surge, statistic: end}}

Designs say which values of a case, by their keys, are taken together:

grid             all combinations
one_at_a_time    the case itself, then each value of each parameter, all others as in the case
latin_hypercube  so many samples, each parameter once in each of as many parts of its range
sobol            so many samples of Sobol's sequence, scrambled
sobol_indices    those of the estimators of Sobol's indices (Saltelli et al. 2010, Computer
                 Physics Communications 181): two sets A and B, and A with each column of B
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product
from math import floor, prod
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, get_args

import numpy as np
import scipy
import xarray as xr
from pydantic import BaseModel

from hydrosim.case.checks import RELATIVE
from hydrosim.case.load import Case, laid_over
from hydrosim.errors import InputError
from hydrosim.files.document_layout import letter_of
from hydrosim.files.layers import read_case
from hydrosim.files.messages import Problem, fields_of, validate_document
from hydrosim.files.outputs import settings_text
from hydrosim.files.schema_class import SchemaClass
from hydrosim.files.units import Cyclic, Quantity
from hydrosim.files.yaml_nodes import SETTING, compose_nodes, locating_in
from hydrosim.results.runs_file import KEY, LETTERS, RUN, TEXTS
from hydrosim.simulation import prepare_scene
from hydrosim.statistics.effects import CYCLIC
from hydrosim.statistics.figures import ScalarResult
from hydrosim.statistics.results import MotionCauseResult, StageResult
from hydrosim.study import study_file
from hydrosim.study.study_file import DesignPlan, LinkedKeys, Parameter, Range, StudyFile

if TYPE_CHECKING:
    from hydrosim.scene import Scene

# Coordinates of runs: the plan, and the parameter that it varies.
STUDY_LABEL = "study"
VARIED_LABEL = "varied"
Figure = ScalarResult | StageResult | MotionCauseResult
MAX_RUNS = 1_000_000
RESERVED_NAMES = {*TEXTS, RUN, STUDY_LABEL, VARIED_LABEL, "seed"}  # names that files of runs have
RESERVED_NAME_MESSAGE = (
    "found such a name; expected one that is not taken"
    f" ({', '.join(sorted(RESERVED_NAMES))}), without /"
)


@dataclass(frozen=True)
class ParameterStudy:
    """The ``scenes`` of a study file with these ``data``, and their ``labels`` along the runs:
    parameters and seeds; the files that are read, ``inputs``; the ``settings`` that its result is
    made with; the number of the ``first`` run, if these are a part of a longer study."""

    data: StudyFile
    scenes: tuple[Scene, ...]
    labels: dict[str, xr.Variable]
    inputs: tuple[Path, ...] = ()
    settings: str = ""
    first: int = 0

    @property
    def seeds(self) -> tuple[int, ...]:
        """The seeds of each combination."""
        return self.data.seeds or ()

    @property
    def figures(self) -> tuple[Figure, ...]:
        """What is asked of each run."""
        return requested_figures(self.data)

    @property
    def design(self) -> str:
        """The design in words of the file, as JSON."""
        return json.dumps(describe_study(self.data))

    def with_seeds(self, seeds: Sequence[int]) -> ParameterStudy:
        """The same combinations with other seeds, each after each other."""
        count = len(self.seeds or (0,))
        scenes = [sea for scene in self.scenes[::count] for sea in scenes_with_seeds(scene, seeds)]
        labels = {name: label[::count] for name, label in self.labels.items()}
        return replace(self, scenes=tuple(scenes), labels=_repeat_labels(labels, len(seeds)))


def read_study(path: Path) -> StudyFile:
    """The study in a YAML file; InputError says what is not valid, also what is too much."""

    def further(data: StudyFile) -> Iterator[Problem]:
        yield from _find_problems(data)
        if not os.path.isfile(path.parent / data.case):
            place = os.path.normpath(path.parent / data.case)
            text = f"found no such file at {place}; expected a case file; {RELATIVE}"
            yield Problem(("case",), text)

    return validate_document(read_case(path)[1], StudyFile, further)


def load_study(path: Path | str) -> ParameterStudy:
    """All combinations of the parameters and seeds of the study in the YAML file ``path``, the
    seeds of one combination after each other.

    Raises InputError where the study, or the case with some combination, is not valid.
    """
    path = Path(path)
    data = read_study(path)
    with locating_in(path):
        return _build_study(path, data)


class DesignRow(NamedTuple):
    """Values of a case that are taken together: the ``plan``, the ``settings`` by key, what values
    of linked parameters are ``called``, which parameter was ``varied``, one at a time; the case."""

    settings: dict[str, Any]
    called: dict[str, str]
    varied: str = ""
    plan: str = ""
    case: Case | None = None

    def value(self, key: str) -> CaseValue:
        """What the case has at a key."""
        assert self.case is not None
        return value_at_key(self.case.data, key)


def _build_study(path: Path, data: StudyFile) -> ParameterStudy:
    file = path.parent / data.case
    read = read_case(file)
    fixed = fixed_settings(data)

    def build_case(settings: Mapping[str, Any]) -> Case:
        try:
            return laid_over(file, read, {**fixed, **settings})
        except InputError as error:
            raise InputError(str(error).replace(SETTING, f"{path}: ")) from None

    def range_ends(key: str, spread: Range) -> tuple[float, float]:
        """The ends of a range in SI, each as the case reads it."""
        bounds = []
        for value in (spread.low, spread.high):
            number = value_at_key(build_case({key: value}).data, key).number
            if number is None:
                raise InputError(f"{path}: {key}: found {value}; expected a number")
            bounds.append(number)
        low, high = bounds
        if not low < high or (spread.scale == "logarithmic" and low <= 0.0):
            raise InputError(
                f"{path}: {key}: found from {low:g} to {high:g}; expected a range that rises"
                f"{', above zero' if low < high else ''}"
            )
        return low, high

    data = with_criteria_of(build_case({}), data)
    rows: list[DesignRow] = []
    for plan_name, plan in data.plans().items():
        base: DesignRow | None = None
        for row in design_rows(plan, range_ends):
            combination = row._replace(plan=plan_name, case=build_case(row.settings))
            # one at a time, the case itself is there once, also where a parameter has its value
            if base is not None and all(
                combination.value(k) == base.value(k) for k in row.settings
            ):
                base.called.update(row.called)
                continue
            if plan.design == "one_at_a_time" and not row.varied:
                base = combination
            rows.append(combination)
    labels = _parameter_labels(data, rows)
    _check_once(path, labels)
    cases = [row.case for row in rows if row.case is not None]
    inputs = dict.fromkeys([path, *(file for case in cases for file in case.inputs())])
    scenes = [sea for case in cases for sea in _seas_of_case(path, data, case)]
    labels = _repeat_labels(labels, len(data.seeds or (0,)))
    return ParameterStudy(data, tuple(scenes), labels, (*inputs,), settings_with(data, cases[0]))


def _seas_of_case(path: Path, data: StudyFile, case: Case) -> list[Scene]:
    """The scene of a case with each seed of the study."""
    scene = prepare_scene(case)
    if data.seeds is None:
        return [scene]
    if not scene.environment.waves and scene.environment.gusts is None:
        raise InputError(
            f"{path}: seeds: the case {data.case} has neither waves nor gusts; remove the key"
        )
    return scenes_with_seeds(scene, data.seeds)


def _repeat_labels(labels: Mapping[str, xr.Variable], count: int) -> dict[str, xr.Variable]:
    """Labels of combinations, each for so many seeds."""
    return {
        name: xr.Variable(RUN, np.repeat(label.values, count), label.attrs)
        for name, label in labels.items()
    }


def with_criteria_of(case: Case, data: StudyFile) -> StudyFile:
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


def settings_with(data: StudyFile, case: Case) -> str:
    """What the result of a study is made with: all that its file sets, and one of its cases."""
    study = data.model_dump(mode="json", exclude_unset=True, warnings=False)
    of_case = json.loads(case.settings())
    return settings_text(study, {f"case.{key}": value for key, value in of_case.items()})


def requested_figures(data: StudyFile) -> tuple[Figure, ...]:
    """What is asked of each run: the figures, and those of the criteria."""
    asked = {**data.figures, **data.criteria}
    return tuple(criterion.figure(name, data.output.start) for name, criterion in asked.items())


def figures_by_name(
    figures: Mapping[str, Mapping[str, object]], start: float
) -> tuple[Figure, ...]:
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


def fixed_settings(data: StudyFile) -> dict[str, Any]:
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


def describe_study(data: StudyFile) -> dict[str, Any]:
    """What the file of runs says of a study: of each plan its design and the keys of its
    parameters; the figures; what is asked of criteria."""
    plans = {
        name: {
            "design": plan.design,
            "samples": plan.samples,
            "parameters": {n: [*keys_of(n, p)] for n, p in plan.parameters.items()},
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


def _find_problems(data: StudyFile) -> Iterator[Problem]:
    count = sum(map(design_size, data.plans().values())) * len(data.seeds or (0,))
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
        if isinstance(parameter, LinkedKeys)
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


# Values of a case by their dotted keys, as numbers in SI with their units.


class CaseValue(NamedTuple):
    """A ``value`` in a case, and its SI ``unit`` if the schema knows one; whether that is
    ``cyclic``, of a frequency of waves or a density over it."""

    value: Any
    unit: str | None = None
    cyclic: bool = False

    @property
    def number(self) -> float | None:
        """The value, if it is a number."""
        plain = isinstance(self.value, int | float) and not isinstance(self.value, bool)
        return self.value if plain else None


def value_at_key(data: BaseModel, key: str) -> CaseValue:
    """What a validated case has at a dotted ``key``; a list of one may be passed over."""
    node: Any = data
    about: tuple[Any, ...] = ()
    for part in key.split("."):
        if isinstance(node, Sequence) and not part.isdigit() and len(node) == 1:
            node, about = node[0], _item_annotations(about, 0)
        if isinstance(node, BaseModel | SchemaClass):
            field = fields_of(type(node)).get(part)
            about = (field.annotation, *field.metadata) if field else ()
            node = getattr(node, part, None)
        elif isinstance(node, Mapping):
            node, about = (
                node.get(part),
                tuple(a for annotation in about for a in get_args(annotation)),
            )
        elif isinstance(node, Sequence) and part.isdigit() and int(part) < len(node):
            node, about = node[int(part)], _item_annotations(about, int(part))
        else:
            return CaseValue(None)
    quantities = [quantity for annotation in about for quantity in _quantities_in(annotation)]
    units = {quantity.unit for quantity in quantities}
    if len(units) != 1:
        return CaseValue(node)
    return CaseValue(
        node, units.pop(), any(isinstance(quantity, Cyclic) for quantity in quantities)
    )


def _item_annotations(about: tuple[Any, ...], index: int) -> tuple[Any, ...]:
    """Annotations of an item of a tuple; of any where they are not told apart."""
    annotations: list[Any] = []
    for annotation in about:
        arguments = get_args(annotation)
        fixed = getattr(annotation, "__origin__", None) is tuple and Ellipsis not in arguments
        annotations += [arguments[index]] if fixed and index < len(arguments) else arguments
    return tuple(annotations)


def _quantities_in(annotation: Any) -> Iterator[Quantity]:
    if isinstance(annotation, Quantity):
        yield annotation
    for argument in get_args(annotation):
        yield from _quantities_in(argument)


# Designs.

Ends = Callable[[str, Range], tuple[float, float]]
"""The ends of the range of a key, in SI; of type int where the key takes whole numbers alone."""


def keys_of(name: str, parameter: Parameter) -> dict[str, Any]:
    """The keys of a parameter, of each its values or range."""
    return dict(parameter.keys) if isinstance(parameter, LinkedKeys) else {name: parameter}


def design_size(plan: DesignPlan) -> int:
    """How many rows `design_rows` gives."""
    counts = [
        len(next(iter(keys_of(n, p).values())))
        for n, p in plan.parameters.items()
        if not plan.samples
    ]
    match plan.design:
        case "grid":
            return prod(counts)
        case "one_at_a_time":
            return 1 + sum(counts)
        case "sobol_indices":
            return int(plan.samples or 0) * (len(plan.parameters) + 2)
    return int(plan.samples or 0)


def design_rows(plan: DesignPlan, ends: Ends) -> Iterator[DesignRow]:
    """The combinations of a plan, in order, without their cases."""
    parameters = plan.parameters.items()
    match plan.design:
        case "grid":
            for parts in product(*(_listed_values(n, p) for n, p in parameters)):
                yield _merge_rows(parts)
        case "one_at_a_time":
            yield DesignRow({}, {})
            for name, parameter in parameters:
                for row in _listed_values(name, parameter):
                    yield row._replace(varied=name)
        case _:
            ranges = [
                {k: (s.scale == "logarithmic", *ends(k, s)) for k, s in keys_of(n, p).items()}
                for n, p in parameters
            ]
            for point in _draw_samples(plan):
                yield _merge_rows(
                    DesignRow({k: _interpolate_range(*of, part) for k, of in keys.items()}, {})
                    for keys, part in zip(ranges, point, strict=True)
                )


def _merge_rows(parts: Iterable[DesignRow]) -> DesignRow:
    row = DesignRow({}, {})
    for part in parts:
        row.settings.update(part.settings)
        row.called.update(part.called)
    return row


def _listed_values(name: str, parameter: Parameter) -> list[DesignRow]:
    keys = keys_of(name, parameter)
    names = (parameter.called or ()) if isinstance(parameter, LinkedKeys) else ()
    return [
        DesignRow(dict(zip(keys, values, strict=True)), {name: names[k]} if names else {})
        for k, values in enumerate(zip(*keys.values(), strict=True))
    ]


def _interpolate_range(logarithmic: bool, low: float, high: float, part: float) -> float:
    if isinstance(low, int):  # the first and the last are as likely as others
        return floor(_interpolate_range(logarithmic, float(low), high + 1.0, part))
    return float(low * (high / low) ** part if logarithmic else low + (high - low) * part)


def _draw_samples(plan: DesignPlan) -> np.ndarray:
    """Points (n, d) of the unit cube; for indices A, B, and A with each column of B."""
    count, d = int(plan.samples or 0), len(plan.parameters)
    if plan.design == "latin_hypercube":
        return scipy.stats.qmc.LatinHypercube(d, seed=plan.random).random(count)
    if plan.design == "sobol":
        return scipy.stats.qmc.Sobol(d, seed=plan.random).random(count)
    A, B = np.split(scipy.stats.qmc.Sobol(2 * d, seed=plan.random).random(count), 2, axis=1)
    mixed = [np.where(np.arange(d) == i, B, A) for i in range(d)]
    return np.concatenate([A, B, *mixed])


# Labels of the combinations.


def _parameter_labels(data: StudyFile, rows: Sequence[DesignRow]) -> dict[str, xr.Variable]:
    """Coordinates of all combinations: the values of all keys that are varied somewhere; names. A
    coordinate of a key has underscores for its dots, so that it can be an attribute in Python."""
    plans = data.plans().values()
    labels: dict[str, xr.Variable] = {}
    if data.studies:
        labels[STUDY_LABEL] = _label_variable([row.plan for row in rows], "plan of the study")
    if any(plan.design == "one_at_a_time" for plan in plans):
        meaning = "parameter that is varied, none in the case itself"
        labels[VARIED_LABEL] = _label_variable([row.varied for row in rows], meaning)
    for name, parameter in (item for plan in plans for item in plan.parameters.items()):
        of_keys = {key: _values_of_key(key, rows) for key in keys_of(name, parameter)}
        if isinstance(parameter, LinkedKeys):
            values, attributes = next(iter(of_keys.values()))
            if parameter.called is not None:
                values = [row.called.get(name, "") for row in rows]
                attributes = {}
            linked = f"linked: {', '.join(of_keys)}"
            labels[name] = _label_variable(values, linked, attributes)
        for key, (values, attributes) in of_keys.items():
            coordinate = key.replace(".", "_")
            there = labels.get(coordinate)
            is_taken = there is not None and there.attrs.get(KEY, key) != key
            label = _label_variable(values, key, {KEY: key, **attributes})
            labels[key if is_taken or coordinate in RESERVED_NAMES else coordinate] = label
    return labels


def _label_variable(
    values: list[Any], meaning: str, attributes: Mapping[str, Any] | None = None
) -> xr.Variable:
    """A coordinate of runs. Numbers are as they are if all are; else they are texts. Lists become
    letters, with a key to them."""
    attributes = {"long_name": meaning, **(attributes or {})}
    if all(CaseValue(value).number is not None for value in values):
        return xr.Variable(RUN, values, attributes)
    texts = [v if isinstance(v, str) else json.dumps(v, default=str) for v in values]
    if any(isinstance(value, list | tuple | dict) for value in values):
        letters = {text: letter_of(k) for k, text in enumerate(dict.fromkeys(texts))}
        attributes[LETTERS] = json.dumps({letter: text for text, letter in letters.items()})
        texts = [letters[text] for text in texts]
    return xr.Variable(RUN, texts, attributes)


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


def _values_of_key(key: str, rows: Sequence[DesignRow]) -> tuple[list[Any], dict[str, Any]]:
    """The values of a key in all cases, in SI if they are numbers, and what is said of these."""
    values = [row.value(key) for row in rows]
    if not all(value.number is not None for value in values):
        pairs = zip(rows, values, strict=True)
        return [row.settings.get(key, value.value) for row, value in pairs], {}
    of_unit = next((value for value in values if value.unit is not None), None)
    attributes: dict[str, Any] = {} if of_unit is None else {"units": of_unit.unit or "1"}
    if of_unit is not None and of_unit.cyclic:
        attributes[CYCLIC] = 1
    return [value.number for value in values], attributes
