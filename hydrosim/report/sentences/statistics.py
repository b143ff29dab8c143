"""Tables of statistics: moments, extremes, contacts, crawl; first results; runs over seeds."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydrosim.files import document_nodes
from hydrosim.files.display_units import unit_of_dof, units_of
from hydrosim.files.document import Document
from hydrosim.files.document_layout import text_of, value_text
from hydrosim.report.sentences import run as run_sentences
from hydrosim.report.sentences.sections import MAX_TABLE_ROWS, lines_of, table_of, title_of
from hydrosim.results import phases
from hydrosim.results.variables import TENSIONS
from hydrosim.statistics import over_seeds
from hydrosim.statistics.effects import PlanRuns, combinations, seed_spread
from hydrosim.statistics.extremes import LAWS, ExtremeModel
from hydrosim.statistics.gumbel import INTERVAL_PROBABILITY, VALUES_FOR_INTERVAL
from hydrosim.statistics.statistics import (
    CHANNEL_VARIABLES,
    EXTREME_SIDES,
    statistics,
)

if TYPE_CHECKING:
    import xarray as xr

# Channels in statistics: names and units.


class StatisticsChannel(NamedTuple):
    """A channel in ``statistics``: the ``kind`` of variables, the labels ``at`` which it stands
    there, what it is called, and its SI unit."""

    statistics: xr.Dataset
    kind: str
    at: dict[str, str]
    title: str
    unit: str

    def _number(self, suffix: str, **labels: str) -> float:
        """A number of the variable of its kind with a ``suffix``."""
        return float(self.statistics[self.kind + suffix].sel(self.at | labels))

    def figure(self, name: str) -> document_nodes.Value:
        """A figure by its name among `statistics.STATISTIC_NAMES`."""
        number = self._number("", statistic=name)
        return document_nodes.Value(number, "s" if name == "period" else self.unit)

    def basis(self, side: str) -> ExtremeModel:
        """What the extremes of a side are by, or why there are none."""
        return ExtremeModel(int(self._number("_basis", side=side)))

    def extreme(self, side: str, name: str) -> document_nodes.Value:
        """A figure of the extremes of a side."""
        return document_nodes.Value(self._number("_extreme", side=side, extreme=name), self.unit)

    def interval(self, side: str, name: str) -> document_nodes.Between:
        """The interval of a figure of the extremes of a side."""
        low, high = (self.extreme(side, f"{name}_{end}") for end in ("lower", "upper"))
        return document_nodes.Between(low.number, high.number, self.unit)

    def recorded_mean(self) -> document_nodes.Value:
        """The mean of the records, where that by impulses is another; else not a number."""
        recorded = self.statistics.get(f"{self.kind}_recorded_mean")
        number = float("nan") if recorded is None else float(recorded.sel(self.at))
        return document_nodes.Value(number, self.unit)


def channels_of(statistics: xr.Dataset) -> Iterator[StatisticsChannel]:
    """The channels of statistics that vary: motions, waves, contacts, lines, those by name."""
    for channel in _all_channels(statistics):
        if ExtremeModel.CONSTANT not in {channel.basis(side) for side in EXTREME_SIDES}:
            yield channel


def _all_channels(statistics: xr.Dataset) -> Iterator[StatisticsChannel]:
    for body in map(str, statistics.body.values):
        for dof in map(str, statistics.dof.values):
            yield StatisticsChannel(
                statistics, "motion", {"body": body, "dof": dof}, f"{body} {dof}", unit_of_dof(dof)
            )
    if "wave" in statistics:
        yield StatisticsChannel(statistics, "wave", {}, "wave elevation", "m")
    for force, dim in over_seeds.FORCE_DIMS.items():
        for name in map(str, statistics[dim].values if force in statistics else ()):
            yield StatisticsChannel(statistics, force, {dim: name}, f"force of {name}", "N")
    for name in map(str, statistics.channel.values if "channel" in statistics.dims else ()):
        unit = str(statistics.unit.sel(channel=name).item())
        yield StatisticsChannel(statistics, "named", {"channel": name}, name, unit)


MIN_SAMPLES = 16
"""Records that figures are made of."""
PHASE_FIGURES = ("mean", "std", "smallest", "largest")
MOMENTS = ("mean", "std", "significant", "period", "smallest", "largest")
LAW_NAMES = {
    ExtremeModel.GAUSSIAN: "a Gaussian process",
    ExtremeModel.CLIPPED_GAUSSIAN: "a clipped Gaussian process",
    ExtremeModel.GUMBEL: "Gumbel's law",
    ExtremeModel.IMPACTS: "impacts of exponential sizes",
}
SEEDS_HINT = f"run {VALUES_FOR_INTERVAL} seeds"
STATISTICS_METHOD_NOTE = (
    f"To run {VALUES_FOR_INTERVAL} seeds, write a study file with `case: CASE.yaml` and"
    f" `seeds: 1-{VALUES_FOR_INTERVAL}`. Then call `hydrosim study STUDY.yaml`. The smallest and"
    f" the largest of {VALUES_FOR_INTERVAL} runs hold the value of another run in 90 % of cases."
)
STATIONARY_HINT = "use a part that is stationary (--from)"
REASONS: dict[ExtremeModel, tuple[str, tuple[str, ...]]] = {
    ExtremeModel.REGULAR: ("The motion is regular: it repeats itself.", ()),
    ExtremeModel.CLIPPED: ("It stays at its bound for much of the time.", ()),
    ExtremeModel.TOO_SHORT: (
        "The record is too short for the slow part of it, or not stationary: the mean goes from {}"
        " to {} (first and last fifth). Simulate longer.",
        ("first_mean", "last_mean"),
    ),
    ExtremeModel.RARE: (f"There is too little contact. Simulate longer, or {SEEDS_HINT}.", ()),
    ExtremeModel.MEAN_CHANGES: (
        "It is not stationary: the mean goes from {} to {} (first and last fifth). Either"
        f" {STATIONARY_HINT}, or {SEEDS_HINT}.",
        ("first_mean", "last_mean"),
    ),
    ExtremeModel.STD_CHANGES: (
        "It is not stationary: the standard deviation goes from {} to {} (first and last fifth), or"
        f" changes in between. Either {STATIONARY_HINT}, or {SEEDS_HINT}.",
        ("first_std", "last_std"),
    ),
    ExtremeModel.WAVES_GROW: (
        "It is not stationary: the waves grow until {ramp:g} s. Start there (--from {ramp:g}).",
        (),
    ),
    ExtremeModel.OPERATION: (
        "It is not stationary: contact goes through phases while other channels change. Either"
        f" {STATIONARY_HINT}, or {SEEDS_HINT}.",
        (),
    ),
    ExtremeModel.ALONE: (
        "The largest values follow another law than the rest (impacts?), and are too few for a law"
        f" of their own. Simulate longer, or {SEEDS_HINT}.",
        (),
    ),
    ExtremeModel.HALVES: (
        "A law that holds for one half of the record makes the largest value of the other half"
        f" impossible (impacts, a change?). Instead, {SEEDS_HINT}.",
        (),
    ),
    ExtremeModel.BOUNDED: (
        "Its slow part moves between bounds; no law of extremes covers that."
        f" Instead, {SEEDS_HINT}.",
        (),
    ),
    ExtremeModel.CURVED: (
        "Its highest crests follow none of the laws (a contact that carries a weight again and"
        f" again?). Instead, {SEEDS_HINT}.",
        (),
    ),
    ExtremeModel.TRANSIENT: (
        "It is larger at the beginning than later (a start-up transient). Start later (--from).",
        (),
    ),
    ExtremeModel.NOT_FINITE: ("It is not finite.", ()),
}
"""Why a channel has no extremes: a text, and the figures in its places."""
CHATTER_NOTE = (
    "{}: this mean is by impulses; the mean of the records is {}. The force changes between"
    " records. If it chatters from step to step, use a smaller solver.step, dopri5 or esdirk4. If"
    " it knocks, use a smaller output.step."
)


def statistics_document(run: xr.Dataset, statistics: xr.Dataset) -> Document:
    """The ``statistics`` of a run."""
    nodes = [*figures(statistics), *line_nodes(statistics), *contact_nodes(statistics)]
    return Document(title_of(run), nodes, units=units_of(run.attrs))


def line_nodes(statistics: xr.Dataset) -> document_nodes.Nodes:
    """Tensions of lines at the start of the run, and how much of their capacities they use."""
    rows: list[document_nodes.Row] = []
    for start in (f"{dim}_start" for dim in TENSIONS if f"{dim}_start" in statistics):
        tensions = statistics[start]
        shares = statistics.get(f"{tensions.dims[0]}_used", np.nan * tensions)
        for tension, share in zip(tensions, shares, strict=True):
            used = document_nodes.Value(float(share), "share", 3) if np.isfinite(share) else ""
            name = str(tension[tensions.dims[0]].values)
            rows.append([name, document_nodes.Value(float(tension), "N"), used])
    if rows:
        head = ("line", "tension at the start", "largest of capacity")
        yield document_nodes.Table(head, rows, "Tensions over the whole run")


def statistics_of(run: xr.Dataset) -> xr.Dataset | None:
    """Statistics of a run from where its waves have grown; None where it has too few records."""
    return statistics(run, ramp_end(run)) if has_statistics(run) else None


def statistics_nodes(run: xr.Dataset, statistics: xr.Dataset | None) -> document_nodes.Nodes:
    """What `statistics_of` a run gave."""
    if statistics is None:
        yield document_nodes.Sentence("The run has too few finite records for statistics.")
        return
    if start := ramp_end(run):
        yield document_nodes.Sentence(
            "Figures start at {}, when the waves have grown.", [document_nodes.Value(start, "s")]
        )
    yield from figures(statistics)
    yield from contact_nodes(statistics)


def figures(statistics: xr.Dataset) -> document_nodes.Nodes:
    """Moments of each channel that varies, its extremes, and why there are none."""
    every_channel = list(channels_of(statistics))
    channels = list(_channels_once(every_channel))
    yield from _mean_verdicts(channels)
    moments = [_moment_cells(channel) for channel in channels]
    yield document_nodes.Table(("channel", *MOMENTS), moments)
    yield document_nodes.Sentence(
        "Significant is the double amplitude, four standard deviations. The period is the mean"
        " between upcrossings.",
        detail=True,
    )
    rows = [row for channel in channels for row in _extreme_rows(channel)]
    if rows:
        percent = 100.0 * statistics.motion_extreme.attrs["interval_probability"]
        yield document_nodes.Sentence(
            f"Extremes in {{}}, with {percent:.0f} % intervals: of the most probable extreme, and"
            " of the extreme of another run.",
            [document_nodes.Value(float(statistics.attrs["exposure"]), "s", 6)],
        )
        head = ("channel", "side", "observed", "most probable", "interval", "another run", "law")
        yield document_nodes.Table(head, rows)
    if without := list(_reasons_without_extremes(channels)):
        yield document_nodes.List(without, "No extremes:")
        if any(SEEDS_HINT in item.text for item in without):
            yield document_nodes.Sentence(STATISTICS_METHOD_NOTE)
    yield from _describe_phases(statistics, every_channel)


def _channels_once(channels: Sequence[StatisticsChannel]) -> Iterator[StatisticsChannel]:
    """The channels without those that were also asked for by name."""
    requested = {channel.title for channel in channels if channel.kind not in CHANNEL_VARIABLES}
    for channel in channels:
        variable = CHANNEL_VARIABLES.get(channel.kind, (channel.kind,))[0]
        if ".".join((variable, *channel.at.values())) not in requested:
            yield channel


def contact_nodes(statistics: xr.Dataset) -> document_nodes.Nodes:
    """Stages of groups of contacts, the share of time in each mode, crawl by phase."""
    if "contact_group" not in statistics.dims:
        return
    yield from run_sentences.stage_nodes(statistics)
    if "fender_share" in statistics:
        shares, modes = statistics.fender_share, map(str, statistics["mode"].values)
        columns = {mode: (shares.sel(mode=mode), "share", 3) for mode in modes}
        columns["slipped"] = (statistics.fender_slipped, "m", 4)
        yield table_of("contact", columns, "Share of time in each contact mode")
    if rows := list(_phase_rows(statistics)):
        head = ("group", "phase", "duration", "body", "crawl in x", "crawl in y")
        yield document_nodes.Table(head, rows, "Crawl by phase")


def has_statistics(run: xr.Dataset) -> bool:
    """Whether a run has enough finite records for figures."""
    return run.time.size >= MIN_SAMPLES and bool(np.isfinite(run.position).all())


def ramp_end(run: xr.Dataset) -> float:
    """The time from which the waves have grown [s], if that is well before the end; else 0."""
    ramp = float(run.attrs.get("wave_ramp", 0.0))
    first, last = run.time.values[[0, -1]]
    return ramp if first < ramp < 0.5 * (first + last) else 0.0


def _mean_verdicts(channels: Sequence[StatisticsChannel]) -> document_nodes.Nodes:
    """Warnings of channels whose records have another mean than their impulses."""
    for channel in channels:
        recorded = channel.recorded_mean()
        if np.isfinite(recorded.number):
            yield document_nodes.warning(CHATTER_NOTE, [channel.title, recorded])


def _moment_cells(channel: StatisticsChannel) -> document_nodes.Row:
    return [channel.title, *(channel.figure(name) for name in MOMENTS)]


def _extreme_rows(channel: StatisticsChannel) -> Iterator[document_nodes.Row]:
    for side in EXTREME_SIDES:
        basis = channel.basis(side)
        if basis in LAWS:
            yield [
                channel.title,
                side,
                channel.figure(side),
                channel.extreme(side, "mpm"),
                channel.interval(side, "mpm"),
                channel.interval(side, "predicted"),
                LAW_NAMES[basis],
            ]


def _reasons_without_extremes(
    channels: Sequence[StatisticsChannel],
) -> Iterator[document_nodes.Sentence]:
    """Why channels have no extremes: those that have the same reason together."""
    names: dict[document_nodes.Sentence, list[str]] = {}
    for channel in channels:
        bases = {side: channel.basis(side) for side in EXTREME_SIDES}
        for side, basis in bases.items():
            if basis not in LAWS:
                reason = _reason_sentence(channel, basis)
                names.setdefault(reason, []).append(f"{channel.title}, {side}")
    for reason, channel_names in names.items():
        told = ", ".join(_both_sides(channel_names))
        yield document_nodes.Sentence(f"{{}}: {reason.text}", [told, *reason.parts])


def _both_sides(names: Sequence[str]) -> Iterator[str]:
    """Channels with their sides; without, where both sides are among the names."""
    titles = {name: name.rpartition(", ")[0] for name in names}
    several = Counter(titles.values())
    yield from dict.fromkeys(
        t if several[t] == len(EXTREME_SIDES) else name for name, t in titles.items()
    )


def _reason_sentence(channel: StatisticsChannel, basis: ExtremeModel) -> document_nodes.Sentence:
    text, names = REASONS[basis]
    text = text.replace("{ramp:g}", f"{float(channel.statistics.attrs['wave_ramp']):g}")
    return document_nodes.Sentence(text, tuple(channel.figure(name) for name in names))


def _describe_phases(
    statistics: xr.Dataset, channels: Sequence[StatisticsChannel]
) -> document_nodes.Nodes:
    """Figures of the channels that were asked for by name, in each phase."""
    if "named_phase" not in statistics:
        return
    rows: list[document_nodes.Row] = []
    for channel in (channel for channel in channels if channel.kind == "named"):
        for group in _groups_in_operation(statistics):
            for phase in map(str, statistics.phase.values):
                at = statistics.named_phase.sel(contact_group=group, phase=phase, **channel.at)
                figures = at.sel(statistic=list(PHASE_FIGURES)).values
                if not np.isnan(figures[0]):
                    values = document_nodes.value_cells(figures, channel.unit)
                    rows.append([channel.title, group, phase, *values])
    if rows:
        yield document_nodes.Table(("channel", "group", "phase", *PHASE_FIGURES), rows)


def _groups_in_operation(statistics: xr.Dataset) -> list[str]:
    """The groups of contacts that go through an operation, whose phases are told."""
    if "phase_duration" not in statistics:
        return []
    groups = map(str, statistics.contact_group.values)
    lasting = {
        group: statistics.phase_duration.sel(contact_group=group).values > 0.0 for group in groups
    }
    return [group for group, lasts in lasting.items() if phases.is_operation(np.flatnonzero(lasts))]


def _phase_rows(statistics: xr.Dataset) -> Iterator[document_nodes.Row]:
    for group in _groups_in_operation(statistics):
        for phase in map(str, statistics.phase.values):
            at = statistics.sel(contact_group=group, phase=phase)
            seconds = float(at.phase_duration)
            for body in map(str, statistics.body.values if seconds > 0.0 else ()):
                crawl = at.phase_crawl.sel(body=body).values
                moved = document_nodes.value_cells(crawl, "m", 3)
                yield [group, phase, document_nodes.Value(seconds, "s"), body, *moved]


# First results of a report: criteria, the end of the run, the sea, loads, largest values.

NO_CRITERIA = "The case asks for no criteria."
CRITERIA_HINT = "Limits with their sources under `criteria:` in the case are judged in the results."
ONE_SEA = (
    "These results are of one sea: one draw of random waves (seed {}). In another draw of the same"
    " spectrum, largest values, crawl and criteria come out otherwise. Decide on several draws."
)
MORE_SEAS = (
    f"For several draws, run a study with `seeds: 1-{VALUES_FOR_INTERVAL}` by"
    " `hydrosim study`. It judges the same limits over all of its seas."
)
WARNINGS_HINT = '{} under "Assumptions and warnings". Read {} before you use the results.'


def main_results(run: xr.Dataset, case: Mapping[str, Any]) -> document_nodes.Nodes:
    """Criteria met or not, how the run ended, for which sea, what is doubtful, and which loads are
    too large."""
    yield from list(run_sentences.criteria_nodes(run)) or [document_nodes.Sentence(NO_CRITERIA)]
    yield run_sentences.status_verdict(run)
    if _is_of_random_waves(case):
        drawn = np.unique(np.atleast_1d(run.attrs.get("seeds", [])))
        yield document_nodes.Sentence(ONE_SEA, [", ".join(map(str, drawn))])
    yield from (
        verdict
        for verdict in run_sentences.solution_verdicts(run)
        if verdict.outcome is not document_nodes.Outcome.GOOD
    )
    yield from run_sentences.element_verdicts(run)
    if count := len(lines_of(run, "warnings")):
        words = ("A warning is", "it") if count == 1 else (f"{count} warnings are", "them")
        yield document_nodes.warning(WARNINGS_HINT, words)


def next_steps(run: xr.Dataset, case: Mapping[str, Any]) -> document_nodes.Nodes:
    """Criteria and seeds that the run lacks, and how to have them."""
    if not list(run_sentences.criteria_nodes(run)):
        yield document_nodes.Sentence(CRITERIA_HINT)
    if _is_of_random_waves(case):
        yield document_nodes.Sentence(MORE_SEAS)


def _is_of_random_waves(case: Mapping[str, Any]) -> bool:
    """Whether waves or gusts of a case are drawn at random."""
    water = case.get("environment") or {}
    gusts = (water.get("wind") or {}).get("gusts")
    return bool(gusts) or any("seed" in train for train in water.get("waves") or [])


def largest_values(statistics: xr.Dataset) -> document_nodes.Nodes:
    """The extreme of each channel on the side that is further from zero."""
    rows = [_largest_cells(channel) for channel in channels_of(statistics)]
    head = ("channel", "largest seen", "most probable", "90 % interval", "another run")
    yield document_nodes.Table(head, rows, "Largest values")
    yield document_nodes.Sentence(
        "The most probable largest value and the intervals are extremes of such a run. Channels"
        " without them are not stationary: the statistics say why."
    )


def _largest_cells(channel: StatisticsChannel) -> document_nodes.Row:
    side = max(EXTREME_SIDES, key=lambda side: abs(channel.figure(side).number))
    seen = channel.figure(side)
    if channel.basis(side) not in LAWS:
        return [channel.title, seen, "", "", ""]
    likely = channel.extreme(side, "mpm")
    return [
        channel.title,
        seen,
        likely,
        *(channel.interval(side, of) for of in ("mpm", "predicted")),
    ]


# Runs that differ in their seeds alone: ranges of motions, extremes of channels.

MAX_COMBINATIONS = 5
"""Combinations of parameters that are shown."""
CLEARANCE_FIGURE = phases.FIGURES["end_clearance"][0]
"""The only result of stages that may be negative."""
VARIED_COORDINATE = "varied"
"""Coordinate of runs: the parameter that is varied, one at a time."""
EXTREMES_METHOD_NOTE = (
    f"Intervals hold 90 %, over {over_seeds.MIN_RUNS} seeds or more. Where maxima"
    " follow Gumbel's law they are"
    " by it; else by the order of the runs, without a law."
)


def seed_nodes(plan: PlanRuns) -> document_nodes.Nodes:
    """Extremes over the seeds of each combination of the parameters of a plan without figures."""
    yield document_nodes.Sentence(EXTREMES_METHOD_NOTE, detail=True)
    plan_combinations = list(combinations(plan))
    for values, at in plan_combinations[:MAX_COMBINATIONS]:
        of = plan.runs.isel(run=at)
        title = named_values(plan, values)
        yield from nodes_over_seeds(of, f"{title or 'All'}: {at.size} runs")
    if len(plan_combinations) > MAX_COMBINATIONS:
        more = str(len(plan_combinations) - MAX_COMBINATIONS)
        yield document_nodes.Sentence("{} more combinations are in motion, in the file.", [more])


def extreme_nodes(plan: PlanRuns) -> document_nodes.Nodes:
    """Extremes over the seeds of figures, and of every other channel of the file."""
    plan_combinations = list(combinations(plan))
    if max((at.size for _, at in plan_combinations), default=0) < over_seeds.MIN_RUNS:
        text = "Most probable extremes and P90 over seeds take {} seeds or more."
        yield document_nodes.Sentence(text, [str(over_seeds.MIN_RUNS)], detail=True)
        return
    figures: list[document_nodes.Row] = []
    channels: list[document_nodes.Row] = []
    for k, (values, at) in enumerate(plan_combinations):
        of = plan.runs.isel(run=at)
        name = named_values(plan, values) or "all"
        figures += [
            [name, *row]
            for row in _extremes_over_runs(over_seeds.ends_of_figures(of, plan.figures))
        ]
        if k < MAX_COMBINATIONS:
            channels += [
                [name, *row]
                for row in _extremes_over_runs(
                    [*over_seeds.ends_of_motions(of), *over_seeds.ends_of_channels(of)]
                )
            ]
    yield from _extreme_tables("figure", figures, of=True)
    yield from _extreme_tables("channel", channels, of=True, detail=True)
    if figures or channels:
        yield document_nodes.Sentence(EXTREMES_METHOD_NOTE, detail=True)


def _extreme_tables(
    what: str, rows: list[document_nodes.Row], of: bool = False, detail: bool = False
) -> document_nodes.Nodes:
    """Two tables of extremes, of rows that begin with a name and a side; with ``of``, with what
    they are of before these."""
    if not rows:
        return
    begin = (*(("of",) if of else ()), what, "side")
    n = len(begin)
    title = "The most probable extreme of a run, and where the extreme of another run lies"
    head = (*begin, "most probable", "interval", "another run")
    yield document_nodes.Table(head, [row[: n + 3] for row in rows[:MAX_TABLE_ROWS]], title, detail)
    title = "P90: 90 % of runs do not exceed this largest value, or do not fall below this smallest"
    shortened = [[*row[:n], *row[n + 3 :]] for row in rows[:MAX_TABLE_ROWS]]
    yield document_nodes.Table((*begin, "P90", "interval", "by"), shortened, title, detail)


def nodes_over_seeds(runs: xr.Dataset, title: str = "") -> document_nodes.Nodes:
    """Between which values each motion is, extremes of another run, stages over runs."""
    head = ("motion", "smallest", "largest")
    moving = list(over_seeds.ends_of_motions(runs))
    ends: list[document_nodes.Row] = [
        [
            motion.name,
            document_nodes.Value(np.min(motion.low), motion.unit),
            document_nodes.Value(np.max(motion.high), motion.unit),
        ]
        for motion in moving
        if motion.low is not None and motion.high is not None
    ]
    yield document_nodes.Table(head, ends, title)
    yield from _extreme_tables(
        "channel", _extremes_over_runs([*moving, *over_seeds.ends_of_channels(runs)])
    )
    if stages := list(_stage_rows(runs)):
        yield document_nodes.Table(
            ("stage or figure", "group", "mean", "interval", "all runs", "runs"), stages
        )


def named_values(plan: PlanRuns, values: Mapping[str, object]) -> str:
    """The values of the parameters of runs, in the units that they are read in; of one parameter at
    a time, the one that is varied."""
    varied = str(values.get(VARIED_COORDINATE, ""))
    if VARIED_COORDINATE in values and not varied:
        return "the case"
    names = [plan.axis(varied)] if varied else [*values]
    units = units_of(plan.runs.attrs)
    read = {name: text_of(value_of(values[name], plan.unit(name)), units) for name in names}
    return ", ".join(f"{short_key(name)} {value}" for name, value in read.items())


def short_key(name: str) -> str:
    """The last two words of a key."""
    return " ".join(name.split(".")[-2:]).replace("_", " ")


def value_of(value: object, unit: str) -> document_nodes.Value | str:
    """A value of a parameter: a number in its unit, or words."""
    return document_nodes.Value(value, unit, 6) if isinstance(value, float) else value_text(value)


def _extremes_over_runs(
    ends: Iterable[over_seeds.SmallestAndLargest],
) -> list[document_nodes.Row]:
    """Extremes of channels that enough runs have values of."""
    return [row for ends in ends for row in _rows_over_seeds(ends)]


def _rows_over_seeds(ends: over_seeds.SmallestAndLargest) -> Iterator[document_nodes.Row]:
    """Of the smallest and of the largest value of each run."""
    for side, extreme in over_seeds.find_extremes(ends):
        yield [ends.name, side, *_extreme_cells(extreme, ends.unit)]


def _extreme_cells(extreme: over_seeds.SeedExtremes, unit: str) -> document_nodes.Row:
    return [
        document_nodes.Value(extreme.probable, unit),
        document_nodes.Between(*extreme.interval, unit),
        document_nodes.Between(*extreme.another, unit),
        document_nodes.Value(extreme.p90, unit),
        document_nodes.Between(*extreme.p90_interval, unit),
        _method_text(extreme),
    ]


def _method_text(extreme: over_seeds.SeedExtremes) -> str:
    """The law, or the order of the runs and what their interval of another run holds."""
    if extreme.method == over_seeds.GUMBEL_METHOD:
        return over_seeds.GUMBEL_METHOD
    held = f"interval of another run holds {100.0 * extreme.probability:.0f} %"
    more = (
        ""
        if extreme.probability >= INTERVAL_PROBABILITY
        else f"; with {VALUES_FOR_INTERVAL} runs it would hold 90 %"
    )
    return f"{extreme.method} ({held}{more})"


def _stage_rows(runs: xr.Dataset) -> Iterator[document_nodes.Row]:
    """Stages and figures of each group over runs: mean with its interval, and their range."""
    for name in runs.contact_group.values if phases.STAGE_TIME in runs else ():
        of = runs.sel(contact_group=name)
        stages = {str(s): of[phases.STAGE_TIME].sel(stage=s) for s in of.stage.values}
        for what, values in {
            **stages,
            **{phases.FIGURES[f][0]: of[f] for f in phases.FIGURES},
        }.items():
            finite = values.values[np.isfinite(values.values)]
            if finite.size and np.ptp(finite) > 0.0:
                at = seed_spread(finite, -np.inf if what == CLEARANCE_FIGURE else 0.0)
                unit = str(values.attrs["units"])
                ends = (
                    document_nodes.Between(at.low, at.high, unit),
                    document_nodes.Between(finite.min(), finite.max(), unit),
                )
                yield [
                    what,
                    str(name),
                    document_nodes.Value(at.mean, unit),
                    *ends,
                    str(finite.size),
                ]
