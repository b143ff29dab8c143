"""Designs of studies: values of a case by their keys, and which of them are taken together.

grid             all combinations
one_at_a_time    the case itself, then each value of each parameter, all others as in the case
latin_hypercube  so many samples, each parameter once in each of as many parts of its range
sobol            so many samples of Sobol's sequence, scrambled
sobol_indices    those of the estimators of Sobol's indices (Saltelli et al. 2010, Computer
                 Physics Communications 181): two sets A and B, and A with each column of B
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from math import floor, prod
from typing import Any, NamedTuple, get_args

import numpy as np
import scipy
from pydantic import BaseModel

from hydrosim.files.messages import fields_of
from hydrosim.files.schema_class import SchemaClass
from hydrosim.files.units import Cyclic, Quantity
from hydrosim.study.study_file import DesignPlan, LinkedKeys, Parameter, Range

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


def label_values(values: Sequence[Any]) -> list[Any]:
    """Numbers as they are if all are; else texts."""
    if all(CaseValue(value).number is not None for value in values):
        return list(values)
    return [value if isinstance(value, str) else json.dumps(value, default=str) for value in values]


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


Ends = Callable[[str, Range], tuple[float, float]]
"""The ends of the range of a key, in SI; of type int where the key takes whole numbers alone."""
Settings = Mapping[str, Any]


class DesignRow(NamedTuple):
    """Settings of the case, by key, and what the values of linked parameters are ``called``; which
    parameter was ``varied``, one at a time."""

    settings: dict[str, Any]
    called: dict[str, str]
    varied: str = ""


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
    """The combinations of a plan, in order."""
    match plan.design:
        case "grid":
            for grid_row in product(*(_design_values(n, p) for n, p in plan.parameters.items())):
                yield _merge_rows(grid_row)
        case "one_at_a_time":
            yield DesignRow({}, {})
            for name, parameter in plan.parameters.items():
                for row in _design_values(name, parameter):
                    yield row._replace(varied=name)
        case _:
            ranges = [_Ranges(n, p, ends) for n, p in plan.parameters.items()]
            for point in _draw_samples(plan):
                yield _merge_rows([r.row_at(u) for r, u in zip(ranges, point, strict=True)])


def _merge_rows(parts: Any) -> DesignRow:
    settings: dict[str, Any] = {}
    called: dict[str, str] = {}
    for part in parts:
        settings |= part.settings
        called |= part.called
    return DesignRow(settings, called)


def _design_values(name: str, parameter: Parameter) -> list[DesignRow]:
    keys = keys_of(name, parameter)
    names = (parameter.called or ()) if isinstance(parameter, LinkedKeys) else ()
    rows_of_keys = [
        dict(zip(keys, values, strict=True)) for values in zip(*keys.values(), strict=True)
    ]
    return [DesignRow(e, {name: names[k]} if names else {}) for k, e in enumerate(rows_of_keys)]


class _Ranges:
    """The ranges of the keys of one parameter, gone through together."""

    def __init__(self, name: str, parameter: Parameter, ends: Ends) -> None:
        self.each = {
            key: (spread.scale == "logarithmic", *ends(key, spread))
            for key, spread in keys_of(name, parameter).items()
        }

    def row_at(self, part: float) -> DesignRow:
        """A ``part`` of the way from one end to the other."""
        return DesignRow({k: _interpolate_range(*ends, part) for k, ends in self.each.items()}, {})


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
