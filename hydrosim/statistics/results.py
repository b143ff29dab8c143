"""Results of a run that are no channel over time: contact statistics, stages, causes of motion.

A study may ask for results by name, as a figure or as a criterion.

    {result: recontact_force, group: legs}
    {result: time, stage: separated, group: legs}
    {result: mean_force, force: interface, direction: surge, stage: in contact}
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from hydrosim.errors import InputError
from hydrosim.files.messages import suggestion
from hydrosim.files.yaml_nodes import with_hint
from hydrosim.results import phases
from hydrosim.results.phases import STAGE_TIME, STAGES, Phase
from hydrosim.results.variables import quantity_attributes
from hydrosim.statistics import explain

if TYPE_CHECKING:
    import xarray as xr

# Contact and friction in a run: time in each mode, slip, crawl by phase.

AVERAGING_TIME = 60.0  # s: the position is averaged over this time at both ends of a phase


def contact_statistics(run: xr.Dataset) -> dict[str, xr.DataArray]:
    """Time fraction in each mode and slip of each fender. For each group of fenders, time fraction
    of each phase, and crawl of each body in it."""
    import xarray as xr  # slow to load

    modes, phase = run.fender_mode, run.contact_phase.transpose("contact_group", "time").values
    names = modes.attrs["flag_meanings"].split()
    share = np.array([(modes.values == k).mean(axis=0) for k in range(len(names))])
    crawl = [[_displacement_during(run, of == phase) for phase in Phase] for of in phase]
    durations = phase_durations(run)
    phases = {name: durations[name] for name in durations.dims}
    return {
        "fender_share": xr.DataArray(
            share,
            {"mode": names, "fender": run.fender},
            ("mode", "fender"),
            attrs=quantity_attributes("fraction of the time", "1"),
        ),
        "fender_slipped": run.fender_slip_distance.isel(time=-1, drop=True).assign_attrs(
            quantity_attributes("distance slipped", "m")
        ),
        "phase_duration": durations,
        "phase_crawl": xr.DataArray(
            np.array(crawl),
            {**phases, "body": run.body, "axis": ["x", "y"]},
            (*phases, "body", "axis"),
            attrs=quantity_attributes(
                "slow displacement from the beginning to the end of the phase", "m"
            ),
        ),
    }


def phase_durations(run: xr.Dataset) -> xr.DataArray:
    """How long each group of contacts is in each phase [s] (contact_group, phase)."""
    import xarray as xr  # slow to load

    phase = run.contact_phase.transpose("contact_group", "time").values
    span = np.ptp(run.time.values)
    time = np.array([[np.mean(of == phase) * span for phase in Phase] for of in phase])
    names = [phase.name.lower().replace("_", " ") for phase in Phase]
    phases = {"contact_group": run.contact_group, "phase": names}
    return xr.DataArray(time, phases, tuple(phases), attrs=quantity_attributes("duration", "s"))


def crawl(run: xr.Dataset) -> xr.DataArray:
    """Path length of the contact nodes (time, fender, axis) since the start [m]. While open, a node
    stays at the point of last contact; NaN before the first contact."""
    node = run.fender_node.transpose("time", "fender", "axis")
    gone = node.values - node.values[0]
    rows = np.arange(run.sizes["time"])[:, None]
    touches = run.fender_mode.transpose("time", "fender").values > 0
    last = np.maximum.accumulate(np.where(touches, rows, -1))
    held = np.take_along_axis(gone, np.maximum(last, 0)[:, :, None], axis=0)
    held[last < 0] = np.nan
    return node.copy(data=held)


def _displacement_during(run: xr.Dataset, during: np.ndarray) -> np.ndarray:
    """Displacement (nb, 2) in x and y of the averaged position, from the beginning to the end of a
    phase."""
    place = run.position.transpose("time", "body", "dof").values[:, :, :2]
    if not during.any():
        return np.zeros(place.shape[1:])
    at = np.flatnonzero(during)[[0, -1]]
    width = max(round(0.5 * AVERAGING_TIME / float(np.diff(run.time.values[:2])[0])), 1)
    ends = [place[max(k - width, 0) : k + width + 1].mean(axis=0) for k in at]
    return np.asarray(ends[1] - ends[0])


TIME_RESULTS = ("time", "duration")
"""Results that are a time: what never comes is later than any limit."""
RESULTS_OF_CONTACTS = {**{name: {"group"} for name in phases.FIGURES}, "time": {"group", "stage"}}
RESULTS_OF_CONTACTS["duration"] = {"group", "stage", "until"}
LARGEST_RESULTS = ("closing_speed", "largest_contact_force", "recontact_speed", "recontact_force")
"""Results that are the largest of a run."""
RESULTS_OF_MOTION = {
    "displacement": {"body", "direction", "stage"},
    "mean_force": {"body", "direction", "stage", "force"},
    "friction": {"group", "direction", "stage", "part"},
    "time_share": {"group", "stage", "mode"},
    "moved": {"group", "direction", "stage", "mode"},
}
RESULT_KEYS = RESULTS_OF_CONTACTS | RESULTS_OF_MOTION
"""All results by name, and the keys that say more of each."""
REQUIRED_KEYS = {
    "time": {"stage"},
    "duration": {"stage"},
    "mean_force": {"force"},
    "time_share": {"mode"},
    "moved": {"mode"},
}
"""The keys that a result cannot do without."""
SIGNED_RESULTS = ("end_clearance", "displacement", "mean_force", "friction", "moved")
"""Results that may be negative."""
LOWEST_ATTRIBUTE = "lowest"
"""Attribute of figures that cannot be below that value."""
SPAN_NAMES = (
    explain.WHOLE_RUN,
    explain.IN_CONTACT,
    *explain.EXPLAINED_PHASES,
    *(f"{first} to {second}" for first, second in pairwise(STAGES)),
)
"""The stages over which it is explained why a body moved."""
ALL_STAGE_NAMES = (*SPAN_NAMES, *STAGES)
"""The names of all stages."""


class RunResults:
    """A ``run``, and why it moved, which is looked into once it is asked for."""

    def __init__(self, run: xr.Dataset) -> None:
        self.run = run
        self._explanation: xr.Dataset | None = None

    @property
    def explanation(self) -> xr.Dataset:
        """What `explain_run` says of the run."""
        if self._explanation is None:
            self._explanation = explain.explain_run(self.run)
        return self._explanation

    def group(self, name: str | None) -> str:
        """The group of contacts of this name, or the only one; InputError if there is none."""
        names = self.run["contact_group"].values if "contact_group" in self.run.dims else ()
        groups = [str(group) for group in names]
        if name in groups or (name is None and len(groups) == 1):
            return name or groups[0]
        if not groups:
            raise InputError("found a run without contacts; expected fenders or landings.")
        asked_text = f"the group {name}" if name else "no key group, but several groups of contacts"
        text = f"found {asked_text}; expected one of these groups: {', '.join(groups)}"
        raise InputError(with_hint(text, suggestion(name or "", groups)))

    def body(self, name: str | None) -> str:
        """The body of this name, or the only one; InputError if there is none."""
        bodies = [str(body) for body in self.run.body.values]
        if name in bodies or (name is None and len(bodies) == 1):
            return name or bodies[0]
        asked_text = f"the body {name}" if name else "no key body, but several bodies"
        text = f"found {asked_text}; expected one of these bodies: {', '.join(bodies)}"
        raise InputError(with_hint(text, suggestion(name or "", bodies)))


class ChannelFreeResult:
    """What all results say of the statistic of a channel, which they are none of."""

    phase: ClassVar[None] = None
    channel: ClassVar[str] = ""
    statistic: ClassVar[str] = ""
    start: ClassVar[float] = 0.0


@dataclass(frozen=True)
class StageResult(ChannelFreeResult):
    """What the contacts of a ``group`` did: a ``result`` of `RESULTS_OF_CONTACTS`. Of a time, the
    ``stage`` that is reached then; of a duration, the phase that lasts so long, or the stages from
    which and ``until`` which it is."""

    name: str
    result: str
    group: str | None = None
    stage: str | None = None
    until: str | None = None

    needs_impulses: ClassVar[bool] = False
    is_even: ClassVar[bool] = True

    @property
    def elements(self) -> tuple[str, ...]:
        """The group of contacts that it is of, if one is named."""
        return () if self.group is None else (self.group,)

    @property
    def is_late_if_missing(self) -> bool:
        """Whether a run without this result has not come to it yet."""
        return self.result in TIME_RESULTS

    @property
    def at_least(self) -> bool:
        """Whether a limit is the least that it may be, unless said otherwise."""
        return self.result == "end_clearance"

    def __str__(self) -> str:
        text = self.result.replace("_", " ")
        stage = f' of the stage "{self.stage}"' if self.stage else ""
        until = f' until "{self.until}"' if self.until else ""
        return f"{text}{stage}{until}{_figure_of_suffix(self.group)}"

    def evaluate(self, results: RunResults) -> xr.DataArray:
        """The number with its unit, NaN where the run does not come to it."""
        group = results.group(self.group)
        run = results.run.sel(contact_group=group)
        if self.stage in explain.EXPLAINED_PHASES:
            number = phase_durations(results.run).sel(contact_group=group, phase=self.stage)
            return _scalar_result(float(number), "s", self)
        if STAGE_TIME not in run:
            raise InputError(
                f"found the result {self.result}, but no group of contacts in the run records"
                " its stages; expected a landing, a body with weight: carried, or a fender with a"
                " group. Add one to the case, or remove this result."
            )
        if self.result in phases.FIGURES:
            unit = phases.FIGURES[self.result][1]
            number = _scalar_result(float(run[self.result]), unit, self)
            return number.assign_attrs(side="largest") if self.result in LARGEST_RESULTS else number
        begin = float(run[STAGE_TIME].sel(stage=self.stage))
        if self.result == "time":
            return _scalar_result(begin, "s", self)
        return _scalar_result(float(run[STAGE_TIME].sel(stage=self.until)) - begin, "s", self)


@dataclass(frozen=True)
class MotionCauseResult(ChannelFreeResult):
    """Why a body moved: a ``result`` of `RESULTS_OF_MOTION` in a ``direction``, over a ``stage``.
    It is of a ``body``, and of a ``force`` on it; or of a ``group`` of contacts, in a contact
    ``mode``, or of the ``part`` of friction that has one cause."""

    name: str
    result: str
    stage: str = explain.WHOLE_RUN
    direction: str = "surge"
    body: str | None = None
    force: str | None = None
    group: str | None = None
    part: str | None = None
    mode: str | None = None

    needs_impulses: ClassVar[bool] = True
    is_late_if_missing: ClassVar[bool] = False
    at_least: ClassVar[bool] = False

    @property
    def is_even(self) -> bool:
        """Whether it is the same of a scene and of its mirror image about the x axis."""
        return self.direction != "sway"

    @property
    def elements(self) -> tuple[str, ...]:
        """The group of contacts, or the force, that it is of."""
        return tuple(name for name in (self.group, self.force) if name is not None)

    def __str__(self) -> str:
        text = self.result.replace("_", " ")
        more = " ".join(part for part in (self.force, self.part, self.mode) if part)
        more = f" ({more})" if more else ""
        way = "" if self.result == "time_share" else f" in {self.direction}"
        return f"{text}{more}{_figure_of_suffix(self.group or self.body)}{way}, {self.stage}"

    def evaluate(self, results: RunResults) -> xr.DataArray:
        """The number with its unit, NaN where the run has no such stage."""
        why = results.explanation
        if "group" in RESULTS_OF_MOTION[self.result]:
            return self._of_contacts(results, why)
        at = why.sel(body=results.body(self.body), dof=self.direction)
        at = at.sel(span=self._span(why, None))
        if self.result == "displacement":
            return _scalar_result(float(at.displacement), "m", self)
        forces = [str(force) for force in at.force.values]
        if self.force not in forces:
            text = f"found the force {self.force}; expected one of: {', '.join(forces)}"
            raise InputError(with_hint(text, suggestion(self.force or "", forces)))
        return _scalar_result(float(at.mean_force.sel(force=self.force)), "N", self)

    def _of_contacts(self, results: RunResults, why: xr.Dataset) -> xr.DataArray:
        group = results.group(self.group)
        group_values = why.sel(fender=why.fender_group == group, span=self._span(why, group))
        along = group_values.sel(direction=explain.DIRECTION_AXES[self.direction])
        if self.result == "friction":
            part = along.friction_part.sel(
                part=[self.part] if self.part else list(explain.FRICTION_PARTS)
            )
            return _scalar_result(_sum_of_values(part), "N", self)
        if self.result == "time_share":
            return _scalar_result(
                float(group_values.mode_share.sel(contact_mode=self.mode).mean()), "1", self
            )
        return _scalar_result(float(along.mode_moved.sel(contact_mode=self.mode).mean()), "m", self)

    def _span(self, why: xr.Dataset, group: str | None) -> str:
        """The name of the stage: of one group among several it begins with the group's."""
        spans = [str(span) for span in why.span.values]
        name = f"{group}: {self.stage}" if group else self.stage
        if self.stage in spans or name in spans:
            return self.stage if self.stage in spans else name
        raise InputError(f"found the stage {self.stage}; expected one of: {', '.join(spans)}.")


def _figure_of_suffix(name: str | None) -> str:
    return f" of {name}" if name else ""


def _sum_of_values(values: xr.DataArray) -> float:
    """The sum, not a number if nothing is known."""
    x = values.values
    return float(np.nansum(x)) if np.isfinite(x).any() else np.nan


def _scalar_result(
    number: float, unit: str, asked: StageResult | MotionCauseResult
) -> xr.DataArray:
    import xarray as xr  # slow to load

    lowest = {} if asked.result in SIGNED_RESULTS else {LOWEST_ATTRIBUTE: 0.0}
    return xr.DataArray(number, attrs={"long_name": str(asked), "units": unit, **lowest})
