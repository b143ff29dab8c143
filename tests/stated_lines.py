"""Lines of evidence that a test notes, against those that the program states."""

from dataclasses import replace

from hydrosim.report.evidence import EvidenceLine, known_lines

WRITING = "evidence"
"""Name of the plugin that writes the page, and of what it reads from reports."""
ROUNDING = 1e-10
"""Errors that differ from one machine to another."""
SAME = 1.25
"""Ratio of errors that are taken for equal."""


def unlike(line: EvidenceLine) -> str:
    """How the known line differs from what a test noted; "" if it does not."""
    found = [x for x in known_lines() if (x.claim, x.against) == (line.claim, line.against)]
    if not found:
        return f"{line.claim}: no such line. Write it by python -m benchmarks --keep evidence."
    stated = found[0]
    same = replace(line, figure=stated.figure, others=stated.others, commit=stated.commit)
    if same != stated:
        return f"{line.claim}: the line says {stated}, the test {same}"
    if line.figure > max(SAME * stated.figure, ROUNDING):
        return f"{line.claim}: the line says {stated.figure:g}, the test {line.figure:g}"
    return ""
