"""Designs: which values of the parameters of a plan are taken together.

grid             all combinations
one_at_a_time    the case itself, then each value of each parameter, all others as in the case
latin_hypercube  so many samples, each parameter once in each of as many parts of its range
sobol            so many samples of Sobol's sequence, scrambled
sobol_indices    those of the estimators of Sobol's indices (Saltelli et al. 2010, Computer
                 Physics Communications 181): two sets A and B, and A with each column of B
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from itertools import product
from math import floor, prod
from typing import Any, NamedTuple

import numpy as np
import scipy

from hydrosim.studies.study_file import DesignPlan, LinkedKeys, Parameter, Range

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
            for each in product(*(_values(n, p) for n, p in plan.parameters.items())):
                yield _merge_rows(each)
        case "one_at_a_time":
            yield DesignRow({}, {})
            for name, parameter in plan.parameters.items():
                for row in _values(name, parameter):
                    yield row._replace(varied=name)
        case _:
            ranges = [_Ranges(n, p, ends) for n, p in plan.parameters.items()]
            for point in _samples(plan):
                yield _merge_rows([r.row_at(u) for r, u in zip(ranges, point, strict=True)])


def _merge_rows(parts: Any) -> DesignRow:
    settings: dict[str, Any] = {}
    called: dict[str, str] = {}
    for part in parts:
        settings |= part.settings
        called |= part.called
    return DesignRow(settings, called)


def _values(name: str, parameter: Parameter) -> list[DesignRow]:
    keys = keys_of(name, parameter)
    names = (parameter.called or ()) if isinstance(parameter, LinkedKeys) else ()
    each = [dict(zip(keys, values, strict=True)) for values in zip(*keys.values(), strict=True)]
    return [DesignRow(e, {name: names[k]} if names else {}) for k, e in enumerate(each)]


class _Ranges:
    """The ranges of the keys of one parameter, gone through together."""

    def __init__(self, name: str, parameter: Parameter, ends: Ends) -> None:
        self.each = {
            key: (spread.scale == "logarithmic", *ends(key, spread))
            for key, spread in keys_of(name, parameter).items()
        }

    def row_at(self, part: float) -> DesignRow:
        """A ``part`` of the way from one end to the other."""
        return DesignRow({k: _interpolate(*ends, part) for k, ends in self.each.items()}, {})


def _interpolate(logarithmic: bool, low: float, high: float, part: float) -> float:
    if isinstance(low, int):  # the first and the last are as likely as others
        return floor(_interpolate(logarithmic, float(low), high + 1.0, part))
    return float(low * (high / low) ** part if logarithmic else low + (high - low) * part)


def _samples(plan: DesignPlan) -> np.ndarray:
    """Points (n, d) of the unit cube; for indices A, B, and A with each column of B."""
    count, d = int(plan.samples or 0), len(plan.parameters)
    if plan.design == "latin_hypercube":
        return scipy.stats.qmc.LatinHypercube(d, seed=plan.random).random(count)
    if plan.design == "sobol":
        return scipy.stats.qmc.Sobol(d, seed=plan.random).random(count)
    A, B = np.split(scipy.stats.qmc.Sobol(2 * d, seed=plan.random).random(count), 2, axis=1)
    mixed = [np.where(np.arange(d) == i, B, A) for i in range(d)]
    return np.concatenate([A, B, *mixed])
