"""What is kept of a run of a set, trials before the runs, and the layout that all runs share.

One file has one set of dimensions and variables. Runs may have other contact points, elements or
bodies, and other values beside these, such as the kinetic friction of a point. Scenes that differ
in their names are tried for a few steps before the first run. The layout is an empty run of all
names. A run is padded to it:

* a dimension has the names of all runs, and what a run does not have is NaN or -1; ``NAME_in_run``
  (run, NAME) says which names a run has,
* a number beside a name that runs have otherwise gets a dimension ``run``,
* a text beside a name that runs have otherwise is left out.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zlib import crc32

import numpy as np
import xarray as xr

from hydrosim.elements.kind import carried_weights
from hydrosim.errors import HydrosimError, InputError
from hydrosim.files.units import Scale, factor
from hydrosim.files.yaml_nodes import with_hint
from hydrosim.integrate.names import force_names
from hydrosim.results.channels import channel_names, match_channels
from hydrosim.results.dataset import new_dataset
from hydrosim.results.ledger import RELATIVE
from hydrosim.results.memory import MEMORY_PREFIX
from hydrosim.results.output import fixed_coordinates
from hydrosim.results.phases import CONTACT_WEIGHT
from hydrosim.results.runs_file import (
    BY_RUN,
    COUNT_ATTRIBUTES,
    DIFFERING_ATTRIBUTE,
    IN_RUN,
    MISSING,
)
from hydrosim.results.variables import describe_coordinates, quantity_attributes
from hydrosim.simulation import NotAskable, simulate
from hydrosim.statistics.figures import RequestedStatistic
from hydrosim.statistics.results import RunResults
from hydrosim.statistics.statistics import RECORDED_SUFFIX, columns, unit_statistics
from hydrosim.study.scene_cache import are_scenes_equal, without_waves

if TYPE_CHECKING:
    from hydrosim.scene import Scene


def reduce_run(
    run: xr.Dataset,
    variables: Sequence[str],
    start: float,
    figures: Sequence[RequestedStatistic] = (),
    channels: Sequence[str] = (),
    lenient: bool = False,
    layout: xr.Dataset | None = None,
) -> xr.Dataset:
    """What is kept of a run: its variables, and statistics from ``start`` [s] on. With a
    ``layout``, it is padded to that. Raises InputError where the run has not all variables, figures
    and ``channels`` (patterns) that are asked for, unless ``lenient``: it is then left out."""
    unknown = [name for name in variables if name not in run]
    if unknown and not lenient:
        series_names = ", ".join(
            str(name) for name, variable in run.items() if "time" in variable.dims
        )
        meant = next((name.partition(".")[0] for name in unknown if "." in name), "")
        text = f"variables: found {', '.join(unknown)}; expected some of: {series_names}"
        raise InputError(with_hint(text, f'did you mean "{meant}"?' if meant in run else ""))
    statistics, coords, attributes = columns(
        run, start, None, _chosen_channels(run, channels, lenient)
    )
    statistics = {name: of for name, of in statistics.items() if not name.endswith(RECORDED_SUFFIX)}
    variables_of_run: dict[str, Any] = {
        **statistics,
        **unit_statistics(run),
        "end_position": _end_position(run),
    }
    if "fender" in run.dims:
        variables_of_run |= {
            "first_contact": _first_contact_times(run),
            "contact_sequence": _contact_sequence(run),
        }
    variables_of_run |= {
        name: xr.Variable((), run.attrs[name], quantity_attributes(what, "1"))
        for name, what in COUNT_ATTRIBUTES.items()
    }
    variables_of_run[RELATIVE] = _relative_error(run)
    results = RunResults(run)
    why = results.explanation if "impulse" in run else xr.Dataset()
    check_figure_names(figures, {*variables_of_run, *coords, *run.variables, *why})
    for figure in figures:
        try:
            variables_of_run[figure.name] = figure.evaluate(results).variable
        except InputError:
            if not lenient:
                raise
    reduced = new_dataset(variables_of_run, coords, attributes)
    if why:
        reduced = xr.merge([reduced, why], join="exact", compat="equals")
    if variables:
        series = run[[name for name in variables if name in run]]
        reduced = xr.merge([series, reduced], join="outer", compat="equals")
    # adaptive runs end their last steps at different times
    reduced = describe_coordinates(reduced).drop_vars(
        [name for name in reduced.coords if str(name).startswith(MEMORY_PREFIX)]
    )
    return reduced if layout is None else pad_run(reduced, layout)


def check_figure_names(figures: Sequence[RequestedStatistic], taken: Collection[object]) -> None:
    """Raises InputError where a figure has the name of a variable of the runs."""
    for figure in figures:
        if figure.name in taken:
            raise InputError(
                f"figures, criteria: found the name {figure.name}, which is that of a variable"
                f" of the runs; expected another one, such as {figure.name}_of_run."
            )


def _chosen_channels(run: xr.Dataset, patterns: Sequence[str], lenient: bool) -> list[str]:
    """The channels of a run that patterns fit."""
    if not patterns:
        return []
    channels = channel_names(run)
    if lenient:
        patterns = [pattern for pattern in patterns if fnmatch.filter(channels, pattern)]
    return match_channels(channels, patterns, "output.channels")


def _end_position(run: xr.Dataset) -> xr.Variable:
    end = run.variables["position"].isel(time=-1)
    end.attrs["long_name"] = "displacement and angles at the end of the run"
    return end


def _relative_error(run: xr.Dataset) -> xr.Variable:
    """The measured error of motions, NaN where a run did not measure it."""
    attributes = quantity_attributes("largest error of a motion, relative to its range", "1")
    return xr.Variable((), float(run.attrs.get(RELATIVE, np.nan)), attributes)


def _contact_sequence(run: xr.Dataset) -> xr.Variable:
    """A number for the order in which contacts open, stick and slip, as recorded. Runs with
    other orders have other numbers."""
    modes = run.fender_mode.transpose("time", "fender").values
    changed = np.any(modes[1:] != modes[:-1], axis=1)
    order = modes[np.append(True, changed)].astype(np.int8)
    attributes = {"units": "1", "long_name": "checksum of the order of contact modes"}
    return xr.Variable((), np.int64(crc32(np.ascontiguousarray(order).tobytes())), attributes)


def _first_contact_times(run: xr.Dataset) -> xr.Variable:
    """When each group of contacts touches first, NaN if it does not."""
    phase = run.contact_phase.transpose("contact_group", "time").values
    first = [run.time.values[np.argmax(of > 0)] if of.any() else np.nan for of in phase]
    attributes = {"units": "s", "long_name": "time of the first contact of a fender of the group"}
    return xr.Variable("contact_group", first, attributes)


TRIAL_STEPS = 8  # of output, for a trial
MAX_LISTED_NAMES = 6  # names in a remark
UNNAMED_DIMS = {"dof", "axis", "contact_mode", "name_of_force", "carried"}
"""Dimensions of the names of a scene that nobody gives names to."""
CHANNELS = "channels"  # attribute of a layout: channels of which some run has statistics


def try_scene(scene: Scene) -> xr.Dataset | HydrosimError:
    """The run of a few steps of a scene, or why there is none."""
    try:
        return simulate(
            replace(scene, duration=min(scene.duration, TRIAL_STEPS * scene.output_step))
        )
    except HydrosimError as error:
        return error


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
        run = try_scene(scene)
        if isinstance(run, NotAskable):
            raise run
        if isinstance(run, HydrosimError):
            continue
        results = RunResults(run)
        for figure in left:
            try:
                units[figure.name] = str(figure.evaluate(results).attrs["units"])
            except InputError as error:
                refused.setdefault(figure.name, f"{file}: {figure.name}: {error}")
    for name, message in refused.items():
        if name not in units:
            raise InputError(message)
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


def merge_layouts(
    scenes: Sequence[Scene], reduce: Callable[[xr.Dataset], xr.Dataset]
) -> xr.Dataset | None:
    """The layout of the runs of the ``scenes``; None if they all have the same. ``reduce`` says
    what is kept of a run, and leaves out what the run has not."""
    kinds, names = _group_scenes(scenes)
    differing = _differing_numbers(names)
    if len(kinds) < 2 and not differing:
        return None
    trials = [(try_scene(scenes[runs[0]]), len(runs)) for runs in kinds]
    reduced = [(reduce(run), n) for run, n in trials if not isinstance(run, HydrosimError)]
    dims = {str(name) for of_scene in names for name in of_scene.dims} - UNNAMED_DIMS
    return _merge_trials(reduced, differing, dims) if reduced else None


def one_scene_of_each_kind(scenes: Sequence[Scene]) -> list[Scene]:
    """The first scene of each kind: those of a kind have the same names."""
    return [scenes[runs[0]] for runs in _group_scenes(scenes)[0]]


def _group_scenes(scenes: Sequence[Scene]) -> tuple[list[list[int]], list[xr.Dataset]]:
    """The runs of each kind, and the names of all, each once for scenes after each other that
    differ in their waves alone. A scene that has none cannot be compiled, as its own run will
    tell."""
    kinds: dict[tuple[object, ...], list[int]] = {}
    layouts: list[xr.Dataset] = []
    before: Scene | None = None
    layout: xr.Dataset | None = None
    for run, scene in enumerate(scenes):
        calm = without_waves(scene)
        if before is None or not are_scenes_equal(calm, before):
            before = calm
            layout = names_layout(scene)
            layouts += [] if layout is None else [layout]
        if layout is not None:
            kinds.setdefault(_structure_of_layout(layout), []).append(run)
    return list(kinds.values()), layouts


NAMES_OF_LAYOUT = {"name_of_force", "carried"}
"""Dimensions of a layout that are not in runs."""


def names_layout(scene: Scene) -> xr.Dataset | None:
    """The names in the runs of a scene and the numbers beside them."""
    weights = carried_weights(scene)
    names = {
        "name_of_force": list(force_names(scene)),
        "accelerations": scene.output.accelerations,
        "carried": list(weights),
        CONTACT_WEIGHT: ("carried", list(weights.values())),
    }
    try:
        return xr.Dataset(coords={**fixed_coordinates(scene), **names})
    except (HydrosimError, KeyError, ValueError):
        return None


def _structure_of_layout(layout: xr.Dataset) -> tuple[object, ...]:
    return tuple(
        (name, None if _is_number_beside(array) else tuple(np.ravel(array.values).tolist()))
        for name, array in layout.coords.items()
    )


def _is_number_beside(array: xr.DataArray) -> bool:
    return (array.name,) != array.dims and array.dtype.kind in "fiu"


def _differing_numbers(layouts: Sequence[xr.Dataset]) -> set[str]:
    """Numbers beside names that not all scenes have the same."""
    values: dict[tuple[str, object], set[object]] = {}
    for array in (array for layout in layouts for array in layout.coords.values()):
        if _is_number_beside(array) and array.ndim == 1:
            labels = array[array.dims[0]].values.tolist()
            for label, value in zip(labels, array.values.tolist(), strict=True):
                numbers = values.setdefault((str(array.name), label), set())
                numbers.add(None if value != value else value)
    return {name for (name, _), numbers in values.items() if len(numbers) > 1}


def _merge_trials(
    trials: Sequence[tuple[xr.Dataset, int]], differing: set[str], named: set[str]
) -> xr.Dataset | None:
    """The layout that holds the ``trials`` (first run of a kind of scene, number of them); None if
    they have the same."""
    datasets = [trial for trial, _ in trials]
    labels = _differing_labels(datasets)
    coords = dict(labels)
    templates: dict[str, xr.Variable] = {}
    for trial in datasets:
        for name, array in trial.data_vars.items():
            templates.setdefault(str(name), array.variable)
    lacking = [name for name in templates if any(name not in trial for trial in datasets)]
    by_run: list[str] = []
    left_out: list[str] = []
    for name in dict.fromkeys(str(n) for trial in datasets for n in trial.coords):
        arrays = [trial[name] for trial in datasets if name in trial.coords]
        first = arrays[0]
        if name in labels or not (name in differing or {*first.dims} & labels.keys()):
            continue
        merged = None if name in differing else _merge_arrays(arrays, labels)
        if merged is not None:
            coords[name] = merged
        elif first.dtype.kind in "fiu":
            templates[name] = first.variable
            by_run.append(name)
        else:
            left_out.append(name)
    if not (labels or by_run or lacking):
        return None
    names = [dim for dim in labels if dim in named]
    remarks = [
        *_name_remarks(trials, labels, names),
        *_lack_remarks(trials, [n for n in lacking if not {*templates[n].dims} & labels.keys()]),
        *(f"{name}: a value for each run, as they differ" for name in by_run),
        *(f"{name}: left out, as runs contradict each other in it" for name in left_out),
    ]
    for dim in names:
        about = {"long_name": f"whether the run has this {dim}"}
        templates[f"{dim}{IN_RUN}"] = xr.Variable(dim, np.zeros(0, np.int8), about)
        by_run.append(f"{dim}{IN_RUN}")
    channels = [name for trial in datasets for name in _labels_of(trial, "channel")]
    attributes = {
        DIFFERING_ATTRIBUTE: "\n".join(remarks),
        BY_RUN: " ".join(by_run),
        CHANNELS: [*dict.fromkeys(channels)],
    }
    sizes = {dim: size for trial in datasets for dim, size in trial.sizes.items()}
    sizes |= {dim: of.size for dim, of in labels.items()}
    missing = {name: _missing_variable(name, of, sizes) for name, of in templates.items()}
    return xr.Dataset(missing, coords, attributes)


def attributes_of_layout(layout: xr.Dataset) -> dict[str, str]:
    """What the file says of a layout."""
    return {name: layout.attrs[name] for name in (DIFFERING_ATTRIBUTE, BY_RUN)}


def pad_run(run: xr.Dataset, layout: xr.Dataset) -> xr.Dataset:
    """What is kept of a run, with the names of all runs."""
    labels = dict(layout.indexes)
    flags = {dim: f"{dim}{IN_RUN}" for dim in run.dims if f"{dim}{IN_RUN}" in layout}
    run = run.assign(
        {
            flag: (dim, np.ones(run.sizes[dim], np.int8), layout[flag].attrs)
            for dim, flag in flags.items()
        }
    )
    present = {name: run.variables[name] for name in layout.data_vars if name in run.variables}
    there = {dim: index for dim, index in labels.items() if dim in run.dims}
    fills = {name: _fill_value(str(name), of.dtype) for name, of in present.items()}
    padded = xr.Dataset(present, {dim: run[dim] for dim in there}).reindex(there, fill_value=fills)
    sizes = {**run.sizes, **{dim: len(index) for dim, index in labels.items()}}
    data = {
        name: padded.variables[name]
        if name in present
        else _missing_variable(str(name), of.variable, sizes)
        for name, of in layout.data_vars.items()
    }
    shared = {
        name: of.variable
        for name, of in run.coords.items()
        if name not in layout.variables and not {*of.dims} & labels.keys()
    }
    return xr.Dataset(data, {**shared, **layout.coords.variables}, run.attrs)


def _labels_of(trial: xr.Dataset, dim: str) -> list[Any]:
    """Labels of a run along a dimension, none if it has not the dimension."""
    return trial[dim].values.tolist() if dim in trial.dims else []


def _differing_labels(datasets: Sequence[xr.Dataset]) -> dict[str, xr.Variable]:
    """All labels of each dimension that not all have the same of, in their order."""
    all_labels = {}
    for dim in dict.fromkeys(str(d) for trial in datasets for d in trial.dims):
        lists = [_labels_of(trial, dim) for trial in datasets]
        if any(labels != lists[0] for labels in lists):
            labels = np.array([*dict.fromkeys(label for of in lists for label in of)])
            first = next(trial[dim] for trial in datasets if dim in trial.dims)
            all_labels[dim] = xr.Variable(dim, labels, first.attrs)
    return all_labels


def _merge_arrays(
    arrays: Sequence[xr.DataArray], labels: Mapping[str, xr.Variable]
) -> xr.Variable | None:
    """The values beside all labels; None where runs contradict each other."""
    first = arrays[0]
    fill = _fill_value(str(first.name), first.dtype)
    parts = [array.reset_coords(drop=True) for array in arrays]
    try:
        merged = xr.merge(parts, compat="no_conflicts", join="outer", combine_attrs="override")
    except xr.MergeError:
        return None
    along = {dim: of.values for dim, of in labels.items() if dim in first.dims}
    values = merged[first.name].reindex(along).fillna(fill).transpose(*first.dims).values
    kind = object if first.dtype.kind in "OU" else first.dtype
    return xr.Variable(first.dims, values.astype(kind), first.attrs)


def _missing_variable(name: str, template: xr.Variable, sizes: Mapping[Any, int]) -> xr.Variable:
    """A variable in which nothing is known."""
    shape = [sizes[dim] for dim in template.dims]
    values = np.full(shape, _fill_value(name, template.dtype), template.dtype)
    return xr.Variable(template.dims, values, template.attrs)


def _fill_value(name: str, kind: np.dtype) -> object:
    """What stands where a run has nothing."""
    if name.endswith(IN_RUN):
        return 0
    return {"f": np.nan, "i": MISSING, "u": 0}.get(kind.kind, "")


def _name_remarks(
    trials: Sequence[tuple[xr.Dataset, int]], labels: Mapping[str, xr.Variable], dims: Sequence[str]
) -> Iterator[str]:
    """Which names not all runs have."""
    runs = sum(count for _, count in trials)
    for dim in dims:
        names = labels[dim].values
        counts = sum(np.isin(names, _labels_of(trial, dim)) * count for trial, count in trials)
        texts = [
            f"{_shorten_names(names[counts == n].tolist())} in {n} of {runs} runs"
            for n in dict.fromkeys(np.atleast_1d(counts).tolist())
            if n < runs
        ]
        yield f"{dim}: {'; '.join(texts)} ({dim}{IN_RUN} says which run has which)"


def _lack_remarks(
    trials: Sequence[tuple[xr.Dataset, int]], variables: Sequence[str]
) -> Iterator[str]:
    """Which variables not all runs have."""
    runs = sum(count for _, count in trials)
    for name in variables:
        having = sum(count for trial, count in trials if name in trial)
        yield f"{name}: in {having} of {runs} runs"


def _shorten_names(names: Sequence[str]) -> str:
    """Names in words, no more than `MAX_LISTED_NAMES` of them."""
    more = ["..."] if len(names) > MAX_LISTED_NAMES else []
    return ", ".join([*names[:MAX_LISTED_NAMES], *more])
