"""Figures of a run as tables: means, extremes with their intervals; stages, modes, crawl."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.documents.digits import digits_of
from hydrosim.report.blocks import Block, Number, Points, Table, Text, number
from hydrosim.results.stages import FIGURES, TIME, stage_lines, stages
from hydrosim.statistics.contact import contact_statistics
from hydrosim.statistics.extremes import LAWS, Basis
from hydrosim.statistics.sentences import (
    HOW,
    NAMED,
    SEEDS,
    Scale,
    mean_differs,
    reason,
    scale_of,
)
from hydrosim.statistics.statistics import NAMES, SIDES, statistics

FEWEST = 16  # records that figures are made of
MOMENTS = ("mean", "std", "significant", "period", "smallest", "largest")
GROWN = ", when the waves have grown to their full height"
KILO = Scale(1e-3, "kN")
Cell = str | Number


def statistics_blocks(run: xr.Dataset) -> Iterator[Block]:
    """Moments of each channel that varies, its extremes, and what those are by."""
    if run.time.size < FEWEST or not bool(np.isfinite(run.position).all()):
        yield Text("There are no statistics: the run has too few records, or some are no numbers.")
        return
    start = _start(run)
    found = statistics(run, start)
    percent = 100.0 * found.motion_extreme.attrs["interval_probability"]
    yield Text(
        "Significant is four standard deviations, a double amplitude; the period is the mean"
        f" between upcrossings. Figures are from {start:g} s on{GROWN if start else ''}. Extremes"
        f" are of {found.attrs['exposure']:g} s: the most probable"
        f" one with its {percent:.0f} % interval, and between which values that of another such run"
        f" is by {percent:.0f} %. Where a channel has no extremes it is said why; --from is"
        " an option of hydrosim statistics."
    )
    channels = list(_channels(found))
    moments = [row for each in channels for row in _moments(found, *each)]
    yield Table(("channel", *MOMENTS), moments)
    told = [(each[2], mean_differs(found, *each[:2], each[3])) for each in channels]
    if warned := [f"{title}: {text}" for title, text in told if text]:
        yield Points(warned)
    head = ("channel", "side", "observed", "most probable (interval)", "another run", "by")
    rows = [row for each in channels for row in _extremes(found, *each)]
    yield Table(head, rows)
    if any(SEEDS in str(row[-1]) for row in rows):
        yield Text(f"For {HOW}.")


def contact_blocks(run: xr.Dataset) -> Iterator[Block]:
    """Stages of groups of contacts, what contacts did, and crawl by phase."""
    if "fender_mode" not in run or run.time.size < 2:
        return
    told = xr.Dataset(stages(run))
    if lines := list(stage_lines(told)):
        yield Points(lines)
        yield Table(("group", *map(str, told.stage.values)), list(_stage_times(told)))
        head = ("group", *(what for what, _ in FIGURES.values()))
        yield Table(head, list(_stage_figures(told)))
    found = xr.Dataset(contact_statistics(run))
    modes = [str(mode) for mode in found["mode"].values]
    head = ("contact", *(f"{mode}, share of time" for mode in modes), "distance slipped")
    yield Table(head, list(_modes(found, modes)))
    head = ("group", "phase", "duration", "body", "crawl in x", "crawl in y")
    yield Table(head, list(_phases(found)))


def _start(run: xr.Dataset) -> float:
    """Where the waves have grown, if that is well before the end."""
    ramp, time = float(run.attrs.get("wave_ramp", 0.0)), run.time.values
    return ramp if time[0] < ramp < 0.5 * (time[0] + time[-1]) else 0.0


Channel = tuple[str, dict[str, str], str, Scale]
"""A channel in statistics: kind, labels, what it is called, its scale."""


def _channels(found: xr.Dataset) -> Iterator[Channel]:
    for body in map(str, found.body.values):
        for dof in map(str, found.dof.values):
            yield "motion", {"body": body, "dof": dof}, f"{body} {dof}", scale_of(dof)
    if "wave" in found:
        yield "wave", {}, "wave elevation", Scale(1.0, "m")
    for kind in ("fender", "spring"):
        for name in map(str, found[kind].values if kind in found.coords else ()):
            if f"{kind}_force" in found:
                yield f"{kind}_force", {kind: name}, f"force of {name}", KILO


def _constant(found: xr.Dataset, kind: str, at: dict[str, str]) -> bool:
    return bool((found[f"{kind}_basis"].sel(at) == Basis.CONSTANT).any())


def _moments(
    found: xr.Dataset, kind: str, at: dict[str, str], title: str, scale: Scale
) -> Iterator[list[Cell]]:
    if _constant(found, kind, at):
        return
    of = found[kind].sel(at)
    yield [
        title,
        *(
            number(float(of.sel(statistic=name)), "s")
            if name == "period"
            else number(scale.factor * float(of.sel(statistic=name)), scale.unit)
            for name in MOMENTS
        ),
    ]


def _extremes(
    found: xr.Dataset, kind: str, at: dict[str, str], title: str, scale: Scale
) -> Iterator[list[Cell]]:
    if _constant(found, kind, at):
        return
    figures = {
        name: scale.factor * float(found[kind].sel({**at, "statistic": name})) for name in NAMES
    }
    words = {name: f"{value:.3f}" for name, value in figures.items()}
    said = {**words, "unit": scale.unit, "ramp": found.attrs["wave_ramp"]}
    bases = {s: Basis(int(found[f"{kind}_basis"].sel({**at, "side": s}))) for s in SIDES}
    if bases["smallest"] == bases["largest"] not in LAWS:
        both = f"{_between(*(figures[side] for side in SIDES))} {scale.unit}"
        yield [title, "both", both, "–", "–", reason(bases["largest"], said)]
        return
    for side, basis in bases.items():
        observed = number(figures[side], scale.unit)
        if basis not in LAWS:
            yield [title, side, observed, "–", "–", reason(basis, said)]
            continue
        extreme = scale.factor * found[f"{kind}_extreme"].sel({**at, "side": side})
        of = {str(name): float(extreme.sel(extreme=name)) for name in extreme.extreme.values}
        probable = _between(of["mpm_lower"], of["mpm_upper"])
        probable = f"{digits_of(of['mpm'])} ({probable}) {scale.unit}"
        another = f"{_between(of['predicted_lower'], of['predicted_upper'])} {scale.unit}"
        yield [title, side, observed, Number(of["mpm"], probable), another, NAMED[basis]]


def _between(low: float, high: float) -> str:
    return f"{digits_of(low)} to {digits_of(high)}"


def _stage_times(told: xr.Dataset) -> Iterator[list[Cell]]:
    for group in told.contact_group.values:
        times = told[TIME].sel(contact_group=group).values
        yield [str(group), *(number(float(t), "s", 6) for t in times)]


def _stage_figures(told: xr.Dataset) -> Iterator[list[Cell]]:
    for group in told.contact_group.values:
        of = told.sel(contact_group=group)
        cells = []
        for name, (_, unit) in FIGURES.items():
            scale = KILO if unit == "N" else Scale(1.0, "" if unit == "1" else unit)
            cells.append(number(scale.factor * float(of[name]), scale.unit))
        yield [str(group), *cells]


def _modes(found: xr.Dataset, modes: list[str]) -> Iterator[list[Cell]]:
    for name in found.fender.values:
        of = found.sel(fender=name)
        shares = [number(100.0 * float(of.fender_share.sel(mode=m)), "%", 3) for m in modes]
        yield [str(name), *shares, number(float(of.fender_slipped), "m")]


def _phases(found: xr.Dataset) -> Iterator[list[Cell]]:
    for group in found.contact_group.values:
        for phase in found.phase.values:
            at = found.sel(contact_group=group, phase=phase)
            seconds = float(at.phase_duration)
            for body in found.body.values if seconds > 0.0 else ():
                x, y = at.phase_crawl.sel(body=body).values
                moved = [number(float(x), "m", 3), number(float(y), "m", 3)]
                yield [str(group), str(phase), number(seconds, "s"), str(body), *moved]
