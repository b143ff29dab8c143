"""The report of a comparison of two sets of runs: which numbers differ by more than chance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import xarray as xr

from hydrosim.presentation.document import (
    Between,
    Cell,
    Document,
    Node,
    Outcome,
    Sentence,
    Table,
    Value,
    Verdict,
)
from hydrosim.presentation.figures import Curves, PlottedCurve
from hydrosim.presentation.units import units_of
from hydrosim.wording.comparison import files, names_compared
from hydrosim.wording.sections import MAX_TABLE_ROWS, Sections, build_sections

STUDY_COMPARISON_VARIABLES = ("ours", "theirs", "difference", "low", "high", "chance", "differs")
MAX_PICTURES = 12


def is_of_studies(found: xr.Dataset) -> bool:
    """Whether a dataset is what `hydrosim compare` writes of two files of many runs."""
    return all(name in found for name in STUDY_COMPARISON_VARIABLES)


def studies_document(found: xr.Dataset) -> Document:
    """The report of a comparison of two sets of runs."""
    return Document(
        names_compared(found),
        build_sections(STUDY_COMPARISON_SECTIONS, found),
        _run_counts(found),
        units_of(found.attrs),
    )


def studies_tables(found: xr.Dataset) -> Document:
    """What differs and what may be chance, without pictures."""
    others = (replace(node, detail=True) for node in _other_channels(found))
    nodes = [*_outcome(found), *others]
    return Document(names_compared(found), nodes, _run_counts(found), units_of(found.attrs))


def _run_counts(found: xr.Dataset) -> str:
    """How many runs were compared, and how."""
    counts = f"{found.sizes['run']} and {found.sizes['other_run']} runs"
    return f"{counts}: {found.attrs['compared']}"


def _outcome(found: xr.Dataset) -> Iterator[Node]:
    yield Table(("", "file"), list(files(found, "theirs")))
    differing, equal = _differing_channels(found), _is_equal(found)
    all_, level = found.sizes["channel"], float(found.attrs["level"])
    yield Sentence(
        f"{differing.sizes['channel']} of {all_} channels differ by more than chance;"
        f" {int(equal.sum())} are equal in all runs, and differences of the other"
        f" {all_ - differing.sizes['channel'] - int(equal.sum())} may be chance. Were there no"
        f" difference at all, one or more would be named in {level:.0%} of such comparisons."
    )
    if found.attrs.get("durations"):
        yield Verdict(
            Outcome.WARNING,
            "The durations differ, so extremes, sums and places at the end differ by that alone.",
        )
    if codes := str(found.attrs.get("codes_apart", "")).split():
        yield Verdict(
            Outcome.WARNING, "Codes differ too. They are not tested: {}.", [", ".join(codes)]
        )
    if differing.sizes["channel"]:
        yield Sentence("What differs, the most certain first:")
        yield _table(differing)


def _pictures(found: xr.Dataset) -> Iterator[Node]:
    differing, paired = _differing_channels(found), bool(found.attrs.get("paired"))
    if not differing.sizes["channel"]:
        return
    order = "theirs rise; one above the other are runs of the same seed" if paired else "each rise"
    yield Sentence(
        f"Values in all runs of the channels that differ most certainly, {MAX_PICTURES} at most:"
        f" {order}. Of channels that are alike, as by symmetry, the first is drawn."
    )
    alike = {one.theirs.values.tobytes(): one for one in reversed(list(_rows(differing)))}
    for one in list(reversed(alike.values()))[:MAX_PICTURES]:
        yield _picture(one, paired)


def _picture(one: xr.Dataset, paired: bool) -> Curves:
    unit = str(one.units.values)
    ours, theirs = (one[name].values for name in ("ours", "theirs"))
    order = np.argsort(theirs)
    sets = {"ours": ours[order] if paired else np.sort(ours), "theirs": theirs[order]}
    curves = {name: _curve(values) for name, values in sets.items()}
    label = "share of the runs, in this order"
    return Curves(str(one.channel.values), label, "share", "value", unit, curves)


def _other_channels(found: xr.Dataset) -> Iterator[Sentence | Table]:
    rest = found.isel(channel=np.flatnonzero((found.differs == 0) & ~_is_equal(found)))
    rest = rest.isel(channel=np.argsort(rest.chance.values))
    if rest.sizes["channel"]:
        yield _table(rest.isel(channel=slice(MAX_TABLE_ROWS)))
    if names := [str(name) for name in found.channel.values[_is_equal(found)]]:
        yield Sentence(f"Equal in all runs: {', '.join(names)}.")


def _test_assumptions(found: xr.Dataset) -> Iterator[Node]:
    paired = bool(found.attrs.get("paired"))
    test = (
        "Runs of the same seed and parameters are pairs; their differences are tested by"
        " Student's t."
        if paired
        else "The two sets have no seeds in common, or not each seed once; they are independent,"
        " and their means are tested by Welch's t."
    )
    interval = float(found.attrs["interval_probability"])
    yield Sentence(
        f"{test} Intervals hold the mean difference of very many runs by {interval:.0%}."
    )
    yield Sentence(
        f"A channel differs if it does at {float(found.attrs['level']):.0%} for all channels"
        " together, by Holm's procedure (1979). Both tests take values that are about normal over"
        " runs. A difference that is certain may be too small to matter, and one that may be chance"
        " may be large: more seeds tell. What step the solver has is not assessed."
    )


def _differing_channels(found: xr.Dataset) -> xr.Dataset:
    own = found.isel(channel=np.flatnonzero(found.differs.values))
    return own.isel(channel=np.argsort(own.chance.values, kind="stable"))


def _is_equal(found: xr.Dataset) -> np.ndarray:
    """Which channels (n,) are the same in all runs."""
    ends = np.stack([found[name].values for name in ("difference", "low", "high")])
    return np.asarray((ends == 0.0).all(axis=0))


def _rows(found: xr.Dataset) -> Iterator[xr.Dataset]:
    return (found.isel(channel=k) for k in range(found.sizes["channel"]))


def _table(rows: xr.Dataset) -> Table:
    interval = f"{float(rows.attrs['interval_probability']):.0%} interval"
    head = ("channel", "ours", "theirs", "ours less theirs", "of theirs", interval, "by chance")
    return Table(head, [_row(each) for each in _rows(rows)])


def _row(one: xr.Dataset) -> list[Cell]:
    unit = str(one.units.values)
    mean = [Value(float(one[name]), unit) for name in ("ours_mean", "theirs_mean")]
    interval = Between(float(one.low), float(one.high), unit)
    apart, chance = Value(float(one.difference), unit), Value(float(one.chance), "", 2)
    theirs = abs(float(one.theirs_mean)) or np.nan
    share = Value(float(one.difference) / theirs, "share", 2)
    return [str(one.channel.values), *mean, apart, share, interval, chance]


def _curve(values: np.ndarray) -> PlottedCurve:
    none = np.full(values.size, np.nan)
    share = (np.arange(values.size) + 0.5) / max(values.size, 1)
    return PlottedCurve(share, values, none, none)


STUDY_COMPARISON_SECTIONS: Sections[xr.Dataset] = {
    "outcome": ("What differs", _outcome),
    "pictures": ("Both sets of runs", _pictures),
    "others": ("What may be chance", _other_channels),
    "assumptions": ("How it was tested", _test_assumptions),
}
"""Sections by name: the heading, and what gives the nodes below it, of a comparison of studies."""
