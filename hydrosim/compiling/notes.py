"""`Notes`: messages and data from compiling a scene."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from math import nan
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from hydrosim.compiling.memory_errors import MemoryErrors


@dataclass(frozen=True)
class Notes:
    """Messages and data from compiling: ``skipped`` parts; ``warnings``; ``records`` that are
    interpolated; the ``seas``, a line for each wave train; the ``meetings`` of bodies with waves
    and current; figures of the ``streams``, wind and current. ``symmetry`` is a text on the
    use of symmetry, and ``zero`` has the names of coordinates that are zero by it. ``memory`` holds
    the errors of the radiation memory. ``radiation_error`` is the largest change of motions by
    them, NaN if unknown. ``method`` is the chosen method, and the reason. ``drag`` is about
    drag and friction of lines.
    """

    skipped: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    records: tuple[str, ...] = ()
    seas: tuple[str, ...] = ()
    meetings: tuple[str, ...] = ()
    streams: tuple[str, ...] = ()
    symmetry: str = ""
    zero: tuple[str, ...] = ()
    memory: tuple[str, ...] = ()
    radiation_error: float = nan
    method: str = ""
    drag: tuple[str, ...] = ()

    def of_memory(self, errors: Iterable[MemoryErrors]) -> Notes:
        """Notes with messages on the ``errors`` of the radiation memory."""
        errors = tuple(errors)
        largest = max((each.largest for each in errors), default=nan)
        found = replace(self, memory=tuple(map(str, errors)), radiation_error=largest)
        return found.with_warnings(text for each in errors for text in each.warnings())

    def with_warnings(self, more: Iterable[str]) -> Notes:
        """Notes with ``more`` warnings."""
        return replace(self, warnings=(*self.warnings, *more))
