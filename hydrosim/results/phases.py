"""Phases and stages of groups of contacts, from the contact history.

Phases of an operation that begins free and ends held by friction.

Contacts of one element form a group. Each group has its own phases, so a fender that is always in
contact hides no operation at another element.

    moored           until the first contact of any fender of the group
    initial contact  until there is always a fender in contact
    compressed       until the fenders stick nearly all the time
    stuck            to the end

A body sticks nearly all the time from where on every stretch of `WINDOW` has at least
`MIN_STICKING_SHARE` of its fenders' time in stick. A run that ends before a phase does not have it.

Phases are computed for every group. They are reported only for groups that go through such an
operation: they begin without contact and end stuck. Fenders of a quay and pairs of fenders do not.

Stages of a group of contacts: a transfer of weight to or from it, or the contacts of a fender.

    first contact       of any contact of the group
    25, 50, 75, 100 %   of the weight transferred: taken by a group that begins without load, given
                        up by one that begins with it; of the slow load, the mean over
                        `AVERAGING_WINDOW_S`
    open                all contacts of the group are open, for the first time after they carried
                        half of the weight
    separated           for the last time, and to the end of the run

A re-contact is a contact that closes after the whole group was open. Re-contacts have a count, a
largest force and a largest closing speed. All figures come from events and from the impulse of the
load (`elements.contact.group`), so they do not depend on the output step.

The weight is that of a body that carries its own weight and is dry: the topside. Without a known
weight nothing is transferred, and the group is open when no contact touches any more. A transfer
counts as complete within `FULL_TRANSFER_TOL`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from enum import IntEnum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.elements.contact import group
from hydrosim.elements.contact.group import CARRIED_SHARE, NEVER, GroupMemory
from hydrosim.elements.contact.law import OPEN, STICK

if TYPE_CHECKING:
    import xarray as xr

WINDOW = 100.0  # s
MIN_STICKING_SHARE = 0.8


class Phase(IntEnum):
    """Phases in the order of time."""

    MOORED = 0
    INITIAL_CONTACT = 1
    COMPRESSED = 2
    STUCK = 3


def is_operation(phases: Iterable[int]) -> bool:
    """Whether a group of contacts with these ``phases`` begins without contact and ends stuck for
    good."""
    return {Phase.MOORED, Phase.STUCK} <= {*phases}


def contact_phases(time: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """Phase (nt,) at each ``time`` (nt,) [s], evenly spaced, for contact ``modes`` (nt, nf)."""
    phase = np.full(time.size, Phase.MOORED, dtype=np.int8)
    if time.size < 2 or modes.shape[1] == 0:
        return phase
    touching = np.any(modes != OPEN, axis=1)
    first = int(touching.argmax()) if touching.any() else time.size
    closed = _last_index(np.all(modes == OPEN, axis=1)) + 1
    stuck = max(closed, _sticks_from(time, modes))
    phase[first:] = Phase.INITIAL_CONTACT
    phase[max(first, closed) :] = Phase.COMPRESSED
    phase[max(first, stuck) :] = Phase.STUCK
    return phase


def group_phases(time: np.ndarray, modes: np.ndarray, groups: Sequence[str]) -> np.ndarray:
    """Phases (nt, ng) of each group of contacts, in the order of their names, from contact
    ``modes`` (nt, nf). ``groups`` (nf,) are the groups of the contacts."""
    names = np.array(groups)
    phases_by_group = [
        contact_phases(time, modes[:, names == name]) for name in dict.fromkeys(groups)
    ]
    return np.stack(phases_by_group, axis=1)


def _last_index(condition: np.ndarray) -> int:
    """Index of the last true entry, -1 if there is none."""
    return int(condition.size - 1 - condition[::-1].argmax()) if condition.any() else -1


def _sticks_from(time: np.ndarray, modes: np.ndarray) -> int:
    """Index from which on all windows have enough stick."""
    share = np.mean(modes == STICK, axis=1)
    width = max(round(WINDOW / (time[1] - time[0])), 1)
    if share.size < width:
        return share.size
    mean = np.convolve(share, np.full(width, 1.0 / width), mode="valid")
    start = _last_index(mean < MIN_STICKING_SHARE) + 1
    return start if start < mean.size else share.size


Share = Callable[[np.ndarray], np.ndarray]

AVERAGING_WINDOW_S = 60.0  # s
TRANSFERRED_FRACTION_STEP_S = 0.1  # s: time step at which the transferred fraction is computed
FULL_TRANSFER_TOL = 0.005  # of the weight
TRANSFER_FRACTIONS = (0.25, 0.5, 0.75, 1.0)
STAGES = (
    "first contact",
    *(f"{part:.0%} transferred" for part in TRANSFER_FRACTIONS),
    "open",
    "separated",
)
FIGURES = {
    "closings": ("number of contact closings", "1"),
    "closing_speed": ("largest closing speed of a contact", "m/s"),
    "largest_contact_force": ("largest force of a contact", "N"),
    "recontacts": ("number of contact closings after all contacts were open", "1"),
    "recontact_speed": ("largest closing speed after all contacts were open", "m/s"),
    "recontact_force": ("largest contact force after all contacts were open", "N"),
    "end_clearance": ("smallest clearance at the end, negative if compressed", "m"),
}
LOAD_TEXT = "sum of the normal forces"
GROUP_IMPULSE = "group_impulse"
STAGE_TIME = "stage_time"
CONTACT_WEIGHT = "contact_weight"


class GroupLoad(NamedTuple):
    """Load of a group of contacts over a run. ``impulse`` [N s] since the start and ``load`` [N]
    are given at the output ``time`` [s], (nt,) each; ``weight`` [N] is what the group is to
    carry."""

    time: np.ndarray
    impulse: np.ndarray
    load: np.ndarray
    weight: float

    def share(self) -> Share:
        """Transferred fraction of the weight over time, from the slow load."""
        from scipy.interpolate import CubicHermiteSpline  # slow to import, and few runs have stages

        spline = CubicHermiteSpline(self.time, self.impulse, self.load)
        first, last = self.time[[0, -1]]
        gives = self.load[0] > CARRIED_SHARE * self.weight

        def share_at(time: np.ndarray) -> np.ndarray:
            low = np.maximum(time - 0.5 * AVERAGING_WINDOW_S, first)
            high = np.minimum(time + 0.5 * AVERAGING_WINDOW_S, last)
            part = (spline(high) - spline(low)) / ((high - low) * self.weight)
            return np.asarray(1.0 - part if gives else part)

        return share_at

    def transfer_times(self) -> list[float]:
        """Times at which the fractions `TRANSFER_FRACTIONS` of the weight are transferred."""
        if not self.weight > 0.0 or self.time.size < 2:
            return [NEVER] * len(TRANSFER_FRACTIONS)
        share = self.share()
        time = np.arange(self.time[0], self.time[-1], TRANSFERRED_FRACTION_STEP_S)
        levels = [
            part - (FULL_TRANSFER_TOL if part == TRANSFER_FRACTIONS[-1] else 0.0)
            for part in TRANSFER_FRACTIONS
        ]
        return [_time_at_level(level, time, share(time), share) for level in levels]


def add_stage_results(run: xr.Dataset, groups: Sequence[GroupMemory]) -> xr.Dataset:
    """The ``run`` with loads and impulses of its groups of contacts, times of their stages and
    `FIGURES`. They are NaN for groups that are not in ``groups``."""
    if not groups or run.sizes["time"] == 0:
        return run
    normal, group_of_fender = run.fender_normal_force.values, run.fender_group.values
    loads = [np.nansum(normal[:, group_of_fender == g], 1) for g in run.contact_group.values]
    load = np.stack(loads, axis=1)
    count = run.sizes["contact_group"]
    weight = np.full(count, np.nan)
    impulse = np.full(load.shape, np.nan)
    times = np.full((count, len(STAGES)), np.nan)
    figures = np.full((count, len(FIGURES)), np.nan)
    for memory in groups:
        k = memory.group
        weight_at_group = memory.y
        impulse[:, k] = weight_at_group[:, group.GROUP_IMPULSE]
        weight[k] = memory.weight or np.nan
        parts = GroupLoad(run.time.values, impulse[:, k], load[:, k], weight[k]).transfer_times()
        here = run.isel(time=-1, fender=run.fender_group.values == run.contact_group.values[k])
        times[k] = _stage_times(
            weight_at_group[-1], parts, bool(np.all(here.fender_mode.values == OPEN))
        )
        figures[k] = [*_stage_figures(weight_at_group[-1]), -here.fender_compression.max()]
    over = ("contact_group",)
    variables = {
        "contact_load": (
            ("time", *over),
            load,
            _attributes(LOAD_TEXT, "N"),
        ),
        GROUP_IMPULSE: (
            ("time", *over),
            impulse,
            _attributes("integral of the normal forces", "N s"),
        ),
        STAGE_TIME: ((*over, "stage"), times, _attributes("time of a stage", "s")),
        **{
            name: (over, values, _attributes(*meaning))
            for (name, meaning), values in zip(FIGURES.items(), figures.T, strict=True)
        },
    }
    run = run.assign(variables).assign_coords(stage=list(STAGES))
    attributes = _attributes("weight that the group carries or takes over", "N")
    return (
        run.assign_coords({CONTACT_WEIGHT: (over, weight, attributes)})
        if np.any(weight > 0.0)
        else run
    )


def _stage_times(stage_times: np.ndarray, parts: Sequence[float], ends_open: bool) -> list[float]:
    """Times of `STAGES` [s] from the stored events of a group; NaN for stages that did not
    happen."""
    first, opened, last = stage_times[[group.FIRST_CONTACT, group.FIRST_OPEN, group.LAST_OPEN]]
    after = (time if time == NEVER else max(time, first) for time in parts)  # the mean looks ahead
    times = (first, *after, opened, last if ends_open else NEVER)
    return [time if time != NEVER else np.nan for time in times]


def _stage_figures(stage_times: np.ndarray) -> list[float]:
    """Values of all `FIGURES` except the last."""
    count, speed, force = stage_times[group.CLOSINGS : group.RECONTACTS]
    again, again_speed, again_force = stage_times[group.RECONTACTS :]
    unknown = np.nan
    return [
        *(count, speed if count else unknown, force),
        *(again, again_speed if again else unknown, again_force if again else unknown),
    ]


def _time_at_level(level: float, time: np.ndarray, values: np.ndarray, share: Share) -> float:
    """Time at which a fraction first reaches a ``level``; `NEVER` if it does not."""
    if not (values >= level).any():
        return NEVER
    k = int((values >= level).argmax())
    if k == 0:
        return float(time[0])
    from scipy.optimize import brentq

    return float(brentq(lambda t: share(np.array(t)) - level, time[k - 1], time[k]))


def _attributes(what: str, unit: str) -> dict[str, str]:
    return {"long_name": what, "units": unit, "frame": "none"}


def stages(run: xr.Dataset) -> dict[str, xr.DataArray]:
    """Stage times and figures of a run; empty if it has none."""
    return {name: run[name] for name in (STAGE_TIME, *FIGURES) if name in run}


def transferred_fraction(run: xr.Dataset) -> xr.DataArray:
    """Transferred fraction of the weight (time, contact_group), for groups of known weight."""
    load = run.contact_load.sel(contact_group=run[CONTACT_WEIGHT] > 0.0).transpose(
        ..., "contact_group"
    )
    impulse = run[GROUP_IMPULSE].sel(contact_group=load.contact_group).transpose(*load.dims)
    time = run.time.values
    group_columns = zip(impulse.values.T, load.values.T, load[CONTACT_WEIGHT].values, strict=True)
    shares = [GroupLoad(time, *columns).share()(time) for columns in group_columns]
    attributes = {"long_name": "share of the weight transferred", "units": "1"}
    return load.copy(data=np.stack(shares, axis=1)).assign_attrs(attributes)
