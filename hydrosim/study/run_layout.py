"""The form of a file of runs that do not all have the same names, and equality of scenes.

One file has one set of dimensions and variables. Runs may have other contact points, elements or
bodies, and other values beside these, such as the kinetic friction of a point. Scenes that differ
in their names are tried for a few steps before the first run. The form is what all of them have:

* a dimension has the names of all runs, and what a run does not have is NaN or -1; ``NAME_in_run``
  (run, NAME) says which names a run has,
* a number beside a name that runs have otherwise gets a dimension ``run``,
* a text beside a name that runs have otherwise is left out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import Field, fields, is_dataclass, replace
from numbers import Number
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import xarray as xr

from hydrosim.elements.kind import carried_weights
from hydrosim.errors import HydrosimError
from hydrosim.integrate.names import force_names
from hydrosim.results.output import fixed_coordinates
from hydrosim.results.phases import CONTACT_WEIGHT
from hydrosim.results.runs_file import BY_RUN, DIFFERING_ATTRIBUTE, IN_RUN, MISSING

if TYPE_CHECKING:
    from hydrosim.scene import Scene

# Whether two scenes are equal.

PLAIN_TYPES = (str, Number, Path, type(None))


def _compared_fields(part: Any) -> list[Field[Any]]:
    """The fields that make a difference."""
    return [field for field in fields(part) if field.compare]


def are_scenes_equal(first: object, second: object) -> bool:
    """Whether two parts of scenes are equal: dataclasses, mappings, lists and arrays entry by
    entry, numbers and texts; anything else only if it is the same object."""
    if first is second:
        return True
    if type(first) is not type(second):
        return False
    if isinstance(first, np.ndarray):
        return np.array_equal(first, np.asarray(second))
    if isinstance(first, Mapping) and isinstance(second, Mapping):
        return list(first) == list(second) and all(
            are_scenes_equal(first[key], second[key]) for key in first
        )
    if isinstance(first, tuple | list) and isinstance(second, tuple | list):
        return len(first) == len(second) and all(map(are_scenes_equal, first, second))
    if is_dataclass(first):
        return all(
            are_scenes_equal(getattr(first, f.name), getattr(second, f.name))
            for f in _compared_fields(first)
        )
    return isinstance(first, PLAIN_TYPES) and first == second


TRIAL_STEPS = 8  # of output, for a trial
MAX_LISTED_NAMES = 6  # names in a remark
UNNAMED_DIMS = {"dof", "axis", "contact_mode", "name_of_force", "carried"}
"""Dimensions of a layout that nobody gives names to."""

Keep = Callable[[xr.Dataset], xr.Dataset]
"""What is kept of a run. Variables and figures that the run does not have are left out."""
Simulate = Callable[["Scene"], xr.Dataset]
"""Makes a run."""
Structure = tuple[object, ...]
"""Names of everything in a scene."""


class RunLayout(NamedTuple):
    """What the runs of a set have: all ``labels`` of dimensions that they do not share; the
    coordinates ``beside`` these that all agree on; the coordinates ``apart`` that have a value for
    each run, with their dimensions; coordinates that are ``left_out``; all ``variables``, empty, in
    their order; dimensions that are ``named``; what differs, in words; and the ``channels`` of
    which there are statistics."""

    labels: Mapping[str, np.ndarray]
    beside: Mapping[str, xr.Variable]
    apart: Mapping[str, xr.Variable]
    left_out: tuple[str, ...]
    variables: Mapping[str, xr.Variable]
    named: tuple[str, ...]
    remarks: tuple[str, ...]
    channels: tuple[str, ...]

    @property
    def attributes(self) -> dict[str, str]:
        """What the file says of it."""
        by_run = [*self.apart, *(f"{dim}{IN_RUN}" for dim in self.named)]
        return {DIFFERING_ATTRIBUTE: "\n".join(self.remarks), BY_RUN: " ".join(by_run)}

    def pad_run(self, dataset: xr.Dataset) -> xr.Dataset:
        """What is kept of a run, with the names of all runs."""
        values = {**self.variables, **self.apart}
        present = {name: dataset.variables[name] for name in values if name in dataset.variables}
        run = xr.Dataset(present, {dim: dataset[dim] for dim in self.labels if dim in dataset})
        labels = {dim: of for dim, of in self.labels.items() if dim in run.dims}
        fills = {name: _fill_value(of.dtype) for name, of in present.items()}
        padded = run.reindex(labels, fill_value=fills)
        sizes = dict(dataset.sizes)
        sizes.update({dim: of.size for dim, of in self.labels.items()})
        data = {
            name: padded.variables[name] if name in present else _missing_variable(of, sizes)
            for name, of in values.items()
        }
        for dim in self.named:
            is_there = np.isin(self.labels[dim], run[dim].values if dim in run else [])
            text = f"whether the run has this {dim}"
            data[f"{dim}{IN_RUN}"] = xr.Variable(dim, is_there.astype(np.int8), {"long_name": text})
        excluded = {*self.labels, *self.beside, *self.apart, *self.left_out}
        shared = {
            name: variable.variable
            for name, variable in dataset.coords.items()
            if name not in excluded
        }
        return xr.Dataset(data, {**shared, **self.beside}, dataset.attrs)


def merge_layouts(scenes: Sequence[Scene], keep: Keep, simulate: Simulate) -> RunLayout | None:
    """The form of the runs of the ``scenes``; None if they all have the same."""
    kinds, layouts = _group_scenes(scenes)
    apart = _differing_numbers(layouts)
    if len(kinds) < 2 and not apart:
        return None
    trials = [(try_scene(scenes[runs[0]], keep, simulate), len(runs)) for runs in kinds]
    counted_trials = [(trial, count) for trial, count in trials if trial is not None]
    return _merge_kinds(counted_trials, apart, _named_dims(layouts)) if counted_trials else None


def one_scene_of_each_kind(scenes: Sequence[Scene]) -> list[Scene]:
    """The first scene of each kind: those of a kind have the same names."""
    return [scenes[runs[0]] for runs in _group_scenes(scenes)[0]]


def _group_scenes(scenes: Sequence[Scene]) -> tuple[list[list[int]], list[xr.Dataset]]:
    """The runs of each kind, and the layouts of all, each once for scenes after each other."""
    kinds: dict[Structure, list[int]] = {}
    layouts: list[xr.Dataset] = []
    for index, layout in _layouts_of_runs(scenes):
        if layout is None:
            continue
        if not layouts or layouts[-1] is not layout:
            layouts.append(layout)
        kinds.setdefault(_structure_of_layout(layout), []).append(index)
    return list(kinds.values()), layouts


def _layouts_of_runs(scenes: Sequence[Scene]) -> Iterator[tuple[int, xr.Dataset | None]]:
    """The layout of each run, one object for scenes after each other that differ in their waves
    alone; None of a scene that cannot be compiled, which its own run will tell."""
    before: Scene | None = None
    layout: xr.Dataset | None = None
    for run, scene in enumerate(scenes):
        calm = without_waves(scene)
        if before is None or not are_scenes_equal(calm, before):
            before = calm
            layout = names_layout(scene)
        yield run, layout


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


def without_waves(scene: Scene) -> Scene:
    """The scene without what its coordinates do not depend on."""
    return replace(scene, title="", source={}, environment=scene.environment.without_waves())


def _structure_of_layout(layout: xr.Dataset) -> Structure:
    return tuple(
        (name, None if _is_number_beside(name, of) else tuple(np.ravel(of.values).tolist()))
        for name, of in layout.coords.items()
    )


def _is_number_beside(name: object, of: xr.DataArray | xr.Variable) -> bool:
    return (name,) != of.dims and of.dtype.kind in "fiu"


def _differing_numbers(layouts: Sequence[xr.Dataset]) -> set[str]:
    """Numbers beside names that not all scenes have the same."""
    first_values: dict[tuple[object, object], float] = {}
    differing: set[str] = set()
    for layout in layouts:
        for name, of in layout.coords.items():
            if not _is_number_beside(name, of) or of.ndim != 1:
                continue
            labels = layout[of.dims[0]].values.tolist()
            for label, value in zip(labels, of.values.tolist(), strict=True):
                if not _are_values_equal(first_values.setdefault((name, label), value), value):
                    differing.add(str(name))
    return differing


def _are_values_equal(first: object, second: object) -> bool:
    """Whether two values are equal, or both not a number."""
    return first == second or (first != first and second != second)


def _named_dims(layouts: Sequence[xr.Dataset]) -> set[str]:
    """Dimensions that scenes have names of."""
    return {str(name) for layout in layouts for name in layout.dims} - UNNAMED_DIMS


def try_scene(scene: Scene, keep: Keep, simulate: Simulate) -> xr.Dataset | None:
    """What is kept of a few steps; None where there is no such run, which its own will tell."""
    short = replace(scene, duration=min(scene.duration, TRIAL_STEPS * scene.output_step))
    try:
        run = simulate(short)
    except HydrosimError:
        return None
    return keep(run)


def _merge_kinds(
    runs: Sequence[tuple[xr.Dataset, int]], apart: set[str], named: set[str]
) -> RunLayout | None:
    """The form that holds the ``runs`` (first run of a kind of scene, number of them)."""
    datasets = [trial for trial, _ in runs]
    labels = _all_labels(datasets)
    per_run: dict[str, xr.Variable] = {}
    beside = {
        dim: xr.Variable(dim, of, _common_attributes(datasets, dim)) for dim, of in labels.items()
    }
    left_out: list[str] = []
    for name in dict.fromkeys(str(n) for trial in datasets for n in trial.coords):
        holders = [trial for trial in datasets if name in trial.coords]
        dims = holders[0][name].dims
        if name in labels or (name not in apart and not {*dims} & labels.keys()):
            continue
        all_, agree = _merge_coordinate(name, holders, labels)
        if agree and name not in apart:
            beside[name] = all_
        elif all_.dtype.kind in "fiu":
            per_run[name] = _empty_template(all_)
        else:
            left_out.append(name)
    variables = {
        str(name): _empty_template(trial.variables[name])
        for trial in reversed(datasets)
        for name in trial.data_vars
    }
    order = dict.fromkeys(str(name) for trial in datasets for name in trial.data_vars)
    lacking = [name for name in order if any(name not in trial for trial in datasets)]
    if not (labels or per_run or lacking):
        return None
    names = tuple(dim for dim in labels if dim in named)
    remarks = (*_name_remarks(runs, labels, names, lacking), *_value_remarks(per_run, left_out))
    ordered = {name: variables[name] for name in order}
    channel_lists = [
        trial.channel.values.tolist() for trial in datasets if "channel" in trial.coords
    ]
    channels = tuple(dict.fromkeys(name for own_names in channel_lists for name in own_names))
    return RunLayout(labels, beside, per_run, tuple(left_out), ordered, names, remarks, channels)


def _all_labels(datasets: Sequence[xr.Dataset]) -> dict[str, np.ndarray]:
    """All labels of each dimension that not all have the same of."""
    all_labels = {}
    for dim in dict.fromkeys(str(d) for trial in datasets for d in trial.dims):
        label_lists = [
            trial[dim].values.tolist() if dim in trial.dims else [] for trial in datasets
        ]
        if any(other != label_lists[0] for other in label_lists):
            labels = dict.fromkeys(label for labels in label_lists for label in labels)
            all_labels[dim] = np.array(list(labels))
    return all_labels


def _common_attributes(datasets: Sequence[xr.Dataset], name: str) -> Mapping[str, object]:
    """The attributes of a coordinate, of the first that has it."""
    return next((trial[name].attrs for trial in datasets if name in trial.coords), {})


def _merge_coordinate(
    name: str, datasets: Sequence[xr.Dataset], labels: Mapping[str, np.ndarray]
) -> tuple[xr.Variable, bool]:
    """A coordinate over all labels, and whether all that have it agree."""
    values: dict[tuple[object, ...], object] = {}
    agree = True
    first = datasets[0][name]
    for trial in datasets:
        label_lists = [trial[dim].values.tolist() for dim in first.dims]
        for at, value in np.ndenumerate(trial[name].values):
            place = tuple(labels_of[k] for labels_of, k in zip(label_lists, at, strict=True))
            agree = agree and _are_values_equal(values.setdefault(place, value), value)
    all_labels = [labels.get(str(dim), datasets[0][dim].values).tolist() for dim in first.dims]
    kind = object if first.dtype.kind in "OU" else first.dtype
    merged = np.full([len(of) for of in all_labels], _fill_value(first.dtype), kind)
    for at in np.ndindex(merged.shape):
        place = tuple(of[k] for of, k in zip(all_labels, at, strict=True))
        merged[at] = values.get(place, _fill_value(first.dtype))
    return xr.Variable(first.dims, merged, first.attrs), agree


def _empty_template(variable: xr.Variable) -> xr.Variable:
    """The kind of a variable, with a size of nothing."""
    return xr.Variable(
        variable.dims, np.empty((0,) * variable.ndim, variable.dtype), variable.attrs
    )


def _missing_variable(variable: xr.Variable, sizes: Mapping[Any, int]) -> xr.Variable:
    """A variable in which nothing is known."""
    shape = [sizes[dim] for dim in variable.dims]
    values = np.full(shape, _fill_value(variable.dtype), variable.dtype)
    return xr.Variable(variable.dims, values, variable.attrs)


def _fill_value(kind: np.dtype) -> object:
    """What stands where a run has nothing."""
    return {"f": np.nan, "i": MISSING, "u": 0}.get(kind.kind, "")


def _name_remarks(
    trials: Sequence[tuple[xr.Dataset, int]],
    labels: Mapping[str, np.ndarray],
    named: Sequence[str],
    lacking: Sequence[str],
) -> Iterator[str]:
    """Which names and variables not all runs have."""
    runs = sum(count for _, count in trials)
    for dim in named:
        having: Counter[object] = Counter()
        for trial, count in trials:
            names = trial[dim].values.tolist() if dim in trial.dims else []
            having.update(dict.fromkeys(names, count))
        names_by_count: dict[int, list[str]] = {}
        for label, n in having.items():
            if n < runs:
                names_by_count.setdefault(n, []).append(str(label))
        texts = (
            f"{_shorten_names(names)} in {n} of {runs} runs" for n, names in names_by_count.items()
        )
        yield f"{dim}: {'; '.join(texts)} ({dim}{IN_RUN} says which run has which)"
    dims = {name: of.dims for trial, _ in trials for name, of in trial.data_vars.items()}
    alone = [name for name in lacking if not {*dims[name]} & {*labels}]
    for name in alone:
        n = sum(count for trial, count in trials if name in trial)
        yield f"{name}: in {n} of {runs} runs"


def _shorten_names(names: Sequence[str]) -> str:
    """Names in words, no more than `MAX_LISTED_NAMES` of them."""
    return ", ".join(
        [*names[:MAX_LISTED_NAMES], *(["..."] if len(names) > MAX_LISTED_NAMES else [])]
    )


def _value_remarks(apart: Mapping[str, object], left_out: Sequence[str]) -> Iterator[str]:
    for name in apart:
        yield f"{name}: a value for each run, as they differ"
    for name in left_out:
        yield f"{name}: left out, as runs contradict each other in it"
