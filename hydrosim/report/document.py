"""`report_of`: the document of a result, whatever kind of result it is."""

from __future__ import annotations

from pathlib import Path

from hydrosim.report.blocks import Document
from hydrosim.report.run import run_document
from hydrosim.results.output import read


def report_of(path: Path) -> Document:
    """What there is to show of the result in a file; InputError where it is none."""
    return run_document(read(path))
