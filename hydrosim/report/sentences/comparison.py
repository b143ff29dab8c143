"""A comparison of a run with a recording: what differs in words and figures, and both series."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np
import xarray as xr

from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.files.document_nodes import (
    Between,
    Cell,
    Chart,
    Curves,
    List,
    Node,
    Outcome,
    Part,
    PlottedCurve,
    Sentence,
    Table,
    Value,
    Verdict,
)
from hydrosim.report.sentences.sections import MAX_TABLE_ROWS, Sections, build_sections, lines_of
from hydrosim.report.sentences.series import CHARTS_NOTE

COMPARISON_VARIABLES = ("ours", "recorded", "residual", "verdict")
RMS_SHARES = (1e-3, 0.01, 0.1)
"""Rms over std, between which channels are counted."""
KIND_ORDER = ("position", "wave", "fender", "spring", "", "energy")
"""Kinds of channels."""
MAIN_CHART_COUNT = 12
"""Charts that are open."""
CHANNEL_COLUMNS = ("channel", "rms", "rms/std", "largest", "at", "correlation")
RULES = (
    "Gain 1.02, late by 0.3 s, offset 0.05 m: what was recorded is 1.02 times the run, comes 0.3 s"
    " later and lies 0.05 m higher. Each is said only if the agreement is clearly worse without.",
    "Sign swapped, degrees for radians, N for kN: the gain is that of a sign or a unit.",
    "Another realisation: waves of the same size that do not correlate at any lag; another seed.",
    "Apart by 12 % of the std: none of these, and how much it is.",
)
"""What the words of a verdict mean."""


def is_comparison(found: xr.Dataset) -> bool:
    """Whether a dataset is what `hydrosim compare` writes of a run and a recording."""
    return all(name in found for name in COMPARISON_VARIABLES) and "channel" in found.dims


def comparison_document(found: xr.Dataset) -> Document:
    """The report of a comparison."""
    time = found.time.values.astype(float)
    nodes = build_sections(COMPARISON_SECTIONS, found)
    return Document(names_compared(found), nodes, _span(time), units_of(found.attrs), time)


def comparison_tables(found: xr.Dataset) -> Document:
    """What differs, and how it was compared, without both series."""
    bands = (replace(node, detail=True) for node in _bands(found))
    nodes = [*_outcome(found), *_contacts(found), *bands, *_comparison_assumptions(found)]
    said = _span(found.time.values.astype(float))
    return Document(names_compared(found), nodes, said, units_of(found.attrs))


def _span(time: np.ndarray) -> str:
    """Which times were compared."""
    return (
        f"Comparison channel by channel, from {time[0]:g} s to {time[-1]:g} s, at {time.size} times"
    )


def names_compared(found: xr.Dataset) -> str:
    """What was compared with what."""
    names = [str(found.attrs.get(name, "")) or "unknown" for name in ("run", "recording")]
    return " and ".join(names)


def files(found: xr.Dataset, other: str) -> Iterator[tuple[str, str]]:
    """What "ours" and the ``other`` are."""
    title = str(found.attrs.get("title", ""))
    yield "ours", f"{found.attrs.get('run', 'unknown')}{': ' if title else ''}{title}"
    yield other, str(found.attrs.get("recording", "unknown"))


def _outcome(found: xr.Dataset) -> Iterator[Node]:
    yield Table(("", "file"), list(files(found, "recorded")))
    yield Sentence(_counts_by_difference(found))
    yield from _tolerances(found)
    each = [found.isel(channel=k) for k in _order_by_difference(found)]
    verdicts = [(str(one.channel.values), str(one.verdict.values)) for one in each]
    yield Table(("channel", "what is recorded is"), verdicts)
    title = "Ours less recorded; std is that of what is recorded"
    yield Table(CHANNEL_COLUMNS, [_row(one) for one in each], title)
    yield List(RULES, "What the words mean:", detail=True)


def _counts_by_difference(found: xr.Dataset) -> str:
    """How many channels differ by how much."""
    size = _error(found)
    edges = [f"{100.0 * share:g}" for share in RMS_SHARES]
    ranges = [
        f"below {edges[0]} %",
        *(f"from {low} to {high} %" for low, high in pairwise(edges)),
        f"{edges[-1]} % or more",
    ]
    counts = np.bincount(np.digitize(size, RMS_SHARES), minlength=len(ranges))
    parts = [f"{count} {text}" for count, text in zip(counts, ranges, strict=True) if count]
    return (
        "The rms difference of each channel, relative to the std of the recording:"
        f" {', '.join(parts)} ({size.size} in all). For a constant channel it is relative to the"
        " largest value."
    )


def _error(found: xr.Dataset) -> np.ndarray:
    """The rms of each difference (n,) over the std recorded, or the largest value of a constant."""
    largest = np.abs(np.stack([found.ours, found.recorded])).max(axis=(0, 1))
    alone = found.rms.values / np.where(largest > 0.0, largest, 1.0)
    return np.where(np.isnan(found.relative.values), alone, found.relative.values)


def _order_by_difference(found: xr.Dataset) -> np.ndarray:
    """Channels in the `KIND_ORDER` of their kinds, of each kind those first that differ most."""
    kinds = np.array([_kind(str(name)) for name in found.channel.values])
    return np.lexsort((-_error(found), kinds))


def _kind(name: str) -> int:
    of = next((each for each in KIND_ORDER if each and name.startswith(each)), "")
    return KIND_ORDER.index(of)


def _tolerances(found: xr.Dataset) -> Iterator[Node]:
    """Which channels are beyond what they may be."""
    limit = (
        found.tolerance.values if "tolerance" in found else np.full(found.sizes["channel"], np.nan)
    )
    if np.isnan(limit).all():
        yield Sentence("No tolerance was given, so differences are not judged.", detail=True)
        return
    size = np.where(np.isnan(found.relative), found.rms, found.relative)
    out = np.flatnonzero(~(size <= limit) & ~np.isnan(limit))
    held = [str(out.size), str(np.count_nonzero(~np.isnan(limit)))]
    outcome = Outcome.BAD if out.size else Outcome.GOOD
    yield Verdict(outcome, "{} of {} channels are out of tolerance.", held)
    for k in out:
        parts: list[Part] = [
            str(found.channel.values[k]),
            Value(float(size[k]), "", 3),
            Value(float(limit[k])),
        ]
        yield Verdict(Outcome.BAD, "{}: {}, tolerance {}", parts)


def _row(one: xr.Dataset) -> list[Cell]:
    unit = str(one.units.values)
    rms, peak = (Value(float(one[name]), unit) for name in ("rms", "peak"))
    relative = float(one.relative)
    share = "constant" if np.isnan(relative) else Value(relative, "share", 3)
    at = Value(float(one.peak_time), "s")
    correlation = Value(float(one.correlation))
    return [str(one.channel.values), rms, share, peak, at, correlation]


def _series(found: xr.Dataset) -> Iterator[Node]:
    yield Sentence(CHARTS_NOTE)
    for rank, k in enumerate(_order_by_difference(found)):
        one = found.isel(channel=k)
        unit = str(one.units.values)
        name, folded = str(one.channel.values), rank >= MAIN_CHART_COUNT
        both = {"ours": one.ours.values, "recorded": one.recorded.values}
        yield Chart(f"{name}: {one.verdict.values}", unit, both, folded=folded)
        apart = {"ours less recorded": one.residual.values}
        yield Chart(f"{name}: difference", unit, apart, folded=True)


def _bands(found: xr.Dataset) -> Iterator[Sentence | Table]:
    low, high = np.ravel(found.attrs["band_edges"])
    yield Sentence(
        "Rms of the difference without its mean over the std recorded, and in brackets std of ours"
        f" over that recorded: slow is below {low:g} rad/s, fast above {high:g} rad/s, waves are"
        " between. Drift is the mean of the last tenth of the time less that of the first."
    )
    names = [str(band) for band in found.band.values]
    rows = [_of_bands(found.isel(channel=k), names) for k in _order_by_difference(found)]
    head = ("channel", "mean difference", "difference of drifts", "gain", "lag", *names)
    yield Table(head, rows)


def _of_bands(one: xr.Dataset, names: list[str]) -> list[Cell]:
    unit = str(one.units.values)
    std = float(one["std"])
    bands = [_band(one.sel(band=name), std) for name in names]
    ends = [Value(float(one[name]), unit) for name in ("mean", "drift")]
    fit = [Value(float(one.gain)), Value(float(one.lag), "s")]
    return [str(one.channel.values), *ends, *fit, *bands]


def _band(at: xr.Dataset, std: float) -> str:
    if std == 0.0:
        return "–"
    share = f"{100.0 * float(at.band_rms) / std:.3g} %"
    known = float(at.band_recorded) > RMS_SHARES[0] * std
    return f"{share} ({float(at.band_ours / at.band_recorded):.3f})" if known else share


def _contacts(found: xr.Dataset) -> Iterator[Node]:
    own = found.isel(channel=np.flatnonzero(~np.isnan(found.share_ours.values)))
    if own.sizes["channel"] == 0:
        return
    head = ("contact", "first, ours", "first, recorded", "share, ours", "share, recorded")
    columns = {
        "first_ours": "s",
        "first_recorded": "s",
        "share_ours": "share",
        "share_recorded": "share",
    }
    rows: list[list[Cell]] = [
        [str(name), *(Value(float(own[c][k]), unit) for c, unit in columns.items())]
        for k, name in enumerate(own.channel.values)
    ]
    yield Table(head, rows, "First contact and share of the time in contact")


def _comparison_assumptions(found: xr.Dataset) -> Iterator[Node]:
    rows = [("times", str(found.attrs.get("compared", "unknown")))]
    if "shift" in found.attrs:
        rows.append(("added to the recorded times", _shift(float(found.attrs["shift"]))))
    yield Table(("assumption", ""), rows)
    guessed = bool(found.attrs.get("guessed"))
    if guessed:
        yield Sentence("Which column is which channel was guessed from names and units.")
    pairs = zip(found.channel.values, found.column.values, found.units.values, strict=True)
    said = found.recorded_in.values if "recorded_in" in found else [""] * found.sizes["channel"]
    rows_ = [
        (*map(str, pair), str(unit) or f"not said, taken for {pair[2]}")
        for pair, unit in zip(pairs, said, strict=True)
    ]
    others = [row for row in rows_ if row[0] != row[1] or row[2] != row[3]]
    if others:
        yield Table(("channel", "column", "unit", "recorded in"), others)
    why = "no guess: say in a mapping what they are" if guessed else "not in the mapping"
    for name, what in (("unused", f"Not compared ({why})"), ("zero_in_both", "Zero in both")):
        if left := lines_of(found, name):
            yield Sentence("{}: {}.", [what, ", ".join(left)])
    yield Sentence(
        "These are figures of two series, and have no intervals; hydrosim compare of two studies"
        " says which differences are more than chance. Which of the two is right is not judged."
    )


def _shift(seconds: float) -> str:
    return "none: no channel correlates" if np.isnan(seconds) else f"{seconds:+.3f} s (estimated)"


COMPARISON_SECTIONS: Sections[xr.Dataset] = {
    "outcome": ("What differs", _outcome),
    "series": ("Both over time", _series),
    "contacts": ("Contacts", _contacts),
    "bands": ("Slow, waves, fast", _bands),
    "assumptions": ("How it was compared", _comparison_assumptions),
}
"""Sections by name: the heading, and what gives the nodes below it, of a comparison."""


# The report of a comparison of two sets of runs: which numbers differ by more than chance.

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
    nodes = [*_study_outcome(found), *others]
    return Document(names_compared(found), nodes, _run_counts(found), units_of(found.attrs))


def _run_counts(found: xr.Dataset) -> str:
    """How many runs were compared, and how."""
    counts = f"{found.sizes['run']} and {found.sizes['other_run']} runs"
    return f"{counts}: {found.attrs['compared']}"


def _study_outcome(found: xr.Dataset) -> Iterator[Node]:
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
    return Table(head, [_study_row(each) for each in _rows(rows)])


def _study_row(one: xr.Dataset) -> list[Cell]:
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
    "outcome": ("What differs", _study_outcome),
    "pictures": ("Both sets of runs", _pictures),
    "others": ("What may be chance", _other_channels),
    "assumptions": ("How it was tested", _test_assumptions),
}
"""Sections by name: the heading, and what gives the nodes below it, of a comparison of studies."""
