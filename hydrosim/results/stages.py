"""The stages of a group of contacts: of a transfer of weight from one to another, or of a fender.

    first contact       of any contact of the group
    25, 50, 75, 100 %   of the weight transferred: taken by a group that begins without load, given
                        up by one that begins with it; of the slow load, the mean over `SLOW`
    open                all contacts of the group are open, for the first time after they carried
                        half of the weight
    separated           for the last time, and to the end of the run

A re-contact is a contact that closes after the group was open: how many, the largest force and the
largest speed of closing. All of it comes from events and from the impulse of the load
(`forces.contact.group`), so that it does not depend on how often a run is recorded.

The weight is that of the body that carries its own weight and has no water: the topside. Where none
is known, nothing is transferred, and the group is open once nothing touches any more. A transfer
counts as complete within `WITHIN`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.forces.contact import group
from hydrosim.forces.contact.group import CARRIES, NEVER, Remembered
from hydrosim.forces.contact.modes import OPEN

if TYPE_CHECKING:
    import xarray as xr

Share = Callable[[np.ndarray], np.ndarray]

SLOW = 60.0  # s
LOOK = 0.1  # s: as often a share is looked at
WITHIN = 0.005  # of the weight
PARTS = (0.25, 0.5, 0.75, 1.0)
STAGES = ("first contact", *(f"{part:.0%} transferred" for part in PARTS), "open", "separated")
FIGURES = {
    "closings": ("contacts that closed", "1"),
    "closing_speed": ("largest speed at which one closed", "m/s"),
    "largest_contact_force": ("largest force of a contact", "N"),
    "recontacts": ("contacts that closed again after all were open", "1"),
    "recontact_speed": ("largest speed at which they closed again", "m/s"),
    "recontact_force": ("largest force after they closed again", "N"),
    "end_clearance": ("smallest clearance at the end, negative if compressed", "m"),
}
IMPULSE = "group_impulse"
TIME = "stage_time"
WEIGHT = "contact_weight"


class Group(NamedTuple):
    """A group of contacts in a run: the ``time`` (nt,) of records, ``impulse`` and ``load`` (nt,)
    then, and its ``weight`` [N]."""

    time: np.ndarray
    impulse: np.ndarray
    load: np.ndarray
    weight: float

    def share(self) -> Share:
        """The share of the weight transferred over time, of the slow load."""
        from scipy.interpolate import CubicHermiteSpline  # slow to import, and few runs have stages

        spline = CubicHermiteSpline(self.time, self.impulse, self.load)
        first, last = self.time[[0, -1]]
        gives = self.load[0] > CARRIES * self.weight

        def at(time: np.ndarray) -> np.ndarray:
            low = np.maximum(time - 0.5 * SLOW, first)
            high = np.minimum(time + 0.5 * SLOW, last)
            part = (spline(high) - spline(low)) / ((high - low) * self.weight)
            return np.asarray(1.0 - part if gives else part)

        return at

    def transferred(self) -> list[float]:
        """The times at which `PARTS` of the weight are transferred."""
        if not self.weight > 0.0 or self.time.size < 2:
            return [NEVER] * len(PARTS)
        share = self.share()
        time = np.arange(self.time[0], self.time[-1], LOOK)
        levels = [part - (WITHIN if part == PARTS[-1] else 0.0) for part in PARTS]
        return [_reaches(level, time, share(time), share) for level in levels]


def staged(run: xr.Dataset, groups: Sequence[Remembered]) -> xr.Dataset:
    """The ``run`` with loads and impulses of its groups of contacts, times of their stages and
    `FIGURES`; not a number of groups that are not among the ``groups`` that remember."""
    if not groups or run.sizes["time"] == 0:
        return run
    load = run.fender_normal_force.groupby("fender_group").sum()
    load = load.rename(fender_group="contact_group").sel(contact_group=run.contact_group)
    load = load.transpose("time", "contact_group").drop_attrs()
    count = run.sizes["contact_group"]
    weight = np.full(count, np.nan)
    impulse = np.full(load.shape, np.nan)
    times = np.full((count, len(STAGES)), np.nan)
    figures = np.full((count, len(FIGURES)), np.nan)
    for each in groups:
        k = each.group
        own = each.y
        impulse[:, k] = own[:, group.IMPULSE]
        weight[k] = each.weight or np.nan
        parts = Group(run.time.values, impulse[:, k], load.values[:, k], weight[k]).transferred()
        here = run.isel(time=-1, fender=run.fender_group.values == run.contact_group.values[k])
        times[k] = _times(own[-1], parts, bool(np.all(here.fender_mode == OPEN)))
        figures[k] = [*_figures(own[-1]), -here.fender_compression.max()]
    over = ("contact_group",)
    found = {
        "contact_load": (load.dims, load.values, _said("sum of the normal forces", "N")),
        IMPULSE: (load.dims, impulse, _said("integral of the normal forces", "N s")),
        TIME: ((*over, "stage"), times, _said("time of a stage", "s")),
        **{
            name: (over, values, _said(*said))
            for (name, said), values in zip(FIGURES.items(), figures.T, strict=True)
        },
    }
    run = run.assign(found).assign_coords(stage=list(STAGES))
    said = _said("weight that the group carries or takes", "N")
    return run.assign_coords({WEIGHT: (over, weight, said)}) if np.any(weight > 0.0) else run


def _times(own: np.ndarray, parts: Sequence[float], ends_open: bool) -> list[float]:
    """The times of `STAGES` [s] by what a group remembers, not a number of those that it does not
    come to."""
    first, opened, last = own[[group.FIRST, group.OPENED, group.LAST]]
    after = (time if time == NEVER else max(time, first) for time in parts)  # the mean looks ahead
    known = (first, *after, opened, last if ends_open else NEVER)
    return [time if time != NEVER else np.nan for time in known]


def _figures(own: np.ndarray) -> list[float]:
    """The values of all `FIGURES` but the last."""
    count, speed, force = own[group.CLOSINGS : group.AGAIN]
    again, again_speed, again_force = own[group.AGAIN :]
    unknown = np.nan
    return [
        *(count, speed if count else unknown, force),
        *(again, again_speed if again else unknown, again_force if again else unknown),
    ]


def _reaches(level: float, time: np.ndarray, values: np.ndarray, share: Share) -> float:
    """When a share first comes to a ``level``; `NEVER` if it does not."""
    if not (values >= level).any():
        return NEVER
    k = int((values >= level).argmax())
    if k == 0:
        return float(time[0])
    from scipy.optimize import brentq

    return float(brentq(lambda t: share(np.array(t)) - level, time[k - 1], time[k]))


def _said(what: str, unit: str) -> dict[str, str]:
    return {"long_name": what, "units": unit, "frame": "none"}


def stages(run: xr.Dataset) -> dict[str, xr.DataArray]:
    """What a run says of the stages of its groups; nothing if it has none."""
    return {name: run[name] for name in (TIME, *FIGURES) if name in run}


def transferred(run: xr.Dataset) -> xr.DataArray:
    """Share of the weight transferred (time, contact_group), of groups whose weight is known."""
    load = run.contact_load.sel(contact_group=run[WEIGHT] > 0.0).transpose(..., "contact_group")
    impulse = run[IMPULSE].sel(contact_group=load.contact_group).transpose(*load.dims)
    time = run.time.values
    each = zip(impulse.values.T, load.values.T, load[WEIGHT].values, strict=True)
    shares = [Group(time, *own).share()(time) for own in each]
    said = {"long_name": "share of the weight transferred", "units": "1"}
    return load.copy(data=np.stack(shares, axis=1)).assign_attrs(said)
