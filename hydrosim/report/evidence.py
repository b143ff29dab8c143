"""Section of a report: the lines of evidence about what the scene of a run uses."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence

import xarray as xr

from hydrosim.documents.digits import digits_of
from hydrosim.evidence import Feature, Line, features_of, lines_about
from hydrosim.presentation.document import Cell, List, Node, Sentence, Table
from hydrosim.scene import Scene

EVIDENCE_COLUMNS = ("claim", "against", "kind", "error", "limit")
EVIDENCE_NOTE = (
    "These comparisons are about parts of this scene. They were made when the program was tested,"
    " with scenes of their own. An error is the largest that a test found, a limit the bound that"
    " it asserts. Both are relative unless the claim names a unit."
)
UNKNOWN_CASE_NOTE = (
    "The result does not hold its case, or it cannot be read again, so the evidence for what it"
    " uses cannot be named."
)


def evidence_nodes(run: xr.Dataset, scene: Scene | None) -> Iterator[Node]:
    """Lines of evidence about the features of the ``scene`` of a run, and features without one."""
    if scene is None:
        yield Sentence(UNKNOWN_CASE_NOTE)
        return
    used = features_of(scene, {str(name): value for name, value in run.attrs.items()})
    lines = lines_about(used)
    if lines:
        yield Sentence(EVIDENCE_NOTE)
        yield Table(EVIDENCE_COLUMNS, [_row(line) for line in lines])
    if bare := without_line(used, lines):
        yield Sentence("No line of evidence is about these parts of the scene by themselves:")
        yield List(bare)


def without_line(used: Collection[Feature], lines: Sequence[Line]) -> list[str]:
    """Features that are ``used`` and that none of the ``lines`` is about."""
    covered = {feature for line in lines for feature in line.features}
    return [feature.value for feature in Feature if feature in used and feature not in covered]


def _row(line: Line) -> list[Cell]:
    figures = [digits_of(line.figure, 2), digits_of(line.limit, 3)]
    return [line.claim, line.against, line.kind.value, *figures]
