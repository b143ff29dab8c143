"""What a report says of its origin, and the criteria that a run is held against."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import StrictStr

from hydrosim.documents import quantities as of
from hydrosim.documents.units import AnyQuantity, Scale

CRITERIA = "criteria_asked"
TITLE_BLOCK = "title_block"
"""Attributes of a result, as JSON."""
STATISTIC_NAMES = Literal[
    "end", "end_absolute", "change", "mean", "std", "smallest", "largest", "largest_absolute"
]
PHASE_NAMES = Literal["moored", "initial contact", "compressed", "stuck"]


class Report(of.Strict):
    """The title block of reports. All keys are texts and may be left out."""

    project: StrictStr = ""
    """Name or number of the project. Example: P1234."""
    client: StrictStr = ""
    """Who the report is for. Example: Harbour Authority."""
    author: StrictStr = ""
    """Who made the analysis. Example: J. Doe."""
    checked_by: StrictStr = ""
    """Who checked the analysis. Example: R. Roe."""
    document: StrictStr = ""
    """Number of the document. Example: P1234-R01."""
    revision: StrictStr = ""
    """Revision of the document. Example: B."""
    date: StrictStr = ""
    """Date of issue. Example: '2026-11-25'."""
    remarks: StrictStr = ""
    """A few sentences for the first page. Example: For discussion."""


class RunCriterion(of.Strict):
    """A limit of a statistic of a channel, and where the limit comes from."""

    channel: StrictStr
    """Channel of the run. Example: position.barge.surge."""
    statistic: STATISTIC_NAMES
    """Statistic that is held against the limit."""
    limit: Annotated[Scale, AnyQuantity("limit", "1 m")]
    """Largest value that is accepted. For the statistic smallest it is the smallest value that is
    accepted."""
    source: StrictStr = ""
    """Where the limit comes from: a document and its clause. Example: Fender data sheet 7."""
    phase: PHASE_NAMES | None = None
    """Phase of the contacts that it is for."""


def as_attributes(report: Report, criteria: Mapping[str, RunCriterion]) -> dict[str, str]:
    """What the results of a case keep of both; nothing where the case says nothing."""
    block = {key: text for key, text in report if text}
    asked = [_plain(name, each) for name, each in criteria.items()]
    found = {TITLE_BLOCK: block, CRITERIA: asked}
    return {key: json.dumps(value) for key, value in found.items() if value}


def _plain(name: str, of: RunCriterion) -> dict[str, object]:
    known = {"channel": of.channel, "statistic": of.statistic, "phase": of.phase}
    return {"name": name, **known, "limit": of.limit.value, "source": of.source}
