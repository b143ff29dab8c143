"""`Notes`: what compiling a scene found out."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import nan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hydrosim.compiling.memory_errors import MemoryErrors


@dataclass(frozen=True)
class Notes:
    """What compiling found out: ``skipped`` parts, ``warnings``, ``records`` that are interpolated;
    where waves and current meet the bodies (``meetings``); what became of ``symmetry`` in words,
    and the names of the coordinates that are ``zero`` by it; what the ``memory`` of radiation
    leaves out; the ``radiation_error``, the largest change of motions that it makes, NaN if none is
    known; the ``method`` that was chosen, and why.
    """

    skipped: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    records: tuple[str, ...] = ()
    meetings: tuple[str, ...] = ()
    symmetry: str = ""
    zero: tuple[str, ...] = ()
    memory: tuple[str, ...] = ()
    radiation_error: float = nan
    method: str = ""

    def of_memory(self, errors: Iterable[MemoryErrors]) -> Notes:
        """The notes with what there is to say of ``errors`` of the memory of radiation."""
        errors = tuple(errors)
        largest = max((each.largest for each in errors), default=nan)
        found = replace(self, memory=tuple(map(str, errors)), radiation_error=largest)
        return found.warned(text for each in errors for text in each.warnings())

    def warned(self, more: Iterable[str]) -> Notes:
        """The notes with ``more`` warnings."""
        return replace(self, warnings=(*self.warnings, *more))
