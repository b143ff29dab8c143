"""What a comparison comes down to, for the terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import isnan

from rich.box import SIMPLE_HEAD
from rich.markup import escape
from rich.table import Table

from hydrosim.compare.comparison import Comparison, Result
from hydrosim.compare.figures import BANDS

LISTED = 12  # names in a line
SMALL = 1e-5  # share that is not told more exactly


def lines(found: Comparison) -> Iterator[str]:
    """How it was compared, and what was not."""
    time = found.overlap.time
    yield f"compared  {found.overlap.method}, {time[0]:g} s to {time[-1]:g} s, {time.size} times"
    if found.shift is not None:
        shift = f"{found.shift:+.3f} s added to the recorded times (estimated)"
        yield f"shift     {'none: no channel correlates' if isnan(found.shift) else shift}"
    if found.zero:
        yield f"zero      in both: {_listed(found.zero)}"
    if found.unused:
        why = "no guess, say in a mapping what they are" if found.guessed else "not in the mapping"
        yield f"unused    {_listed(found.unused)} ({why})"


def mapped(found: Comparison) -> Iterator[Table | str]:
    """Which column was taken for which channel, in which unit; of those that are called as the
    channel and in its unit, only how many they are."""
    pairs = [result.pair for result in found.results.values()]
    others = [pair for pair in pairs if (pair.column, pair.said) != (pair.channel, pair.unit)]
    if len(others) < len(pairs):
        yield f"channels  {len(pairs) - len(others)} found by their own names, in their units"
    if others:
        how = "guessed from names and units" if found.guessed else "by the mapping"
        table = _table(f"Channels {how}")
        for heading in ("channel", "column", "recorded in"):
            table.add_column(heading, overflow="fold")
        for pair in others:
            said = pair.said or f"not said, taken for {pair.unit}"
            table.add_row(*map(escape, (pair.channel, pair.column, said)))
        yield table


def verdicts(found: Comparison, beyond: Mapping[str, float]) -> Table:
    """The main figures of each channel and what its difference is; ``beyond`` are the tolerances
    that are not kept."""
    table = _figures("Ours minus recorded", ("rms", "rms/std", "peak", "correlation"))
    table.add_column("the recording is", overflow="fold")
    for name, result in found.results.items():
        f = result.figures
        out = f"[bold red]out of {beyond[name]:g}:[/] " if name in beyond else ""
        relative = "constant" if f.std == 0.0 else _percent(f.relative)
        figures = (f"{f.rms:.3g}", relative, f"{f.peak:.3g}", f"{f.correlation:.4f}")
        table.add_row(_named(result), *figures, out + escape(result.verdict))
    return table


def details(found: Comparison) -> Table:
    """Means, drifts, the fit, and bands of frequency."""
    low, high = found.edges
    title = (
        "Ours minus recorded; gain and lag of the recording; rms/std in bands of frequency (std of"
        f" ours over recorded): slow below {low:g} rad/s, waves, fast above {high:g} rad/s"
    )
    table = _figures(title, ("mean", "drift", "gain", "lag \\[s]", *BANDS))
    for result in found.results.values():
        f = result.figures
        fit = (f"{result.fit.gain:.4g}", f"{result.fit.lag:.3f}")
        table.add_row(_named(result), f"{f.mean:.3g}", f"{f.drift:.3g}", *fit, *_bands(result))
    return table


def contacts(found: Comparison) -> Iterator[str]:
    """First contact and share of contact of each fender."""
    for name, result in found.results.items():
        if c := result.contact:
            first = f"first {_instant(c.first_ours)}, recorded {_instant(c.first_recorded)}"
            share = f"{c.share_ours:.1%} of the time, recorded {c.share_recorded:.1%}"
            yield f"contact   {name}: {first}; {share}"


def _instant(time: float) -> str:
    return "none" if isnan(time) else f"{time:.1f} s"


def _bands(result: Result) -> Iterator[str]:
    f = result.figures
    for residual, ours, recorded in zip(f.band_rms, f.band_ours, f.band_recorded, strict=True):
        ratio = f" ({ours / recorded:.3f})" if recorded > 1e-3 * f.std else ""
        yield f"{_percent(residual / f.std)}{ratio}" if f.std > 0.0 else ""


def _listed(names: Sequence[str]) -> str:
    more = len(names) - LISTED
    return ", ".join(names[:LISTED]) + (f" and {more} more" if more > 0 else "")


def _table(title: str) -> Table:
    return Table(title=title, title_justify="left", box=SIMPLE_HEAD, pad_edge=False)


def _figures(title: str, headings: Sequence[str]) -> Table:
    table = _table(title)
    table.add_column("channel", overflow="fold")
    for heading in headings:
        table.add_column(
            heading, justify="right", overflow="fold", min_width=min(len(heading) + 4, 9)
        )
    return table


def _named(result: Result) -> str:
    return escape(f"{result.pair.channel} [{result.pair.unit}]")


def _percent(share: float) -> str:
    return f"{100.0 * share:.3g} %" if share == 0.0 or share > SMALL else f"< {100.0 * SMALL:g} %"
