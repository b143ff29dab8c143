"""Models (pydantic) of study files: parameters, designs, seeds, criteria, limits of operation."""

from __future__ import annotations

import json
import re
from math import degrees
from typing import Annotated, Any, Literal, Self

import pydantic

from hydrosim.case.criteria import CONTACT_RESULTS, PHASE_NAMES, STATISTIC_NAMES, RunCriterion
from hydrosim.files import quantities as of
from hydrosim.files.units import AnyQuantity, Quantity, Scale, problem
from hydrosim.results.phases import STAGES
from hydrosim.statistics import results
from hydrosim.statistics.explain import EXPLAINED_PHASES, FRICTION_PARTS, WHOLE_RUN
from hydrosim.statistics.figures import STATISTICS, ScalarResult

# Limits of operation.

MAX_HEIGHTS = 1000
FULL_TURN_RAD = 6.2832  # rad


class Heights(of.SchemaModel):
    """Significant heights among which a limit is looked for: from the first to the last, so far
    ``apart``."""

    low: of.Length = pydantic.Field(alias="from")
    """Lowest significant height."""
    high: of.Length = pydantic.Field(alias="to")
    """Highest significant height."""
    apart: of.LineLength
    """Step between heights."""

    @pydantic.model_validator(mode="after")
    def _check_order(self) -> Self:
        if not 0.0 < self.low < self.high or self.high - self.low < self.apart:
            found_text = f"from {self.low:g} to {self.high:g} m, {self.apart:g} m apart"
            raise problem(found_text, "heights above zero that rise, two or more")
        if (self.high - self.low) / self.apart > MAX_HEIGHTS:
            count = (self.high - self.low) / self.apart
            raise problem(f"{count:,.0f} heights", f"{MAX_HEIGHTS:,} or fewer")
        return self

    def values(self) -> list[float]:
        """All heights [m]."""
        count = int((self.high - self.low) / self.apart + 1e-9) + 1
        return [self.low + k * self.apart for k in range(count)]


class SwellFile(of.SchemaModel):
    """A swell beside the wind sea: JONSWAP, with its own heading."""

    significant_height: of.Height
    """Significant height of the swell."""
    peak_period: of.Period
    """Peak period of the swell."""
    heading: of.Angle
    """Direction that the swell goes to."""


class Operation(of.SchemaModel):
    """What weather an operation needs: its ``planned`` time and the contingency, as long again if
    it is not given; factors of a table ``alpha`` by planned time and significant height."""

    planned: of.Period
    """Planned time of the operation."""
    contingency: of.Span | None = None
    """Contingency time. Without it as long as the planned time."""
    alpha: AlphaFile | None = None
    """Table of alpha factors."""


class AlphaFile(of.SchemaModel):
    """A table of alpha factors: ``source`` says which, with its edition; a row of ``factors`` for
    planned times up to each of ``planned``, a column for each of the ``heights`` of the limit."""

    source: pydantic.StrictStr
    """Document and edition that the factors are from. Example: Company standard 12, 2024."""
    planned: tuple[of.Period, ...]
    """Planned times that the rows go up to."""
    heights: tuple[of.Length, ...]
    """Significant heights of the columns."""
    factors: tuple[tuple[of.Factor, ...], ...]
    """A row of factors for each planned time."""

    @pydantic.model_validator(mode="after")
    def _check_sizes(self) -> Self:
        sizes = {len(row) for row in self.factors}
        if sizes != {len(self.heights)} or len(self.factors) != len(self.planned):
            raise problem(
                f"{len(self.factors)} rows of {', '.join(map(str, sorted(sizes)))} factors",
                f"{len(self.planned)} rows of {len(self.heights)}, as there are times and heights",
            )
        for values in (self.planned, self.heights):
            if list(values) != sorted(set(values)):
                raise problem(f"{', '.join(f'{v:g}' for v in values)}", "values that rise")
        if (most := max(max(row) for row in self.factors)) > 1.0:
            raise problem(f"a factor of {most:g}", "factors of 1 or less")
        return self


class Operability(of.SchemaModel):
    """In which seas the criteria hold with a ``probability``: heights, peak periods, headings, and
    swells beside; the weather that there is, in files, and the ``bearing`` of the x axis, clockwise
    from north, by which a hindcast's directions become headings."""

    heights: Heights
    """Significant heights among which the limit is looked for."""
    peak_periods: Annotated[tuple[of.Period, ...], pydantic.Field(min_length=1)]
    """Peak periods of the wind sea."""
    headings: tuple[of.Angle, ...] = ()
    """Directions that the wind sea goes to. Without them that of the case."""
    swells: tuple[SwellFile, ...] = ()
    """Swells beside the wind sea."""
    probability: Annotated[float, Quantity("probability", "", "90 %", above=0, at_most=0.999)] = 0.9
    """Probability with which criteria must hold."""
    scatter: pydantic.StrictStr | None = None
    """File with a scatter diagram of heights and periods. Example: scatter.csv."""
    hindcast: pydantic.StrictStr | None = None
    """File with a hindcast of seas over time. Example: hindcast.nc."""
    bearing: of.Angle | None = None
    """Compass bearing of the x axis, by which directions of the hindcast become headings."""
    operation: Operation | None = None
    """Time that the operation takes, for the wait for weather."""

    @pydantic.model_validator(mode="after")
    def _check_periods(self) -> Self:
        turned = [degrees(heading) for heading in self.headings]
        for name, values in (("peak_periods", self.peak_periods), ("headings", turned)):
            if list(values) != sorted(set(values)):
                found_text = f"{name} {', '.join(f'{v:g}' for v in values)}"
                raise problem(f"{found_text}{' deg' * (name == 'headings')}", "values that rise")
        if self.hindcast is not None and self.operation is None:
            raise problem("a hindcast and no operation", "operation: {planned: 24 hour}")
        if self.bearing is not None and abs(self.bearing) > FULL_TURN_RAD:
            found_text = f"a bearing of {degrees(self.bearing):g} deg"
            raise problem(found_text, "one within a turn; a number without a unit is in rad")
        if self.hindcast is None and self.bearing is not None:
            raise problem("a bearing and no hindcast", "hindcast: FILE, whose directions it turns")
        return self


SEED_SPAN = re.compile(r"(\d+)\s*-\s*(\d+)", re.ASCII)
SEEDS_EXPECTED = 'whole numbers from 0, as in 1-100 or [1, 5, 9]; or one, as in "7"'
MAX_SEEDS = 1_000_000


def _expand_seeds(value: Any) -> Any:
    """The numbers of "1-100", or of a single one."""
    if isinstance(value, int):
        return [value]
    span = SEED_SPAN.fullmatch(value.strip()) if isinstance(value, str) else None
    if span is not None and int(span[1]) <= int(span[2]) < int(span[1]) + MAX_SEEDS:
        return list(range(int(span[1]), int(span[2]) + 1))
    if span is not None and int(span[1]) > int(span[2]):
        found_text = f'"{value}", which runs backwards'
        raise problem(found_text, "the smaller seed first", f'write "{span[2]}-{span[1]}"')
    if isinstance(value, str):
        raise problem(f'"{value}"', f"{SEEDS_EXPECTED}; at most {MAX_SEEDS:,} of them")
    return value


def _check_distinct(values: tuple[Any, ...]) -> tuple[Any, ...]:
    texts = [json.dumps(value) for value in values]
    if not values or len(set(texts)) < len(texts):
        raise problem(f"[{', '.join(texts)}]", "one value or more, each once")
    return values


Seed = Annotated[pydantic.StrictInt, pydantic.Field(ge=0)]
Seeds = Annotated[
    tuple[Seed, ...],
    pydantic.AfterValidator(_check_distinct),
    pydantic.BeforeValidator(_expand_seeds, json_schema_input_type=Seed | str | tuple[Seed, ...]),
]
Values = Annotated[tuple[Any, ...], pydantic.AfterValidator(_check_distinct)]


class Range(of.SchemaModel):
    """From one value to another, all between equally likely, or all of their logarithms."""

    low: Any = pydantic.Field(alias="from")
    """Lower end of the range. Example: 100 kN."""
    high: Any = pydantic.Field(alias="to")
    """Upper end of the range. Example: 400 kN."""
    scale: Literal["linear", "logarithmic"] = "linear"
    """Whether all values are equally likely, or all logarithms of values."""


def _spread_tag(value: Any) -> str:
    return "range" if isinstance(value, dict) else "values"


Spread = Annotated[
    Annotated[tuple[Any, ...], pydantic.Tag("values")] | Annotated[Range, pydantic.Tag("range")],
    pydantic.Discriminator(_spread_tag),
]


class LinkedKeys(of.SchemaModel):
    """Keys of the case that are varied together, and what their values are called."""

    keys: Annotated[dict[pydantic.StrictStr, Spread], pydantic.Field(min_length=1)]
    """Values or ranges by key of the case. They change together."""
    called: tuple[pydantic.StrictStr, ...] | None = None
    """Names of the values, for tables and plots. Example: [soft, stiff]."""

    @pydantic.model_validator(mode="after")
    def _check_alike(self) -> Self:
        ranges = [isinstance(spread, Range) for spread in self.keys.values()]
        sizes = [len(spread) for spread in self.keys.values() if isinstance(spread, tuple)]
        sizes += [len(self.called)] if self.called is not None else []
        if len({*sizes}) > 1 or len({*ranges}) > 1:
            found_text = (
                f"{', '.join(map(str, sizes))} values{' and ranges' if any(ranges) else ''}"
            )
            raise problem(found_text, "as many for each key that is linked, and as many names")
        if not any(ranges):
            _check_distinct(tuple(zip(*self.keys.values(), strict=True)))
        return self


def _parameter_tag(value: Any) -> str:
    return "linked" if isinstance(value, dict) and "keys" in value else _spread_tag(value)


Parameter = Annotated[
    Annotated[Values, pydantic.Tag("values")]
    | Annotated[Range, pydantic.Tag("range")]
    | Annotated[LinkedKeys, pydantic.Tag("linked")],
    pydantic.Discriminator(_parameter_tag),
]


class DesignPlan(of.SchemaModel):
    """Parameters, keys of the case as with `--set` or names of what is linked, and how values of
    several are combined; of ranges, so many ``samples``, drawn with the seed ``random``."""

    parameters: dict[pydantic.StrictStr, Parameter] = pydantic.Field(default_factory=dict)
    """Values or ranges by key of the case, such as environment.waves.significant_height."""
    design: Literal["grid", "one_at_a_time", "latin_hypercube", "sobol", "sobol_indices"] = "grid"
    """How values of several parameters are combined."""
    samples: Annotated[pydantic.StrictInt, pydantic.Field(ge=2)] | None = None
    """Number of samples that are drawn from ranges. Example: 64."""
    random: Seed = 0
    """Number that samples are drawn with. Example: 5."""

    @pydantic.model_validator(mode="after")
    def _check_design(self) -> Self:
        drawn = self.design not in ("grid", "one_at_a_time")
        for name, parameter in self.parameters.items():
            spreads = parameter.keys.values() if isinstance(parameter, LinkedKeys) else [parameter]
            if any(isinstance(spread, Range) != drawn for spread in spreads):
                kind = "a list of values" if drawn else "a range"
                text = "a range, {from: .., to: ..}" if drawn else "a list of values"
                raise problem(f"{kind} for {name}", f"{text}, for the design {self.design}")
        if drawn and (self.samples is None or not self.parameters):
            raise problem("no samples or no parameters", f"both, for the design {self.design}")
        if self.design.startswith("sobol") and self.samples and self.samples & (self.samples - 1):
            raise problem(f"samples {self.samples}", "a power of two, for Sobol's sequence")
        return self


class OutputSettings(of.SchemaModel):
    """What is kept of each run: ``variables`` every ``step``; statistics from ``start`` [s] on,
    also of ``channels`` (patterns such as "clearance.*"); with ``impulses`` what `hydrosim show
    --why` says of it."""

    step: of.Period | None = None
    """Time between records that are kept. Without it that of the case."""
    impulses: pydantic.StrictBool | None = None
    """Whether the impulses that hydrosim show --why needs are kept."""
    variables: tuple[pydantic.StrictStr, ...] = ("position",)
    """Variables of each run that are kept. Example: [position]."""
    channels: tuple[pydantic.StrictStr, ...] = ()
    """Channels of each run that there are statistics of, or patterns. Example: [clearance.*]."""
    start: of.Instant = 0.0
    """Time from which statistics are taken."""


RESULT_NAMES = Literal[
    CONTACT_RESULTS,
    "time",
    "duration",
    "displacement",
    "mean_force",
    "friction",
    "time_share",
    "moved",
]
PART_NAMES = Literal[
    "stick", "direction of slip", "load with direction", "slip damping", "below mu_k N"
]
STAGE_NAMES = Literal[
    "whole run",
    "in contact",
    "moored",
    "initial contact",
    "compressed",
    "stuck",
    "first contact to 25% transferred",
    "25% transferred to 50% transferred",
    "50% transferred to 75% transferred",
    "75% transferred to 100% transferred",
    "100% transferred to open",
    "open to separated",
    "first contact",
    "25% transferred",
    "50% transferred",
    "75% transferred",
    "100% transferred",
    "open",
    "separated",
]
for names, keys in (
    (STATISTIC_NAMES, STATISTICS),
    (RESULT_NAMES, results.RESULT_KEYS),
    (PART_NAMES, FRICTION_PARTS),
    (STAGE_NAMES, results.ALL_STAGE_NAMES),
):
    assert set(names.__args__) == set(keys)  # type: ignore[attr-defined]


class OfChannel(of.SchemaModel):
    """A figure of each run: a statistic of a channel, over all times or in a phase."""

    channel: pydantic.StrictStr
    """Channel of the run. Example: position.barge.surge."""
    statistic: STATISTIC_NAMES
    """Statistic of the channel. Crawl is change, or change_absolute, of a position; end counts from
    the place at rest."""
    phase: PHASE_NAMES | None = None
    """Phase of the operation that the statistic is limited to."""

    def figure(self, name: str, start: float) -> ScalarResult:
        """The same, as what is computed of a run."""
        return ScalarResult(name, self.channel, self.statistic, self.phase, start)


class OfStages(of.SchemaModel):
    """A figure of each run: a result of the stages of its contacts, or of why a body moved. The
    other keys say of what it is; which of them a result takes depends on the result."""

    result: RESULT_NAMES
    """Result of stages, or of what hydrosim show --why says. Example: recontact_force."""
    group: pydantic.StrictStr | None = None
    """Group of contacts. Without it the only one. Example: legs."""
    stage: STAGE_NAMES | None = None
    """Stage that the result is of. Without it the whole run."""
    until: STAGE_NAMES | None = None
    """Stage at which a duration ends."""
    body: pydantic.StrictStr | None = None
    """Body that moves. Without it the only one. Example: barge."""
    direction: Literal["surge", "sway", "heave"] | None = None
    """Direction of a motion or a force. Without it surge."""
    force: pydantic.StrictStr | None = None
    """Force element, or row of forces, of a mean force. Example: interface."""
    part: PART_NAMES | None = None
    """Part of friction that has one cause. Without it all of them."""
    mode: Literal["open", "stick", "slip"] | None = None
    """Contact mode."""

    @pydantic.model_validator(mode="after")
    def _check_keys(self) -> Self:
        keys = results.RESULT_KEYS[self.result]
        given = {
            *self.keys_with_value("group", "stage", "until", "body", "direction", "force", "part")
        }
        given |= {*self.keys_with_value("mode")}
        if unknown := given - keys:
            found_text = f"{', '.join(sorted(unknown))} of the result {self.result}"
            raise problem(found_text, f"only: {', '.join(sorted(keys))}")
        if lacking := results.REQUIRED_KEYS.get(self.result, set()) - given:
            raise problem(f"the result {self.result} without {', '.join(lacking)}", "both")
        if self.stage is not None and self.stage not in (names := self._stages()):
            raise problem(f"the stage {self.stage} of {self.result}", f"one of: {', '.join(names)}")
        if self.result == "duration" and (self.stage in STAGES) != (self.until in STAGES):
            expected = (
                f"a phase ({', '.join(EXPLAINED_PHASES)}), or stage and until: {', '.join(STAGES)}"
            )
            raise problem(f"from {self.stage} until {self.until}", expected)
        return self

    def _stages(self) -> tuple[str, ...]:
        """The names of stages that the result may be of."""
        if self.result == "time":
            return STAGES
        return (*EXPLAINED_PHASES, *STAGES) if self.result == "duration" else results.SPAN_NAMES

    def figure(self, name: str, start: float) -> results.StageResult | results.MotionCauseResult:
        """The same, as what is computed of a run, from its start on."""
        if self.result in results.RESULTS_OF_CONTACTS:
            return results.StageResult(name, self.result, self.group, self.stage, self.until)
        return results.MotionCauseResult(
            name,
            self.result,
            self.stage or WHOLE_RUN,
            self.direction or "surge",
            self.body,
            self.force,
            self.group,
            self.part,
            self.mode,
        )


class Limited(of.SchemaModel):
    """What a figure may not exceed or, with ``side: at least``, not fall below: so are, without a
    word, the statistic "smallest" and the result "end_clearance"."""

    limit: Annotated[Scale, AnyQuantity("limit", "1 m")]
    """Limit that the figure must not exceed, or not fall below. Example: 5 MN."""
    side: Literal["at most", "at least"] | None = None
    """Side of the limit on which the figure holds it. Without it at least for the statistic
    smallest and the result end_clearance, and at most for others."""

    source: pydantic.StrictStr = ""
    """Where the limit comes from: a document and its clause. Example: Fender data sheet 7."""

    def is_lower_limit(
        self, figure: ScalarResult | results.StageResult | results.MotionCauseResult
    ) -> bool:
        """Whether the limit is the least that a figure may be."""
        return figure.at_least if self.side is None else self.side == "at least"


class ChannelCriterion(OfChannel, Limited):
    """A figure of a channel and its limit."""


class StageCriterion(OfStages, Limited):
    """A result of stages and its limit."""


def as_study_criterion(of: RunCriterion) -> ChannelCriterion | StageCriterion:
    """The criterion of a case as one of a study."""
    if of.result is not None:
        return StageCriterion.model_construct(
            result=of.result, group=of.group, limit=of.limit, source=of.source
        )
    return ChannelCriterion.model_construct(
        channel=of.channel,
        statistic=of.statistic,
        phase=of.phase,
        limit=of.limit,
        source=of.source,
    )


def _figure_tag(value: Any) -> str:
    """A tag that is no key of the file, so that messages leave it out of the place."""
    keys = value if isinstance(value, dict) else dir(value)
    return "of stages" if "result" in keys else "of a channel"


Asked = Annotated[
    Annotated[OfChannel, pydantic.Tag("of a channel")]
    | Annotated[OfStages, pydantic.Tag("of stages")],
    pydantic.Discriminator(_figure_tag),
]


class RequestedFigures(of.SchemaModel):
    """Figures of runs by name, apart from a study."""

    figures: dict[pydantic.StrictStr, Asked]
    """Figures of each run by name."""


Criterion = Annotated[
    Annotated[ChannelCriterion, pydantic.Tag("of a channel")]
    | Annotated[StageCriterion, pydantic.Tag("of stages")],
    pydantic.Discriminator(_figure_tag),
]


class SeedTarget(of.SchemaModel):
    """More seeds, up to ``most``, until the 90 % interval of the mean of a ``figure`` is at most
    so ``wide``, for all values of the parameters."""

    figure: pydantic.StrictStr
    """Name of the figure whose mean must be known well enough. Example: largest_surge."""
    wide: Annotated[Scale, AnyQuantity("width", "0.1 m", above=0.0)]
    """Largest width of the 90 % interval of its mean."""
    most: Annotated[pydantic.StrictInt, pydantic.Field(ge=2)] = 1000
    """Largest number of seeds. Example: 500."""


class StudyFile(DesignPlan):
    """A whole study file: one plan, or several ``studies`` by name, of one case and with the same
    seeds; ``figures`` of each run, to compare."""

    case: pydantic.StrictStr
    """Case file that is varied, relative to the study file. Example: ../base.yaml."""
    studies: dict[pydantic.StrictStr, DesignPlan] = pydantic.Field(default_factory=dict)
    """Several plans by name, in place of parameters."""
    seeds: Seeds | None = None
    """Seeds of the sea: 1-100, a list, or one number. Example: 1-100."""
    until: SeedTarget | None = None
    """Accuracy that more seeds are run for."""
    duration: of.Period | None = None
    """Length of each run, in place of that of the case."""
    output: OutputSettings = OutputSettings()
    """Results that are kept of each run."""
    figures: dict[pydantic.StrictStr, Asked] = pydantic.Field(default_factory=dict)
    """Figures of each run by name."""
    criteria: dict[pydantic.StrictStr, Criterion] = pydantic.Field(default_factory=dict)
    """Figures with limits by name."""
    operability: Operability | None = None
    """Seas in which limits of the operation are looked for."""

    @pydantic.model_validator(mode="before")
    @classmethod
    def _check_kind(cls, data: Any) -> Any:
        if isinstance(data, dict) and "bodies" in data:
            remedy = "run it by hydrosim run, or name it in a study: case: FILE.yaml"
            raise problem("a case, with the key bodies", "a study", remedy)
        return data

    @pydantic.model_validator(mode="after")
    def _check_plans(self) -> Self:
        if self.studies and self.parameters:
            raise problem("parameters and studies", "either one plan or several by name")
        if self.until is not None and self.seeds is None:
            raise problem("until without seeds", "the seeds to begin with, such as 1-8")
        return self

    def bounds(self) -> dict[str, tuple[str, Scale]]:
        """What figures are compared with: by key of the file, the figure's name and the bound."""
        limits = {
            f"criteria.{name}.limit": (name, criterion.limit)
            for name, criterion in self.criteria.items()
        }
        until = self.until
        return limits | ({} if until is None else {"until.wide": (until.figure, until.wide)})

    def plans(self) -> dict[str, DesignPlan]:
        """All plans by name; that of a file with one has none."""
        return self.studies or {"": self}
