"""What a run rests on: its case, what was assumed, left out or warned of."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import xarray as xr

from hydrosim.case.tables import case_tables, plain, shorten_path
from hydrosim.presentation.document import Node, Sentence, Table, warnings
from hydrosim.presentation.figures import Code
from hydrosim.scene import Place
from hydrosim.wording.sections import attribute_text, lines_of

ATTRIBUTE_LABELS = {
    "skipped": "Left out",
    "solver_symmetry": "Symmetry",
    "zero_by_symmetry": "Zero by symmetry",
    "wave_ramp": "Waves grow until [s]",
    "seeds": "Seeds of waves",
    "initial_run": "Starts from the run",
    "initial_time": "at its time [s]",
    "program": "Program",
    "versions": "Versions",
    "case_file": "Case file",
}
PATH_ATTRIBUTES = ("initial_run", "case_file", "database")
"""Attributes that are paths."""
OF_BODIES = {
    "radiation": "Radiation of",
    "retardation": "Retardation functions of",
    "waves_meet": "Where waves act on",
    "database": "Database of",
    "database_checksum": "Checksum of the database of",
}


def case_nodes(run: xr.Dataset) -> Iterator[Node]:
    """The case in short, as it was written, and with every default."""
    data = plain(str(run.attrs.get("case_resolved", "")))
    yield from case_tables(data)
    if text := run.attrs.get("case"):
        yield Code("The case as it was written, with its units and remarks", str(text))
    if text := run.attrs.get("case_resolved"):
        yield Code("The case with every default, in SI and radians", str(text))
    if not (data or run.attrs.get("case")):
        yield Sentence("The result does not hold its case. It was made from Python or otherwise.")


def assumption_nodes(run: xr.Dataset) -> Iterator[Node]:
    """Warnings first, then all that the run says of its assumptions."""
    if told := warnings(lines_of(run, "warnings")):
        yield from told
    else:
        yield Sentence("The run holds no warnings.")
    yield assumptions(run)


def assumptions(run: xr.Dataset) -> Table:
    """All that a run, or runs of which each has the same, says of its assumptions."""
    rows = [
        (label, _attribute_words(key, run.attrs[key]))
        for key, label in ATTRIBUTE_LABELS.items()
        if key in run.attrs
    ]
    for start, label in OF_BODIES.items():
        for body in map(str, run.body.values if "body" in run.coords else ()):
            if (key := f"{start}_{body}") in run.attrs:
                rows.append((f"{label} {body}", _attribute_words(start, run.attrs[key])))
    return Table(("assumption", ""), rows)


def _attribute_words(key: str, value: Any) -> str:
    """An attribute; of a file the end of its path, of the place in the waves both words of it."""
    if key == "waves_meet":
        return _place_in_waves(str(value))
    return shorten_path(str(value)) if key in PATH_ATTRIBUTES else attribute_text(value)


def _place_in_waves(stored: str) -> str:
    """Position and heading at which waves act on a body, from their two stored names."""
    try:
        position, heading = map(Place, stored.split())
    except ValueError:  # of another version
        return stored
    return f"at its {position.describe('position')} and its {heading.describe('heading')}"
