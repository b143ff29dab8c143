"""The title block of a report: project, client, author, revision, sea."""

from __future__ import annotations

import json
from collections.abc import Iterator

import xarray as xr

from hydrosim.case.criteria import TITLE_BLOCK
from hydrosim.case.tables import plain, seas
from hydrosim.presentation.document import Cell, Node, Sentence, Table
from hydrosim.presentation.units import units_of
from hydrosim.wording.sections import lines_of

LABELS = {
    "project": "Project",
    "client": "Client",
    "document": "Document",
    "revision": "Revision",
    "date": "Date",
    "author": "Author",
    "checked_by": "Checked by",
}


def title_block(result: xr.Dataset) -> Iterator[Node]:
    """Project, client, author and revision as the case gives them; remarks; the seas."""
    block = json.loads(str(result.attrs.get(TITLE_BLOCK, "{}")))
    rows: list[list[Cell]] = [[label, block[key]] for key, label in LABELS.items() if key in block]
    rows += [["Sea", sea] for sea in _seas(result)]
    rows.append(["Computed by", str(result.attrs.get("program", "hydrosim"))])
    yield Table(("", ""), rows)
    if "remarks" in block:
        yield Sentence("{}", [block["remarks"]])


def _seas(result: xr.Dataset) -> list[str]:
    if told := lines_of(result, "seas"):
        return told
    data = plain(str(result.attrs.get("case_resolved", "")))
    return seas(data, units_of(result.attrs)) if data else []
