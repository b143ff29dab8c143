"""What a report says of its origin, and the criteria that a run is held against."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated, Literal

from pydantic import Field, StrictStr

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

    project: Annotated[StrictStr, Field(description="Name or number of the project.")] = ""
    client: Annotated[StrictStr, Field(description="Who the report is for.")] = ""
    author: Annotated[StrictStr, Field(description="Who made the analysis.")] = ""
    checked_by: Annotated[StrictStr, Field(description="Who checked the analysis.")] = ""
    document: Annotated[StrictStr, Field(description="Number of the document.")] = ""
    revision: Annotated[StrictStr, Field(description='Revision of the document, such as "B".')] = ""
    date: Annotated[StrictStr, Field(description='Date of issue, such as "2026-11-25".')] = ""
    remarks: Annotated[StrictStr, Field(description="A few sentences for the first page.")] = ""


class RunCriterion(of.Strict):
    """A limit of a statistic of a channel, and where the limit comes from."""

    channel: Annotated[
        StrictStr, Field(description="Channel of the run, such as position.barge.surge.")
    ]
    statistic: Annotated[
        STATISTIC_NAMES, Field(description="Statistic that is held against the limit.")
    ]
    limit: Annotated[
        Annotated[Scale, AnyQuantity("limit", "1 m")],
        Field(
            description="Largest value that is accepted. For the statistic smallest it is the"
            " smallest value that is accepted."
        ),
    ]
    source: Annotated[
        StrictStr, Field(description="Where the limit comes from: a document and its clause.")
    ] = ""
    phase: Annotated[
        PHASE_NAMES | None, Field(description="Phase of the contacts that it is for.")
    ] = None


def as_attributes(report: Report, criteria: Mapping[str, RunCriterion]) -> dict[str, str]:
    """What the results of a case keep of both; nothing where the case says nothing."""
    block = {key: text for key, text in report if text}
    asked = [_plain(name, each) for name, each in criteria.items()]
    found = {TITLE_BLOCK: block, CRITERIA: asked}
    return {key: json.dumps(value) for key, value in found.items() if value}


def _plain(name: str, of: RunCriterion) -> dict[str, object]:
    known = {"channel": of.channel, "statistic": of.statistic, "phase": of.phase}
    return {"name": name, **known, "limit": of.limit.value, "source": of.source}
