"""The stages of a transfer of weight from one group of contacts to another.

    first contact       of any contact of the group
    25, 50, 75, 100 %   of the weight transferred: taken by a group that begins without load, given
                        up by one that begins with it; of the slow load, the mean over `SLOW`
    open                all contacts of the group are open, for the first time after they carried
                        half of the weight
    separated           for the last time, and to the end of the run

A re-contact is a contact that closes after the group was open: how many, the largest force and the
largest speed of closing. Contacts that do not count their closings (`forces.contact.loop`) are
looked at at the output times alone, and their speeds are not known.

The weight is that of the body that carries its own weight and has no water: the topside. A transfer
counts as complete within `WITHIN`.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from hydrosim.forces import Contact
from hydrosim.forces.modes import OPEN
from hydrosim.results.names import contact_groups
from hydrosim.scene import Scene, Weight

SLOW = 60.0  # s
WITHIN = 0.005  # of the weight
PARTS = (0.25, 0.5, 0.75, 1.0)
STAGES = ("first contact", *(f"{part:.0%} transferred" for part in PARTS), "open", "separated")
CARRIES = 0.5  # of the weight: a group that does so at the start gives it up


def weights(scene: Scene) -> dict[str, float]:
    """The weight [N] that each group of contacts carries or takes; none where it is not known."""
    dry = {
        body.name: body.mass * scene.environment.gravity
        for body in scene.bodies
        if body.weight == Weight.CARRIED and body.hydrodynamics is None
    }
    found: dict[str, float] = {}
    for name, element in scene.forces.items():
        if isinstance(element, Contact):
            between = [element.body, *(other for _, other in element.others() if other)]
            known = [dry[body] for body in between if body in dry]
            if known:
                found[element.group or name] = max(known)
    return found


def loads(scene: Scene, forces: np.ndarray) -> np.ndarray:
    """Normal forces (nt, ng) of all groups together, of those of all contacts (nt, nf)."""
    groups = np.array(contact_groups(scene))
    each = [forces[:, groups == name].sum(axis=1) for name in dict.fromkeys(groups)]
    return np.stack(each, axis=1)


def transferred(run: xr.Dataset) -> xr.DataArray:
    """Share of the weight transferred (time, contact_group), of groups whose weight is known."""
    load = run.contact_load.sel(contact_group=run.contact_weight > 0.0)
    load = load.transpose("time", "contact_group")
    share = load.values / load.contact_weight.values
    gives = share[0] > CARRIES
    width = max(round(SLOW / _step(run)), 1)
    slow = np.apply_along_axis(_mean, 0, np.where(gives, 1.0 - share, share), width)
    said = {"long_name": "share of the weight transferred", "units": "1"}
    return load.copy(data=slow).assign_attrs(said)


def stages(run: xr.Dataset) -> dict[str, xr.DataArray]:
    """Times of the stages, re-contacts and clearances of the groups whose weight is known; nothing
    if there are none."""
    if "contact_weight" not in run.coords or not np.any(run.contact_weight > 0.0):
        return {}
    share = transferred(run)
    groups = share.contact_group
    each = [
        _of_group(run, str(name), share.sel(contact_group=name).values) for name in groups.values
    ]
    at = {"contact_group": groups}
    times = xr.DataArray(
        [times for times, _ in each], {**at, "stage": list(STAGES)}, ("contact_group", "stage")
    )
    found = {"stage_time": times.assign_attrs(long_name="time of a stage", units="s")}
    for k, (name, (what, unit)) in enumerate(FIGURES.items()):
        values = xr.DataArray([figures[k] for _, figures in each], at, ("contact_group",))
        found[name] = values.assign_attrs(long_name=what, units=unit)
    return found


FIGURES = {
    "recontacts": ("contacts that closed again after all were open", "1"),
    "recontact_force": ("largest force after they closed again", "N"),
    "recontact_speed": ("largest speed at which they closed again", "m/s"),
    "end_clearance": ("smallest clearance at the end, negative if compressed", "m"),
}


def _of_group(run: xr.Dataset, name: str, share: np.ndarray) -> tuple[list[float], list[float]]:
    """The times of `STAGES` and the values of `FIGURES` of a group."""
    own = run.sel(fender=run.fender_group == name)
    time, open_ = run.time.values, own.fender_mode.transpose("time", "fender").values == OPEN
    apart = open_.all(axis=1)
    first = _first(~apart)
    load = run.contact_load.sel(contact_group=name)
    gives = float(load[0] / load.contact_weight) > CARRIES
    carried = first if gives else _first(share >= CARRIES)
    opens = _first(apart & (np.arange(time.size) > carried))
    closed_last = np.flatnonzero(~apart)
    separates = int(closed_last[-1]) + 1 if closed_last.size and apart[-1] else time.size
    levels = [_first(share >= part - (WITHIN if part == PARTS[-1] else 0.0)) for part in PARTS]
    known = np.append(time, np.nan)
    times = [float(known[k]) for k in (first, *levels, opens, separates)]
    clearance = float(-own.fender_compression.values[-1].max())
    return times, [*_recontacts(own, open_, opens), clearance]


def _recontacts(own: xr.Dataset, open_: np.ndarray, opens: int) -> tuple[float, float, float]:
    """Number of contacts after the output time ``opens``, their largest force and speed."""
    if opens >= len(open_):
        return 0.0, np.nan, np.nan
    later = {"time": slice(opens, None)}
    forces = own.fender_normal_force.isel(later).transpose("time", "fender").values
    if "fender_closings" not in own or bool(own.fender_closings.isnull().any()):
        again = np.count_nonzero(open_[opens:-1] & ~open_[opens + 1 :])
        return float(again), float(forces.max()) if again else np.nan, np.nan
    count, speed, force = (
        own[name].isel(later).transpose("time", "fender").values
        for name in ("fender_closings", "fender_closing_speed", "fender_largest_force")
    )
    new = count > count[0]
    if not new.any():
        return 0.0, np.nan, np.nan
    return float((count[-1] - count[0]).sum()), float(force[new].max()), float(speed[new].max())


def stage_lines(found: xr.Dataset) -> Iterator[str]:
    """The stages of each group in words."""
    for name in found.contact_group.values if "stage_time" in found else ():
        of = found.sel(contact_group=name)
        times = {str(s): float(of.stage_time.sel(stage=s)) for s in of.stage.values}
        known = [f"{stage} {at:.1f} s" for stage, at in times.items() if not np.isnan(at)]
        if known:
            clear = f"clearance at the end {float(of.end_clearance):.2f} m"
            yield f"{name}: {', '.join(known)}; {clear}"
        if float(of.recontacts) > 0.0:
            speed = float(of.recontact_speed)
            fast = "" if np.isnan(speed) else f", at up to {speed:.3f} m/s"
            yield (
                f"{name}: closed again {float(of.recontacts):.0f} times, largest force"
                f" {float(of.recontact_force) / 1e3:.0f} kN{fast}"
            )


def _step(run: xr.Dataset) -> float:
    return float(run.time.values[1] - run.time.values[0]) if run.time.size > 1 else SLOW


def _mean(values: np.ndarray, width: int) -> np.ndarray:
    """Mean over ``width`` neighbours, fewer at the ends."""
    total = np.concatenate([[0.0], np.cumsum(values)])
    k = np.arange(values.size)
    low, high = np.maximum(k - width // 2, 0), np.minimum(k + width // 2 + 1, values.size)
    return np.asarray((total[high] - total[low]) / (high - low))


def _first(condition: np.ndarray) -> int:
    """Index of the first true entry, the length if there is none."""
    return int(condition.argmax()) if condition.any() else condition.size
