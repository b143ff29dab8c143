"""Statements on the figures of a seed, and the share of seeds of which they hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from cases.reverse_float_over.thesis.aggregates import share_of

Row = dict[str, str | float]


class Statement(NamedTuple):
    """Of a seed: a ``figure`` rises along each of the chains of variants in ``rising``, and is
    ``above`` a value in all of them."""

    figure: str
    rising: tuple[tuple[str, ...], ...]
    above: float = -np.inf

    def holds(self, seed: Mapping[str, Mapping[str, float]]) -> bool:
        """Whether it does, by the figures of a seed for each variant."""
        chains = [[seed[variant][self.figure] for variant in chain] for chain in self.rising]
        return all(
            chain[0] > self.above and all(a < b for a, b in pairwise(chain)) for chain in chains
        )


def rows_of_shares(
    statements: Mapping[str, Statement], seeds: Iterable[Mapping[str, Mapping[str, float]]]
) -> list[Row]:
    """A row for each statement: of how many seeds it holds, with Wilson's 90 % interval. ``seeds``
    are the figures of each seed by variant."""
    known = list(seeds)
    return [
        {"statement": name, **share_of(each.holds(seed) for seed in known)._asdict()}
        for name, each in statements.items()
    ]
