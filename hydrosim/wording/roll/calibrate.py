"""A fit of decay tests: damping with intervals, natural period, and keys for a case."""

from __future__ import annotations

from collections.abc import Iterator

from hydrosim.decay.fit import DecayFit, Interval
from hydrosim.presentation.document import (
    Cell,
    Document,
    Node,
    Outcome,
    Sentence,
    Table,
    Value,
    Verdict,
)

TERMS = (("p1", "1/s"), ("p2", "1/rad"), ("p3", "s/rad^2"))
SHARES = (0.25, 0.5, 0.75, 1.0)
"""Of the largest roll: amplitudes in the table."""
DIGITS = 5
KEYS = ("s^-1", "rad^-1", "s/rad^2")
"""Units in a case file."""


def calibration_document(found: DecayFit) -> Document:
    """Damping of the decays, how well the records tell it, and where the equation does not fit."""
    nodes = [*_doubts(found), _terms(found), _untold(found), _ratios(found), _records(found)]
    return Document("Decay of roll", nodes)


def keys_of(found: DecayFit, body: str) -> list[str]:
    """Lines of a force element with the fitted damping, as in a case file."""
    values = zip((name for name, _ in TERMS), found.damping, KEYS, strict=True)
    return [
        "forces:",
        "  roll_damping:",
        "    type: viscous_roll",
        f"    body: {body}",
        *(f"    {name}: {value:.6g} {unit}" for name, value, unit in values),
        f"    period: {found.period.value:.6g} s",
    ]


def _doubts(found: DecayFit) -> Iterator[Node]:
    return (Verdict(Outcome.WARNING, "{}", [text]) for text in found.doubts)


def _terms(found: DecayFit) -> Table:
    rows = [
        _row(f"{name} [{unit}]", found.terms.interval(k), found.damping[k])
        for k, (name, unit) in enumerate(TERMS)
    ]
    rows.append(_row("natural period [s]", found.period, found.period.value))
    if found.restoring:
        rows.append(_row("cubic restoring [1/rad^2]", found.restoring, found.restoring.value))
    return Table(("", "fitted", "90 % from", "to", "for use"), rows, "Fit")


def _row(name: str, interval: Interval, used: float) -> list[Cell]:
    return [name, *(f"{x:.{DIGITS}g}" for x in (*interval, used))]


def _untold(found: DecayFit) -> Node:
    """Terms that the records do not tell from zero."""
    names = [name for k, (name, _) in enumerate(TERMS) if found.terms.interval(k).holds_zero]
    if not names:
        return Sentence("The records tell p1, p2 and p3 from zero.", [])
    text = (
        "The records do not tell {} from zero. The damping of all terms together is known better:"
        " see the ratios. No term for use is negative."
    )
    return Sentence(text, [", ".join(names)])


def _ratios(found: DecayFit) -> Table:
    rows: list[list[Cell]] = []
    for share in SHARES:
        amplitude = share * found.size
        ratio = found.terms.damping_ratio(amplitude)
        cells: list[Cell] = [Value(x, "share", 3) for x in ratio]
        rows.append([Value(amplitude, "rad", 3), *cells])
    head = ("amplitude", "damping ratio", "90 % from", "to")
    return Table(head, rows, "Equivalent linear damping, of critical")


def _records(found: DecayFit) -> Table:
    rows: list[list[Cell]] = []
    for decay, (deviation, noise) in zip(found.decays, found.noise, strict=True):
        kind = f"correlated, order {noise.size}" if noise.size else "white"
        begin, end = decay.time[0], decay.time[-1]
        size = Value(decay.size, "rad", 3)
        residual = Value(deviation, "rad", 3)
        rows.append([decay.called, Value(begin, "s"), Value(end, "s"), size, residual, kind])
    head = ("record", "from", "to", "largest roll", "std of residuals", "noise")
    return Table(head, rows, "Records")
