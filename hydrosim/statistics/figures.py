"""Figures of a run: one number each, a statistic of a channel over the whole run or in one phase.

    end, change             the last value; the last minus the first
    end_absolute            magnitude of the last value, of a position from the place at rest
    change_absolute         magnitude of the last minus the first: the crawl, wherever it began
    mean                    of the recorded values; of a force, by its impulse if they differ
    std                     of the recorded values
    smallest, largest       of the recorded values
    largest_absolute        largest magnitude

`hydrosim.statistics.results` has figures that are no statistic of a channel.

Mean forces from impulses, for runs that record them.

A force that chatters, or peaks between two output times, has a different mean in the records than
over the time. Its impulse, an integral over the solver's own steps, gives the true mean. It
replaces the mean of the records if both differ by more than `MEAN_DIFFERENCE_FRACTION` of the
force's standard deviation.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
import xarray as xr

from hydrosim.errors import InputError
from hydrosim.results.channels import channel_series, lowest_value
from hydrosim.results.phases import Phase
from hydrosim.statistics.results import LOWEST_ATTRIBUTE, RunResults

MEAN_DIFFERENCE_FRACTION = 0.01
FENDER_NORMAL_FORCE = "fender_normal_force"


def means_between_records(run: xr.Dataset, name: str, values: np.ndarray) -> np.ndarray | None:
    """Means (nt,) of a force channel ``name`` since the previous record, NaN at the first; None if
    their mean agrees with that of the recorded ``values`` (nt,)."""
    impulse = _impulse(run, name)
    if impulse is None or values.size < 2:
        return None
    time = run.time.values
    means = np.diff(impulse) / np.diff(time)
    recorded = np.trapezoid(values, time) / (time[-1] - time[0])
    true = (impulse[-1] - impulse[0]) / (time[-1] - time[0])
    if abs(recorded - true) <= MEAN_DIFFERENCE_FRACTION * values.std():
        return None
    return np.append(np.nan, means)


def _impulse(run: xr.Dataset, name: str) -> np.ndarray | None:
    """Time integral (nt,) of a force channel, if the run has it."""
    kind, _, of = name.partition(".")
    if kind == FENDER_NORMAL_FORCE and "contact_impulse" in run:
        fenders = (
            [of] if of in run.fender.values else run.fender.values[run.fender_group.values == of]
        )
        impulse = run.contact_impulse.sel(fender=fenders).transpose("time", ...)
        return np.asarray(impulse.values.reshape(run.sizes["time"], -1).sum(axis=1))
    if kind.startswith("force_") and "impulse" in run:
        force, body, dof = kind.removeprefix("force_"), *of.split(".")
        return np.asarray(run.impulse.sel(force=force, body=body, dof=dof).values)
    return None


Statistic = Callable[[np.ndarray], float]
STATISTICS: dict[str, Statistic] = {
    "end": lambda x: x[-1],
    "end_absolute": lambda x: abs(x[-1]),
    "change": lambda x: x[-1] - x[0],
    "change_absolute": lambda x: abs(x[-1] - x[0]),
    "mean": np.mean,
    "std": np.std,
    "smallest": np.min,
    "largest": np.max,
    "largest_absolute": lambda x: np.abs(x).max(),
}
SIDE_ATTRIBUTE = "side"  # attribute of figures that are the largest or the smallest of something
STATISTIC_SIDES = {"largest": "largest", "largest_absolute": "largest", "smallest": "smallest"}
MAGNITUDE_STATISTICS = ("end_absolute", "change_absolute", "std", "largest_absolute")
"""Statistics that are never negative."""
STATISTIC_WORDS = {
    "end_absolute": "magnitude at the end",
    "change_absolute": "magnitude of the change",
    "largest_absolute": "largest magnitude",
}
"""Statistics whose names are not words."""
PHASES_BY_NAME = {phase.name.lower().replace("_", " "): phase for phase in Phase}


class RequestedStatistic(Protocol):
    """A number that is asked of each run, under a ``name``."""

    @property
    def name(self) -> str:
        """What it is called."""

    @property
    def channel(self) -> str:
        """The channel that it is of, "" if of none."""

    @property
    def statistic(self) -> str:
        """The statistic of the channel, "" if of none."""

    @property
    def phase(self) -> str | None:
        """The phase of the operation that it is of, if not of all times."""

    @property
    def start(self) -> float:
        """The time [s] from which on it is taken."""

    @property
    def needs_impulses(self) -> bool:
        """Whether a run must record impulses."""

    @property
    def late_if_missing(self) -> bool:
        """Whether a run without it has not come to it yet."""

    @property
    def at_least(self) -> bool:
        """Whether a limit is the least that it may be, unless said otherwise."""

    @property
    def is_even(self) -> bool:
        """Whether it is the same of a scene and of its mirror image about the x axis, if it is of
        no channel."""

    @property
    def elements(self) -> tuple[str, ...]:
        """The groups of contacts or force elements that it is of, if it is of no channel."""

    def evaluate(self, results: RunResults) -> xr.DataArray:
        """The number, with its unit."""


class ScalarResult(NamedTuple):
    """A requested figure: a ``statistic`` of a ``channel`` in a phase of the operation of any group
    of contacts, or over all times from ``start`` [s] on."""

    name: str
    channel: str
    statistic: str
    phase: str | None = None
    start: float = 0.0

    @property
    def needs_impulses(self) -> bool:
        """Whether a run must record impulses."""
        return False

    @property
    def late_if_missing(self) -> bool:
        """Whether a run without it has not come to it yet."""
        return False

    @property
    def is_even(self) -> bool:
        """That depends on the channel."""
        return False

    @property
    def elements(self) -> tuple[str, ...]:
        """It is of a channel."""
        return ()

    @property
    def at_least(self) -> bool:
        """Whether a limit is the least that it may be, unless said otherwise."""
        return self.statistic == "smallest"

    def __str__(self) -> str:
        text = f"{STATISTIC_WORDS.get(self.statistic, self.statistic)} of {self.channel}"
        return f"{text} while {self.phase}" if self.phase else text

    def evaluate(self, results: RunResults) -> xr.DataArray:
        """The number, with its unit; NaN where the run is never in that phase. Raises InputError
        where the run has no such channel or no contacts whose phases there could be."""
        run = results.run
        values, unit = channel_series(run, self.channel)
        times = _times(run, self)
        if self.statistic == "mean":
            means = means_between_records(run, self.channel, values)
            if means is not None:
                values = means
                times &= ~np.isnan(means)
        within = values[times]
        number = float(STATISTICS[self.statistic](within)) if within.size else np.nan
        attributes = {"long_name": str(self), "units": unit}
        return xr.DataArray(number, attrs={**attributes, **_side(self), **_lowest(self)})


def _side(of: ScalarResult) -> dict[str, str]:
    return (
        {SIDE_ATTRIBUTE: STATISTIC_SIDES[of.statistic]} if of.statistic in STATISTIC_SIDES else {}
    )


def _lowest(of: ScalarResult) -> dict[str, float]:
    """What the number cannot be below: a magnitude, or a value of a channel that is one."""
    if of.statistic in MAGNITUDE_STATISTICS:
        return {LOWEST_ATTRIBUTE: 0.0}
    lowest = lowest_value(of.channel)
    return {LOWEST_ATTRIBUTE: lowest} if of.statistic != "change" and np.isfinite(lowest) else {}


def figure_of(run: xr.Dataset, figure: RequestedStatistic) -> xr.DataArray:
    """The number that is asked of a run, with its unit."""
    return figure.evaluate(RunResults(run))


def _times(run: xr.Dataset, figure: ScalarResult) -> np.ndarray:
    late = run.time.values >= figure.start
    if figure.phase is None:
        return np.asarray(late)
    if "contact_phase" not in run:
        raise InputError(
            f"found phase {figure.phase}; expected a run with contacts: phases are stages of"
            f" contact ({', '.join(PHASES_BY_NAME)}). Leave the phase out."
        )
    phases = run.contact_phase.transpose("time", "contact_group").values
    return np.asarray(late & np.any(phases == PHASES_BY_NAME[figure.phase], axis=1))
