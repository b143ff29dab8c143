"""Summaries of results, sections of a document, title block, case and assumptions."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any, TypeVar

from hydrosim.case.criteria import TITLE_BLOCK
from hydrosim.case.tables import case_tables, plain, seas, shorten_path
from hydrosim.files import document_nodes
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.document_layout import digits_of
from hydrosim.results.dataset import ResultKind, kind_of
from hydrosim.scene import Place

if TYPE_CHECKING:
    import xarray as xr

Result = TypeVar("Result")
SectionBuilder = Callable[[Result], document_nodes.Nodes]
Sections = Mapping[str, tuple[str, SectionBuilder[Result]]]
"""Sections by name: the heading, and what gives the nodes below it."""
MAX_TABLE_ROWS = 300
"""Rows of a table, and remarks of a list."""


SUMMARIES: dict[str, str] = {
    ResultKind.SET: "study:study_tables",
    ResultKind.STUDY: "study:study_tables",
    ResultKind.OPERABILITY: "limits:limits_tables",
    ResultKind.COMPARISON: "comparison:comparison_tables",
    ResultKind.SET_COMPARISON: "comparison:studies_tables",
    ResultKind.ANALYSIS: "analysis:linear_document",
}
"""Functions of this folder that make the summaries of results besides runs, by kind."""


def summary_of(dataset: xr.Dataset) -> Document:
    """The text that a command prints of its result: a run, many runs, limits of operation, a
    comparison, or a linear analysis."""
    return make_document(SUMMARIES.get(kind_of(dataset), "run:run_document"), dataset)


def make_document(function: str, dataset: xr.Dataset) -> Document:
    """The document of a result by a ``function`` "module:name" of this folder. Only the module of
    its kind is loaded."""
    document: Document = resolve_name(f"{__package__}.{function}")(dataset)
    return document


def build_sections(parts: Sections[Result], result: Result) -> list[document_nodes.Node]:
    """The headings and nodes of those parts of a result that have anything to say."""
    nodes: list[document_nodes.Node] = []
    for name, (title, part) in parts.items():
        if below := list(_build_section(part, result)):
            nodes += [document_nodes.Heading(title, name), *below]
    return nodes


def title_of(result: xr.Dataset) -> str:
    """The title of a result, or that it has none."""
    return str(result.attrs.get("title", "")).strip() or "Result without a title"


def lines_of(result: xr.Dataset, attribute: str) -> list[str]:
    """The lines of an attribute; none where it is absent."""
    return str(result.attrs.get(attribute, "")).splitlines()


def case_data(result: xr.Dataset) -> dict[str, Any]:
    """The case of a result with every default; empty if it holds none."""
    return plain(str(result.attrs.get("case_resolved", "")))


def attribute_text(value: Any) -> str:
    """An attribute of a result: lines as sentences, numbers as numbers."""
    if isinstance(value, str):
        return "; ".join(value.splitlines())
    try:
        return digits_of(float(value), 6)
    except (TypeError, ValueError):
        return str(value)


def _build_section(part: SectionBuilder[Result], result: Result) -> document_nodes.Nodes:
    """The nodes of a part. A result of another version or origin gives those that can be made."""
    try:
        yield from part(result)
    except (KeyError, ValueError, AttributeError, IndexError) as error:
        yield document_nodes.Verdict(
            document_nodes.Outcome.BAD,
            "This result lacks what this version of hydrosim writes, so the rest of this part is"
            " missing ({}). Run the case again.",
            [f"{type(error).__name__}: {error}"],
        )


def table_of(
    head: str, columns: Mapping[str, tuple[Any, ...]], title: str = ""
) -> document_nodes.Table:
    """Table with a row for each label of the one dimension of the ``columns``: by heading, an array
    with the unit and the digits that its values are shown with."""
    (first, *_), *_ = columns.values()
    rows: list[document_nodes.Row] = [
        [
            str(label),
            *(document_nodes.Value(float(of[k]), *shown) for of, *shown in columns.values()),
        ]
        for k, label in enumerate(first[first.dims[0]].values)
    ]
    return document_nodes.Table((head, *columns), rows, title)


# The title block of a report: project, client, author, revision, sea.

LABELS = {
    "project": "Project",
    "client": "Client",
    "document": "Document",
    "revision": "Revision",
    "date": "Date",
    "author": "Author",
    "checked_by": "Checked by",
}


def title_block(result: xr.Dataset, case: Mapping[str, Any]) -> document_nodes.Nodes:
    """Project, client, author and revision as the case gives them; remarks; the seas."""
    block = json.loads(str(result.attrs.get(TITLE_BLOCK, "{}")))
    rows: list[document_nodes.Row] = [
        [label, block[key]] for key, label in LABELS.items() if key in block
    ]
    rows += [["Sea", sea] for sea in _sea_texts(result, case)]
    rows.append(["Computed by", str(result.attrs.get("program", "hydrosim"))])
    yield document_nodes.Table(("", ""), rows)
    if "remarks" in block:
        yield document_nodes.Sentence("{}", [block["remarks"]])


def _sea_texts(result: xr.Dataset, case: Mapping[str, Any]) -> list[str]:
    if told := lines_of(result, "seas"):
        return told
    return seas(case, units_of(result.attrs)) if case else []


# Basis of a run: its case, what was assumed, left out or warned of.

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


def case_nodes(run: xr.Dataset, case: Mapping[str, Any]) -> document_nodes.Nodes:
    """The case in short, as it was written, and with every default."""
    yield from case_tables(case)
    if text := run.attrs.get("case"):
        yield document_nodes.Code(
            "The case as it was written, with its units and remarks", str(text)
        )
    if text := run.attrs.get("case_resolved"):
        yield document_nodes.Code("The case with every default, in SI and radians", str(text))
    if not (case or run.attrs.get("case")):
        yield document_nodes.Sentence(
            "The result does not hold its case. It was made from Python or otherwise."
        )


def assumption_nodes(run: xr.Dataset) -> document_nodes.Nodes:
    """Warnings first, then all that the run says of its assumptions."""
    if told := document_nodes.warnings(lines_of(run, "warnings")):
        yield from told
    else:
        yield document_nodes.Sentence("The run holds no warnings.")
    yield assumptions(run)


def assumptions(run: xr.Dataset) -> document_nodes.Table:
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
    return document_nodes.Table(("assumption", ""), rows)


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
