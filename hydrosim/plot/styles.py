"""Colours and dashes of lines: the same in all pictures, and distinct without colours."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import cycle
from typing import NamedTuple

# Okabe & Ito (2008): colours that the colour-blind can distinguish. The first three are also
# distinct in grey. Later lines are dashed, and dotted in the next round.
COLOURS = ("#0072B2", "#E69F00", "#000000", "#009E73", "#D55E00", "#56B4E9", "#CC79A7")
SOLID = 3
MODES = {2: ("slip", "#E69F00"), 1: ("stick", "#0072B2"), 0: ("open", "#DDDDDD")}  # bottom to top
SHADE = "#EDEDED"  # of every other phase


class Style(NamedTuple):
    """Style of a line."""

    colour: str
    dash: str


STYLES = [
    *(Style(colour, "-") for colour in COLOURS[:SOLID]),
    *(Style(colour, "--") for colour in COLOURS[SOLID:]),
    *(Style(colour, ":") for colour in COLOURS),
    *(Style(colour, "-.") for colour in COLOURS),
]


def styles(names: Iterable[str]) -> dict[str, Style]:
    """Style of each of many names, by their order."""
    return dict(zip(names, cycle(STYLES), strict=False))
