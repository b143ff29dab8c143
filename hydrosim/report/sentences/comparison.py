"""Reports of comparisons: of a run with a recording, and of two sets of runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.files import document_nodes
from hydrosim.files.display_units import units_of
from hydrosim.files.document import Document
from hydrosim.report.run_charts import CHARTS_NOTE
from hydrosim.report.sentences.sections import (
    MAX_TABLE_ROWS,
    Sections,
    build_sections,
    lines_of,
    table_of,
)

if TYPE_CHECKING:
    import xarray as xr

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


def comparison_document(comparison: xr.Dataset) -> Document:
    """The report of a comparison."""
    time = comparison.time.values.astype(float)
    nodes = build_sections(COMPARISON_SECTIONS, comparison)
    return Document(
        names_compared(comparison), nodes, _span_text(time), units_of(comparison.attrs), time
    )


def comparison_tables(comparison: xr.Dataset) -> Document:
    """What differs, and how it was compared, without both series."""
    bands = (replace(node, detail=True) for node in _describe_bands(comparison))
    nodes = [
        *_describe_outcome(comparison),
        *_describe_contacts(comparison),
        *bands,
        *_comparison_assumptions(comparison),
    ]
    span = _span_text(comparison.time.values.astype(float))
    return Document(names_compared(comparison), nodes, span, units_of(comparison.attrs))


def _span_text(time: np.ndarray) -> str:
    """Which times were compared."""
    return (
        f"Comparison channel by channel, from {time[0]:g} s to {time[-1]:g} s, at {time.size} times"
    )


def names_compared(comparison: xr.Dataset) -> str:
    """What was compared with what."""
    names = [str(comparison.attrs.get(name, "")) or "unknown" for name in ("run", "recording")]
    return " and ".join(names)


def compared_files(comparison: xr.Dataset, other: str) -> Iterator[tuple[str, str]]:
    """What "ours" and the ``other`` are."""
    title = str(comparison.attrs.get("title", ""))
    yield "ours", f"{comparison.attrs.get('run', 'unknown')}{': ' if title else ''}{title}"
    yield other, str(comparison.attrs.get("recording", "unknown"))


def _describe_outcome(comparison: xr.Dataset) -> document_nodes.Nodes:
    yield document_nodes.Table(("", "file"), list(compared_files(comparison, "recorded")))
    yield document_nodes.Sentence(_counts_by_difference(comparison))
    yield from _describe_tolerances(comparison)
    channels = [comparison.isel(channel=k) for k in _order_by_difference(comparison)]
    verdicts = [(str(channel.channel.values), str(channel.verdict.values)) for channel in channels]
    yield document_nodes.Table(("channel", "what is recorded is"), verdicts)
    title = "Ours less recorded; std is that of what is recorded"
    yield document_nodes.Table(
        CHANNEL_COLUMNS, [_channel_cells(channel) for channel in channels], title
    )
    yield document_nodes.List(RULES, "What the words mean:", detail=True)


def _counts_by_difference(comparison: xr.Dataset) -> str:
    """How many channels differ by how much."""
    size = _error_ratios(comparison)
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


def _error_ratios(comparison: xr.Dataset) -> np.ndarray:
    """The rms of each difference (n,) over the std recorded, or the largest value of a constant."""
    largest = np.abs(np.stack([comparison.ours, comparison.recorded])).max(axis=(0, 1))
    alone = comparison.rms.values / np.where(largest > 0.0, largest, 1.0)
    return np.where(np.isnan(comparison.relative.values), alone, comparison.relative.values)


def _order_by_difference(comparison: xr.Dataset) -> np.ndarray:
    """Channels in the `KIND_ORDER` of their kinds, of each kind those first that differ most."""
    kinds = np.array([_kind(str(name)) for name in comparison.channel.values])
    return np.lexsort((-_error_ratios(comparison), kinds))


def _kind(name: str) -> int:
    of = next((kind for kind in KIND_ORDER if kind and name.startswith(kind)), "")
    return KIND_ORDER.index(of)


def _describe_tolerances(comparison: xr.Dataset) -> document_nodes.Nodes:
    """Which channels are beyond what they may be."""
    limit = (
        comparison.tolerance.values
        if "tolerance" in comparison
        else np.full(comparison.sizes["channel"], np.nan)
    )
    if np.isnan(limit).all():
        yield document_nodes.Sentence(
            "No tolerance was given, so differences are not judged.", detail=True
        )
        return
    size = channel_errors(comparison)
    out = np.flatnonzero(~(size <= limit) & ~np.isnan(limit))
    held = [str(out.size), str(np.count_nonzero(~np.isnan(limit)))]
    outcome = document_nodes.Outcome.BAD if out.size else document_nodes.Outcome.GOOD
    yield document_nodes.Verdict(outcome, "{} of {} channels are out of tolerance.", held)
    for k in out:
        parts: list[document_nodes.Part] = [
            str(comparison.channel.values[k]),
            document_nodes.Value(float(size[k]), "", 3),
            document_nodes.Value(float(limit[k])),
        ]
        yield document_nodes.Verdict(document_nodes.Outcome.BAD, "{}: {}, tolerance {}", parts)


def _channel_cells(channel: xr.Dataset) -> document_nodes.Row:
    unit = str(channel.units.values)
    rms, peak = document_nodes.value_cells((channel.rms, channel.peak), unit)
    relative = float(channel.relative)
    share = "constant" if np.isnan(relative) else document_nodes.Value(relative, "share", 3)
    at = document_nodes.Value(float(channel.peak_time), "s")
    correlation = document_nodes.Value(float(channel.correlation))
    return [str(channel.channel.values), rms, share, peak, at, correlation]


def _describe_series(comparison: xr.Dataset) -> document_nodes.Nodes:
    yield document_nodes.Sentence(CHARTS_NOTE)
    for rank, k in enumerate(_order_by_difference(comparison)):
        both, difference = channel_charts(comparison.isel(channel=k))
        yield replace(both, folded=rank >= MAIN_CHART_COUNT)
        yield replace(difference, folded=True)


def channel_charts(channel: xr.Dataset) -> tuple[document_nodes.Chart, document_nodes.Chart]:
    """Both series of a channel of a comparison, and their difference."""
    name, unit = str(channel.channel.values), str(channel.units.values)
    both, difference = (
        {label: document_nodes.ChartLine(channel[series].values) for label, series in lines.items()}
        for lines in ({"ours": "ours", "recorded": "recorded"}, {"ours less recorded": "residual"})
    )
    return (
        document_nodes.Chart(f"{name}: {channel.verdict.values}", "", unit, both),
        document_nodes.Chart(f"{name}: difference", "difference", unit, difference),
    )


def channel_errors(comparison: xr.Dataset) -> np.ndarray:
    """The rms of each difference (n,), over the std of what is recorded; of a constant as it is."""
    rms, relative = comparison.rms.values, comparison.relative.values
    return np.where(np.isnan(relative), rms, relative)


def _describe_bands(
    comparison: xr.Dataset,
) -> Iterator[document_nodes.Sentence | document_nodes.Table]:
    low, high = np.ravel(comparison.attrs["band_edges"])
    yield document_nodes.Sentence(
        "Rms of the difference without its mean over the std recorded, and in brackets std of ours"
        f" over that recorded: slow is below {low:g} rad/s, fast above {high:g} rad/s, waves are"
        " between. Drift is the mean of the last tenth of the time less that of the first."
    )
    names = [str(band) for band in comparison.band.values]
    rows = [
        _band_cells(comparison.isel(channel=k), names) for k in _order_by_difference(comparison)
    ]
    head = ("channel", "mean difference", "difference of drifts", "gain", "lag", *names)
    yield document_nodes.Table(head, rows)


def _band_cells(channel: xr.Dataset, names: list[str]) -> document_nodes.Row:
    unit = str(channel.units.values)
    std = float(channel["std"])
    bands = [_band_text(channel.sel(band=name), std) for name in names]
    ends = document_nodes.value_cells((channel["mean"], channel.drift), unit)
    fit = [document_nodes.Value(float(channel.gain)), document_nodes.Value(float(channel.lag), "s")]
    return [str(channel.channel.values), *ends, *fit, *bands]


def _band_text(at: xr.Dataset, std: float) -> str:
    if std == 0.0:
        return "–"
    share = f"{100.0 * float(at.band_rms) / std:.3g} %"
    is_large = float(at.band_recorded) > RMS_SHARES[0] * std
    return f"{share} ({float(at.band_ours / at.band_recorded):.3f})" if is_large else share


def _describe_contacts(comparison: xr.Dataset) -> document_nodes.Nodes:
    contacts = comparison.isel(channel=np.flatnonzero(~np.isnan(comparison.share_ours.values)))
    if contacts.sizes["channel"] == 0:
        return
    columns = {
        "first, ours": (contacts.first_ours, "s"),
        "first, recorded": (contacts.first_recorded, "s"),
        "share, ours": (contacts.share_ours, "share"),
        "share, recorded": (contacts.share_recorded, "share"),
    }
    yield table_of("contact", columns, "First contact and share of the time in contact")


def _comparison_assumptions(comparison: xr.Dataset) -> document_nodes.Nodes:
    rows = [("times", str(comparison.attrs.get("compared", "unknown")))]
    if "shift" in comparison.attrs:
        rows.append(("added to the recorded times", _shift_text(float(comparison.attrs["shift"]))))
    yield document_nodes.Table(("assumption", ""), rows)
    guessed = bool(comparison.attrs.get("guessed"))
    if guessed:
        yield document_nodes.Sentence(
            "Which column is which channel was guessed from names and units."
        )
    pairs = zip(
        comparison.channel.values, comparison.column.values, comparison.units.values, strict=True
    )
    recorded_units = (
        comparison.recorded_in.values
        if "recorded_in" in comparison
        else [""] * comparison.sizes["channel"]
    )
    rows_ = [
        (*map(str, pair), str(unit) or f"not said, taken for {pair[2]}")
        for pair, unit in zip(pairs, recorded_units, strict=True)
    ]
    others = [row for row in rows_ if row[0] != row[1] or row[2] != row[3]]
    if others:
        yield document_nodes.Table(("channel", "column", "unit", "recorded in"), others)
    why = "no guess: say in a mapping what they are" if guessed else "not in the mapping"
    for name, what in (("unused", f"Not compared ({why})"), ("zero_in_both", "Zero in both")):
        if left := lines_of(comparison, name):
            yield document_nodes.Sentence("{}: {}.", [what, ", ".join(left)])
    yield document_nodes.Sentence(
        "These are figures of two series, and have no intervals; hydrosim compare of two studies"
        " says which differences are more than chance. Which of the two is right is not judged."
    )


def _shift_text(seconds: float) -> str:
    return "none: no channel correlates" if np.isnan(seconds) else f"{seconds:+.3f} s (estimated)"


COMPARISON_SECTIONS: Sections[xr.Dataset] = {
    "outcome": ("What differs", _describe_outcome),
    "series": ("Both over time", _describe_series),
    "contacts": ("Contacts", _describe_contacts),
    "bands": ("Slow, waves, fast", _describe_bands),
    "assumptions": ("How it was compared", _comparison_assumptions),
}
"""Sections by name: the heading, and what gives the nodes below it, of a comparison."""


# Two sets of runs: numbers that differ by more than chance.

MAX_PICTURES = 12


def studies_document(comparison: xr.Dataset) -> Document:
    """The report of a comparison of two sets of runs."""
    return Document(
        names_compared(comparison),
        build_sections(STUDY_COMPARISON_SECTIONS, comparison),
        _run_counts(comparison),
        units_of(comparison.attrs),
    )


def studies_tables(comparison: xr.Dataset) -> Document:
    """What differs and what may be chance, without pictures."""
    others = (replace(node, detail=True) for node in _other_channels(comparison))
    nodes = [*_study_outcome(comparison), *others]
    return Document(
        names_compared(comparison), nodes, _run_counts(comparison), units_of(comparison.attrs)
    )


def _run_counts(comparison: xr.Dataset) -> str:
    """How many runs were compared, and how."""
    counts = f"{comparison.sizes['run']} and {comparison.sizes['other_run']} runs"
    return f"{counts}: {comparison.attrs['compared']}"


def _study_outcome(comparison: xr.Dataset) -> document_nodes.Nodes:
    yield document_nodes.Table(("", "file"), list(compared_files(comparison, "theirs")))
    differing, equal = _differing_channels(comparison), _is_equal(comparison)
    all_, level = comparison.sizes["channel"], float(comparison.attrs["level"])
    yield document_nodes.Sentence(
        f"{differing.sizes['channel']} of {all_} channels differ by more than chance;"
        f" {int(equal.sum())} are equal in all runs, and differences of the other"
        f" {all_ - differing.sizes['channel'] - int(equal.sum())} may be chance. Were there no"
        f" difference at all, one or more would be named in {level:.0%} of such comparisons."
    )
    if comparison.attrs.get("durations"):
        yield document_nodes.warning(
            "The durations differ, so extremes, sums and places at the end differ by that alone.",
        )
    if codes := str(comparison.attrs.get("codes_apart", "")).split():
        yield document_nodes.warning(
            "Codes differ too. They are not tested: {}.",
            [", ".join(codes)],
        )
    if differing.sizes["channel"]:
        yield document_nodes.Sentence("What differs, the most certain first:")
        yield _difference_table(differing)


def _channel_pictures(comparison: xr.Dataset) -> document_nodes.Nodes:
    differing, paired = _differing_channels(comparison), bool(comparison.attrs.get("paired"))
    if not differing.sizes["channel"]:
        return
    order = "theirs rise; one above the other are runs of the same seed" if paired else "each rise"
    yield document_nodes.Sentence(
        f"Values in all runs of the channels that differ most certainly, {MAX_PICTURES} at most:"
        f" {order}. Of channels that are alike, as by symmetry, the first is drawn."
    )
    alike = {
        channel.theirs.values.tobytes(): channel for channel in reversed(list(_rows(differing)))
    }
    for channel in list(reversed(alike.values()))[:MAX_PICTURES]:
        yield _channel_curves(channel, paired)


def _channel_curves(channel: xr.Dataset, paired: bool) -> document_nodes.Chart:
    unit = str(channel.units.values)
    ours, theirs = (channel[name].values for name in ("ours", "theirs"))
    order = np.argsort(theirs)
    sets = {"ours": ours[order] if paired else np.sort(ours), "theirs": theirs[order]}
    lines = {
        name: document_nodes.ChartLine(values, (np.arange(values.size) + 0.5) / values.size)
        for name, values in sets.items()
    }
    return document_nodes.Chart(
        str(channel.channel.values),
        "value",
        unit,
        lines,
        x_label="share of the runs, in this order",
        x_unit="share",
    )


def _other_channels(
    comparison: xr.Dataset,
) -> Iterator[document_nodes.Sentence | document_nodes.Table]:
    rest = comparison.isel(
        channel=np.flatnonzero((comparison.differs == 0) & ~_is_equal(comparison))
    )
    rest = rest.isel(channel=np.argsort(rest.chance.values))
    if rest.sizes["channel"]:
        yield _difference_table(rest.isel(channel=slice(MAX_TABLE_ROWS)))
    if names := [str(name) for name in comparison.channel.values[_is_equal(comparison)]]:
        yield document_nodes.Sentence(f"Equal in all runs: {', '.join(names)}.")


def _test_assumptions(comparison: xr.Dataset) -> document_nodes.Nodes:
    paired = bool(comparison.attrs.get("paired"))
    test = (
        "Runs of the same seed and parameters are pairs; their differences are tested by"
        " Student's t."
        if paired
        else "The two sets have no seeds in common, or not each seed once; they are independent,"
        " and their means are tested by Welch's t."
    )
    interval = float(comparison.attrs["interval_probability"])
    yield document_nodes.Sentence(
        f"{test} Intervals hold the mean difference of very many runs by {interval:.0%}."
    )
    yield document_nodes.Sentence(
        f"A channel differs if it does at {float(comparison.attrs['level']):.0%} for all channels"
        " together, by Holm's procedure (1979). Both tests take values that are about normal over"
        " runs. A difference that is certain may be too small to matter, and one that may be chance"
        " may be large: more seeds tell. What step the solver has is not assessed."
    )


def _differing_channels(comparison: xr.Dataset) -> xr.Dataset:
    differing = comparison.isel(channel=np.flatnonzero(comparison.differs.values))
    return differing.isel(channel=np.argsort(differing.chance.values, kind="stable"))


def _is_equal(comparison: xr.Dataset) -> np.ndarray:
    """Which channels (n,) are the same in all runs."""
    ends = np.stack([comparison[name].values for name in ("difference", "low", "high")])
    return np.asarray((ends == 0.0).all(axis=0))


def _rows(comparison: xr.Dataset) -> Iterator[xr.Dataset]:
    return (comparison.isel(channel=k) for k in range(comparison.sizes["channel"]))


def _difference_table(rows: xr.Dataset) -> document_nodes.Table:
    interval = f"{float(rows.attrs['interval_probability']):.0%} interval"
    head = ("channel", "ours", "theirs", "ours less theirs", "of theirs", interval, "by chance")
    return document_nodes.Table(head, [_study_row(channel) for channel in _rows(rows)])


def _study_row(channel: xr.Dataset) -> document_nodes.Row:
    unit = str(channel.units.values)
    figures = channel.ours_mean, channel.theirs_mean, channel.difference
    means = document_nodes.value_cells(figures, unit)
    interval = document_nodes.Between(float(channel.low), float(channel.high), unit)
    theirs = abs(float(channel.theirs_mean)) or np.nan
    share = document_nodes.Value(float(channel.difference) / theirs, "share", 2)
    chance = document_nodes.Value(float(channel.chance), "", 2)
    return [str(channel.channel.values), *means, share, interval, chance]


STUDY_COMPARISON_SECTIONS: Sections[xr.Dataset] = {
    "outcome": ("What differs", _study_outcome),
    "pictures": ("Both sets of runs", _channel_pictures),
    "others": ("What may be chance", _other_channels),
    "assumptions": ("How it was tested", _test_assumptions),
}
"""Sections by name: the heading, and what gives the nodes below it, of a comparison of studies."""
