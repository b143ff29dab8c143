"""A fit of decay tests: damping with intervals, natural period, and keys for a case."""

from __future__ import annotations

import numpy as np

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
MAX_RATIO_ROWS = 5
"""Rows of damping ratios, from the smallest to the largest recorded roll."""
COEFFICIENT_DIGITS = 5
CASE_UNITS = ("s^-1", "rad^-1", "s/rad^2")
"""Units in a case file."""


def calibration_document(fit: DecayFit) -> Document:
    """Damping of the decays, how well the records tell it, and where the equation does not fit."""
    doubts = [Verdict(Outcome.WARNING, "{}", [text]) for text in fit.doubts]
    notes = [Sentence("{}.", [note]) for decay in fit.decays for note in decay.notes]
    nodes = [*doubts, _terms(fit), _undetermined_terms(fit), _ratios(fit), _records(fit), *notes]
    return Document("Decay of roll", nodes)


def keys_of(fit: DecayFit, body: str) -> list[str]:
    """Lines of a force element with the fitted damping, as in a case file."""
    values = zip((name for name, _ in TERMS), fit.damping, CASE_UNITS, strict=True)
    return [
        "forces:",
        "  roll_damping:",
        "    type: viscous_roll",
        f"    body: {body}",
        *(f"    {name}: {value:.6g} {unit}" for name, value, unit in values),
        f"    period: {fit.period.value:.6g} s",
    ]


def _terms(fit: DecayFit) -> Table:
    rows = [
        _row(f"{name} [{unit}]", fit.terms.interval(k), fit.damping[k])
        for k, (name, unit) in enumerate(TERMS)
    ]
    rows.append(_row("natural period [s]", fit.period, fit.period.value))
    rows.append(_row("cubic restoring [1/rad^2]", fit.restoring, fit.restoring.value))
    return Table(("", "fitted", "90 % from", "to", "for use"), rows, "Fit")


def _row(name: str, interval: Interval, used: float) -> list[Cell]:
    return [name, *(f"{x:.{COEFFICIENT_DIGITS}g}" for x in (*interval, used))]


def _undetermined_terms(fit: DecayFit) -> Node:
    """Terms that the records do not tell from zero."""
    names = [name for k, (name, _) in enumerate(TERMS) if fit.terms.interval(k).holds_zero]
    if not names:
        return Sentence("The records tell p1, p2 and p3 from zero.", [])
    text = (
        "The records do not tell {} from zero. The damping of all terms together is known better:"
        " see the ratios. No term for use is negative."
    )
    return Sentence(text, [", ".join(names)])


def _ratios(fit: DecayFit) -> Table:
    rows: list[list[Cell]] = []
    for amplitude in np.linspace(*fit.amplitudes, MAX_RATIO_ROWS):
        ratio = fit.terms.damping_ratio(amplitude)
        used = fit.used_ratio(amplitude)
        cells: list[Cell] = [Value(x, "share", 3) for x in (*ratio, used)]
        rows.append([Value(amplitude, "rad", 3), *cells])
    head = ("amplitude", "damping ratio", "90 % from", "to", "for use")
    return Table(head, rows, "Equivalent linear damping, of critical")


def _records(fit: DecayFit) -> Table:
    rows: list[list[Cell]] = []
    for decay, deviation in zip(fit.decays, fit.deviations, strict=True):
        begin, end = decay.time[0], decay.time[-1]
        size = Value(decay.size, "rad", 3)
        residual = Value(deviation, "rad", 3)
        rows.append([decay.called, Value(begin, "s"), Value(end, "s"), size, residual])
    head = ("record", "from", "to", "largest roll", "std of residuals")
    return Table(head, rows, "Records")
