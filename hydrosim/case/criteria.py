"""What a report says of its origin, and the criteria that a run is held against."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated, Literal, Self

from pydantic import StrictStr, model_validator

from hydrosim.files import quantities as of
from hydrosim.files.units import AnyQuantity, Scale, problem

CRITERIA = "criteria_asked"
TITLE_BLOCK = "title_block"
"""Attributes of a result, as JSON."""
STATISTIC_NAMES = Literal[
    "end",
    "end_absolute",
    "change",
    "change_absolute",
    "mean",
    "std",
    "smallest",
    "largest",
    "largest_absolute",
]
CONTACT_RESULTS = Literal[
    "closings",
    "closing_speed",
    "largest_contact_force",
    "recontacts",
    "recontact_speed",
    "recontact_force",
    "end_clearance",
]
PHASE_NAMES = Literal["moored", "initial contact", "compressed", "stuck"]


class Report(of.SchemaModel):
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


class RunCriterion(of.SchemaModel):
    """A limit of a statistic of a channel, or of a result of contacts, and where it comes from."""

    channel: StrictStr | None = None
    """Channel of the run, with a statistic. Example: position.barge.surge."""
    statistic: STATISTIC_NAMES | None = None
    """Statistic of the channel that is held against the limit. Crawl is change_absolute of a
    position; end_absolute counts from the place at rest."""
    result: CONTACT_RESULTS | None = None
    """Result of contacts, in place of channel and statistic. Example: recontact_force."""
    group: StrictStr | None = None
    """Group of contacts that the result is of. Without it the only one. Example: legs."""
    limit: Annotated[Scale, AnyQuantity("limit", "1 m")]
    """Largest value that is accepted. For the statistic smallest it is the smallest value that is
    accepted."""
    source: StrictStr = ""
    """Where the limit comes from: a document and its clause. Example: Fender data sheet 7."""
    phase: PHASE_NAMES | None = None
    """Phase of the contacts that the statistic is for."""

    @model_validator(mode="after")
    def _check_what(self) -> Self:
        of_channel = self.keys_with_value("channel", "statistic", "phase")
        of_contacts = self.keys_with_value("result", "group")
        if bool(of_channel) == bool(of_contacts) or (of_contacts and self.result is None):
            given_keys = " and ".join([*of_channel, *of_contacts]) or "no channel"
            raise problem(given_keys, "either channel and statistic, or result")
        if of_channel and (self.channel is None or self.statistic is None):
            raise problem(" and ".join(of_channel), "channel and statistic")
        return self


def as_attributes(report: Report, criteria: Mapping[str, RunCriterion]) -> dict[str, str]:
    """What the results of a case keep of both; nothing where the case says nothing."""
    block = {key: text for key, text in report if text}
    asked = [_criterion_entries(name, criterion) for name, criterion in criteria.items()]
    attributes = {TITLE_BLOCK: block, CRITERIA: asked}
    return {key: json.dumps(value) for key, value in attributes.items() if value}


def _criterion_entries(name: str, of: RunCriterion) -> dict[str, object]:
    names = ("channel", "statistic", "phase", "result", "group")
    values = {key: getattr(of, key) for key in names}
    written = {"limit": of.limit.value, "unit": of.limit.unit or "", "text": of.limit.text}
    return {"name": name, **values, **written, "source": of.source}
