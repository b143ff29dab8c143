"""Mooring lines by themselves: at rest, and over offsets of their fairleads."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from hydrosim.forces.line.shape import REASONS
from hydrosim.presentation.document import (
    Cell,
    Document,
    Node,
    Outcome,
    Sentence,
    Table,
    Value,
    Verdict,
    warnings,
)
from hydrosim.presentation.units import DEFAULT, Units
from hydrosim.studies.line import LineResponse, StillLine, angle_at_fairlead

AT_REST_COLUMNS = (
    *("line", "to", "tension", "horizontal pull", "down at fairlead", "angle below level"),
    *("anchor tension", "grounded", "length"),
)
FRICTION_NOTE = (
    "With friction on the seabed the pull has no potential. It depends on the place alone here, as"
    " if the fairlead had come there from slack."
)


def line_document(
    title: str,
    lines: Sequence[StillLine],
    responses: Sequence[LineResponse],
    units: Units = DEFAULT,
    left_out: Sequence[str] = (),
) -> Document:
    """The lines at rest, and the ``responses`` of one of them; before them what is ``left_out`` of
    their file."""
    nodes: list[Node] = [*warnings(left_out), *_unsolved_lines(lines), _at_rest(lines)]
    if any(line.friction > 0.0 for line in lines):
        nodes.append(Sentence(FRICTION_NOTE, detail=True))
    for found in responses:
        nodes += [_over_offsets(found), *_gaps(found)]
    return Document(title, nodes, units=units)


def _unsolved_lines(lines: Sequence[StillLine]) -> Iterator[Verdict]:
    for line in lines:
        pull = line.end_forces()
        if not pull.converged:
            yield Verdict(Outcome.BAD, f"line {line.name} has no shape: {REASONS[pull.reason]}")


def _at_rest(lines: Sequence[StillLine]) -> Table:
    return Table(AT_REST_COLUMNS, [_row_at_rest(line) for line in lines], "At rest")


def _row_at_rest(line: StillLine) -> list[Cell]:
    pull = line.end_forces()
    grounded = line.grounded_length(pull)
    return [
        line.name,
        Value(line.heading, "rad"),
        Value(float(np.hypot(pull.H, pull.V)), "N"),
        Value(pull.H, "N"),
        Value(pull.V, "N"),
        Value(angle_at_fairlead(pull), "rad"),
        Value(float(np.hypot(pull.anchor_H, pull.anchor_V)), "N"),
        Value(grounded, "m"),
        Value(line.length, "m"),
    ]


def _over_offsets(found: LineResponse) -> Table:
    way = "upward" if found.up else "away from the anchor"
    head = (
        *("offset", "tension", "horizontal pull", "down at fairlead", "anchor tension"),
        *("stiffness", "grounded"),
    )
    columns = (
        *(found.tension, found.horizontal, found.vertical, found.anchor),
        *(found.stiffness, found.grounded),
    )
    units = ("N", "N", "N", "N", "N/m", "m")
    rows: list[list[Cell]] = [
        [
            Value(float(found.offsets[i]), "m"),
            *(Value(float(c[i]), unit) for c, unit in zip(columns, units, strict=True)),
        ]
        for i in range(found.offsets.size)
    ]
    return Table(head, rows, f"Offset of the fairlead {way}")


def _gaps(found: LineResponse) -> Iterator[Node]:
    for reason in found.reasons:
        yield Sentence(f"A dash is where the line has no shape: {reason}.")
