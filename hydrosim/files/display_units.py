"""In which unit a quantity is read. Results hold SI; people read degrees, kilonewtons, tonnes.

A case that writes a unit for a kind of quantity is answered in that unit. What it does not write is
read in `DEFAULT_UNITS`. Units of products follow those of their parts: with forces in kN and
lengths in m, a moment is read in kN m. With forces in N, energies are read in J, not in MJ.
"""

from __future__ import annotations

import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from hydrosim.dofs import DOFS

DEFAULT_UNITS = {"N": "kN", "rad": "deg", "kg": "t"}
"""Units of the bases that are not read in SI."""
UNIT_FACTORS = {("N", "kN"): 1e-3, ("rad", "deg"): 180.0 / math.pi, ("kg", "t"): 1e-3}
WHOLE_UNITS = {
    "J": ("MJ", 1e-6),
    "W": ("kW", 1e-3),
    "Pa": ("kPa", 1e-3),
    "kg/s": ("t/hour", 3.6),
    "share": ("%", 100.0),
}
"""Units that are not read by their parts. A share is a number of which 1 is the whole."""
OF_NEWTONS = ("J", "W", "Pa")
"""Units that are read in SI where a case writes its forces in N."""
CYCLES_SUFFIX = " of cycles"
"""Ends the unit of a frequency of waves, or of a density over it. Its radians are of a phase, not
of an angle that a case may write in degrees, so it is read as it is."""
UNIT_SYMBOLS = {"tonne": "t", "tonne_force": "tf", "degree": "deg", "metre": "m", "meter": "m"}
BASE_UNITS = ("N", "m", "rad", "kg")
"""What a case can choose a unit for."""
UNITS_ATTRIBUTE = "units_read"
"""The attribute of a result that holds the choice, as JSON."""
FACTOR_PATTERN = re.compile(r"([^\s*^]+)(?:\^(-?\d+))?")


class DisplayUnit(NamedTuple):
    """A unit that people read, and what a number in SI is multiplied by."""

    unit: str
    factor: float


@dataclass(frozen=True)
class Units:
    """The unit that is ``chosen`` for a base, by the base's SI unit: ``{"N": "tonne_force"}``."""

    chosen: Mapping[str, str] = field(default_factory=dict)
    _known: dict[str, DisplayUnit] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    def display_unit(self, unit: str) -> DisplayUnit:
        """In which unit people read what is in an SI ``unit``. A number without unit has none, and
        a unit that is not known stays as it is."""
        if unit in ("", "1"):
            return DisplayUnit("", 1.0)
        if unit.endswith(CYCLES_SUFFIX):
            return DisplayUnit(unit.removesuffix(CYCLES_SUFFIX), 1.0)
        if unit in self._known:
            return self._known[unit]
        if unit in OF_NEWTONS and self.chosen.get("N") == "N":
            return DisplayUnit(unit, 1.0)
        if unit in WHOLE_UNITS:
            return DisplayUnit(*WHOLE_UNITS[unit])
        display = self._unit_of_product(unit)
        self._known[unit] = display
        return display

    def _unit_of_base(self, base: str) -> DisplayUnit:
        unit = self.chosen.get(base, DEFAULT_UNITS.get(base, base))
        return DisplayUnit(_unit_symbol(unit), _factor_from_si(base, unit))

    def _unit_of_product(self, unit: str) -> DisplayUnit:
        numerator, *denominators = unit.split("/")
        names = []
        scale = 1.0
        for sign, group in ((1, numerator), *((-1, factors) for factors in denominators)):
            read = []
            for base, power in _bases_of_product(group):
                name, factor = self._unit_of_base(base)
                read.append(name if power == 1 else f"{name}^{power}")
                scale *= factor ** (sign * power)
            names.append(" ".join(read))
        return DisplayUnit("/".join(names), scale)


DEFAULT = Units()


def chosen_units(written: Iterable[tuple[str, str]]) -> dict[str, str]:
    """Of SI units and the units ``written`` in their place: the one written most often for each of
    `BASE_UNITS`, the first of those that are written equally often."""
    counts = Counter(pair for pair in written if pair[0] in BASE_UNITS)
    chosen: dict[str, str] = {}
    for (base, unit), _ in counts.most_common():
        chosen.setdefault(base, unit)
    return chosen


def as_attribute(chosen: Mapping[str, str]) -> dict[str, str]:
    """The choice as an attribute of a result; none where nothing was chosen."""
    return {UNITS_ATTRIBUTE: json.dumps(dict(chosen))} if chosen else {}


def unit_choice_attribute(attributes: Mapping[Any, Any]) -> dict[str, str]:
    """The choice among the attributes of a result, for a result that is made of it."""
    return (
        {UNITS_ATTRIBUTE: str(attributes[UNITS_ATTRIBUTE])} if UNITS_ATTRIBUTE in attributes else {}
    )


def units_of(attributes: Mapping[Any, Any]) -> Units:
    """The units that a result asks to be read in, by its attributes."""
    text = attributes.get(UNITS_ATTRIBUTE)
    return Units(json.loads(str(text))) if text else DEFAULT


def unit_of_dof(dof: str) -> str:
    """The SI unit of a degree of freedom."""
    return "m" if dof in DOFS[:3] else "rad"


def _bases_of_product(group: str) -> Iterator[tuple[str, int]]:
    """Bases of a product and their powers: "kg m^2" is kg and m with 2."""
    for name, power in FACTOR_PATTERN.findall(group):
        yield name, int(power or 1)


def _unit_symbol(unit: str) -> str:
    return UNIT_SYMBOLS.get(unit, unit)


def _factor_from_si(base: str, unit: str) -> float:
    """What a number in the SI unit ``base`` is multiplied by to be in ``unit``."""
    if unit == base:
        return 1.0
    if (base, unit) in UNIT_FACTORS:
        return UNIT_FACTORS[base, unit]
    from hydrosim.files.units import factor

    return 1.0 / factor(unit, base)
