"""Statistics as text: a few lines for each channel and each group of contacts."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import xarray as xr

from hydrosim.results.stages import FIGURES as OF_STAGES
from hydrosim.results.stages import TIME, stage_lines
from hydrosim.statistics.effects import spread
from hydrosim.statistics.extremes import LAWS, Basis
from hydrosim.statistics.gumbel import Gumbel, exceeding, fit_maxima, follows_gumbel
from hydrosim.statistics.orders import ENOUGH, find_confidence, find_prediction
from hydrosim.statistics.statistics import FIGURES, NAMES, SIDES

RUNS = 8  # to fit Gumbel's law to
P90 = 0.9  # probability that the largest of a run is below
ANGLES = ("roll", "pitch", "yaw")
NAMED = {
    Basis.GAUSSIAN: "a Gaussian process",
    Basis.CLIPPED_GAUSSIAN: "a clipped Gaussian process",
    Basis.GUMBEL: "Gumbel's law",
    Basis.IMPACTS: "impacts of exponential sizes",
}
SEEDS = f"the largest of {ENOUGH} seeds"
HOW = (
    f"{SEEDS} write a study file with `case: CASE.yaml` and `seeds: 1-{ENOUGH}`, and call"
    " `hydrosim sweep STUDY.yaml`: the smallest and the largest of so many hold that of another"
    " run in 90 %"
)
MEAN_DIFFERS = (
    "warning: this mean is by impulses; that of the records is {:.3f} {}: the force changes between"
    " them. If it chatters from step to step, take a smaller solver.step, dopri5 or esdirk4; if it"
    " knocks, a smaller output.step."
)
LATER = "take a part that is stationary (--from)"
REASONS = {
    Basis.CLIPPED: "it stays there for much of the time",
    Basis.TOO_SHORT: "too short for what is slow in it, or not stationary: its mean goes from"
    " {first_mean} to {last_mean} {unit} (first and last fifth); simulate longer",
    Basis.RARE: f"there is too little contact: simulate longer, or take {SEEDS}",
    Basis.MEAN_CHANGES: "not stationary: its mean goes from {first_mean} to {last_mean} {unit}"
    f" (first and last fifth); {LATER}, or {SEEDS}",
    Basis.STD_CHANGES: "not stationary: its standard deviation goes from {first_std} to {last_std}"
    f" {{unit}} (first and last fifth), or goes up and down in between; {LATER}, or {SEEDS}",
    Basis.WAVES_GROW: "not stationary: the waves grow until {ramp:g} s: begin there (--from"
    " {ramp:g})",
    Basis.OPERATION: "not stationary: contact goes through phases while other channels change their"
    f" mean or standard deviation; {LATER}, or {SEEDS}",
    Basis.ALONE: "the largest values follow another law than the rest (impacts?), and are too few"
    f" for one of their own: simulate longer, or take {SEEDS}",
    Basis.HALVES: "a law that holds for one half of the record does not let the largest of the"
    f" other half happen (impacts, a change?): take {SEEDS}",
    Basis.BOUNDED: "its slow part goes to and fro between bounds, which no law of extremes knows:"
    f" take {SEEDS}",
    Basis.TRANSIENT: "it is larger at its beginning than later, as while it forgets how it began:"
    " begin later (--from)",
    Basis.NOT_FINITE: "it is not finite",
}


class Scale(NamedTuple):
    """What values are multiplied by to be in a unit that people read."""

    factor: float
    unit: str


def scale_of(dof: str) -> Scale:
    """Degrees for angles, metres for the others."""
    return Scale(180.0 / np.pi, "deg") if dof in ANGLES else Scale(1.0, "m")


def lines(found: xr.Dataset) -> Iterator[str]:
    """What `statistics` found: each channel that varies, crawl by phase, and how to ask many seeds
    where one record says too little."""
    told = list(_lines(found))
    yield from told
    if any(SEEDS in line for line in told):
        yield HOW


def _lines(found: xr.Dataset) -> Iterator[str]:
    percent = 100.0 * found.motion_extreme.attrs["interval_probability"]
    yield (
        f"extremes of {found.attrs['exposure']:g} s, with {percent:.0f} % intervals of the most"
        " probable one and of that of another such run"
    )
    for body in found.body.values:
        for dof in found.dof.values:
            at = {"body": body, "dof": dof}
            yield from _channel(found, "motion", at, f"{body} {dof}", scale_of(str(dof)))
    for kind in ("fender", "spring"):
        for name in found[kind].values if kind in found.coords else ():
            yield from _channel(found, f"{kind}_force", {kind: name}, str(name), Scale(1e-3, "kN"))
    for name in found.channel.values if "channel" in found.dims else ():
        unit = found.unit.sel(channel=name).item().removeprefix("1")
        yield from _channel(found, "named", {"channel": name}, str(name), Scale(1.0, str(unit)))
        yield from _in_phases(found, str(name), str(unit))
    if "phase_crawl" in found:
        yield from _phases(found)
    yield from stage_lines(found)


def _channel(
    found: xr.Dataset, kind: str, at: dict[str, str], title: str, scale: Scale
) -> Iterator[str]:
    basis = {side: Basis(int(found[f"{kind}_basis"].sel({**at, "side": side}))) for side in SIDES}
    if Basis.CONSTANT in basis.values():
        return
    figures = found[kind].sel(at)
    of = {name: scale.factor * float(figures.sel(statistic=name)) for name in NAMES}
    period = float(figures.sel(statistic="period"))
    yield (
        f"{title}: mean {of['mean']:.3f}, significant {of['significant']:.3f} {scale.unit},"
        + (
            " no period (it does not cross its mean twice)"
            if np.isnan(period)
            else f" period {period:.2f} s"
        )
    )
    if text := mean_differs(found, kind, at, scale):
        yield f"  {text}"
    values: dict[str, object] = {name: f"{value:.3f}" for name, value in of.items()}
    values["unit"] = scale.unit
    values["ramp"] = found.attrs["wave_ramp"]
    if basis["smallest"] == basis["largest"] not in LAWS:
        text = reason(basis["largest"], values)
        yield f"  {values['smallest']} to {values['largest']} {scale.unit}, {text}"
        return
    for side in SIDES:
        extreme = scale.factor * found[f"{kind}_extreme"].sel({**at, "side": side})
        text = (
            _extreme(extreme, basis[side]) if basis[side] in LAWS else reason(basis[side], values)
        )
        yield f"  {side} {values[side]}, {text}"


def mean_differs(found: xr.Dataset, kind: str, at: dict[str, str], scale: Scale) -> str:
    """A warning of a channel whose mean is by impulses, because records have another; else
    nothing."""
    recorded = found.get(f"{kind}_recorded_mean")
    other = np.nan if recorded is None else scale.factor * float(recorded.sel(at))
    return MEAN_DIFFERS.format(other, scale.unit) if np.isfinite(other) else ""


def _in_phases(found: xr.Dataset, name: str, unit: str) -> Iterator[str]:
    """Figures of a channel in each phase."""
    for group in found.contact_group.values if "named_phase" in found else ():
        for phase in found.phase.values:
            at = found.named_phase.sel(contact_group=group, phase=phase, channel=name)
            of = {str(k): float(at.sel(statistic=k)) for k in NAMES}
            if not np.isnan(of["mean"]):
                yield (
                    f"  {group} {phase}: mean {of['mean']:.4g}, std {of['std']:.4g},"
                    f" {of['smallest']:.4g} to {of['largest']:.4g} {unit}"
                )


def reason(basis: Basis, values: Mapping[str, object]) -> str:
    """Why a channel has no extremes; ``values`` are its figures, its unit and ``ramp``."""
    if basis == Basis.REGULAR:
        return "regular"
    return f"no extremes: {REASONS[basis].format(**values)}"


def _extreme(of: xr.DataArray, basis: Basis) -> str:
    at = {name: f"{float(of.sel(extreme=name)):.3f}" for name in FIGURES}
    return (
        f"most probable {at['mpm']} ({at['mpm_lower']} to {at['mpm_upper']}),"
        f" of another run {at['predicted_lower']} to {at['predicted_upper']}, by {NAMED[basis]}"
    )


def lines_of_runs(runs: xr.Dataset) -> Iterator[str]:
    """Of runs that differ in their seeds alone: between which values each motion is, and the
    smallest and largest value of another such run: by Gumbel's law over the runs, or where they do
    not follow it by their order."""
    for body in runs.body.values:
        for dof in runs.dof.values:
            scale = scale_of(str(dof))
            motion = scale.factor * runs.motion.sel(body=body, dof=dof).dropna("run", how="all")
            if motion.sizes["run"] == 0 or not float(motion.sel(statistic="std").max()) > 0.0:
                continue
            low, high = (motion.sel(statistic=side).values for side in SIDES)
            yield f"{body} {dof}: {low.min():.3f} to {high.max():.3f} {scale.unit}"
            if high.size >= RUNS:
                yield from _of_runs(low, high)
    yield from _stages(runs)


def _of_runs(low: np.ndarray, high: np.ndarray) -> Iterator[str]:
    """Of the smallest and of the largest value of each run, by Gumbel's law if they follow it."""
    for side, maxima, sign in zip(SIDES, (-low, high), (-1.0, 1.0), strict=True):
        if not np.ptp(maxima) > 0.0:
            continue
        law = fit_maxima(maxima)
        if follows_gumbel(maxima, law):
            yield f"  {side} of a run: {_by_gumbel(law, sign)}"
        else:
            yield f"  {side} of a run: {_by_order(maxima, sign)}"


def _by_gumbel(law: Gumbel, sign: float) -> str:
    ratio = exceeding(P90)
    probable = _between(law.confidence(1.0), sign)
    rare = _between(law.confidence(ratio), sign)
    another = _between(law.prediction(1.0), sign)
    return (
        f"most probable {sign * law.expected(1.0):.3f} ({probable}),"
        f" P90 {sign * law.expected(ratio):.3f} ({rare}), of another run {another}"
    )


def _by_order(maxima: np.ndarray, sign: float) -> str:
    """By order statistics: maxima that are of several kinds (with and without an impact), or that
    something holds, follow no law of extremes."""
    most_probable = np.exp(-1.0)
    probable = _between(find_confidence(maxima, most_probable), sign)
    rare = _between(find_confidence(maxima, P90), sign)
    held = find_prediction(maxima)
    another = _between((held.low, held.high), sign)
    more = "" if maxima.size >= ENOUGH else f"; {ENOUGH} runs hold 90 %"
    return (
        f"most probable {sign * np.quantile(maxima, most_probable):.3f} ({probable}),"
        f" P90 {sign * np.quantile(maxima, P90):.3f} ({rare}), of another run {another}"
        f" ({100.0 * held.probability:.0f} %{more}), by the order of {maxima.size} runs, which do"
        " not follow Gumbel's law"
    )


def _between(ends: Sequence[float] | np.ndarray, sign: float) -> str:
    """An interval of sign x: an end that is not known is said to be beyond what was seen."""
    low, high = np.sort(sign * np.asarray(ends))
    if np.isinf(high):
        return f"{low:.3f} or more, unknown by so few runs"
    if np.isinf(low):
        return f"{high:.3f} or less, unknown by so few runs"
    return f"{low:.3f} to {high:.3f}"


def _stages(runs: xr.Dataset) -> Iterator[str]:
    """Stages and figures of each group over runs: mean with its 90 % interval, and between which
    values they are."""
    for name in runs.contact_group.values if TIME in runs else ():
        of = runs.sel(contact_group=name)
        stages_ = {str(s): of[TIME].sel(stage=s) for s in of.stage.values}
        for what, each in {**stages_, **{OF_STAGES[f][0]: of[f] for f in OF_STAGES}}.items():
            known = each.values[np.isfinite(each.values)]
            if known.size and np.ptp(known) > 0.0:
                at, unit = spread(known), each.attrs["units"]
                yield (
                    f"{name} {what}: mean {at.mean:.5g} ({at.low:.5g} to {at.high:.5g}),"
                    f" {known.min():.5g} to {known.max():.5g} {unit}, in {known.size} runs"
                )


def _phases(found: xr.Dataset) -> Iterator[str]:
    for group in found.contact_group.values:
        for phase in found.phase.values:
            at = {"contact_group": group, "phase": phase}
            seconds = float(found.phase_duration.sel(at))
            for body in found.body.values if seconds > 0.0 else ():
                x, y = found.phase_crawl.sel({**at, "body": body}).values
                yield (
                    f"{group} {phase}: {seconds:.0f} s, {body} crawls {x:+.3f} m in x,"
                    f" {y:+.3f} m in y"
                )
