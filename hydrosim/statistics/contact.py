"""Statistics of contact and friction in a run: time in each mode, slip, crawl by phase."""

from __future__ import annotations

import numpy as np
import xarray as xr

from hydrosim.results.phases import Phase

AVERAGING_TIME = 60.0  # s: the position is averaged over this time at both ends of a phase


def contact_statistics(run: xr.Dataset) -> dict[str, xr.DataArray]:
    """Time fraction in each mode and slip of each fender. For each group of fenders, time fraction
    of each phase, and crawl of each body in it."""
    modes, phase = run.fender_mode, run.contact_phase.transpose("contact_group", "time").values
    names = modes.attrs["flag_meanings"].split()
    share = np.array([(modes.values == k).mean(axis=0) for k in range(len(names))])
    crawl = [[_displacement_during(run, of == one) for one in Phase] for of in phase]
    durations = phase_durations(run)
    phases = {name: durations[name] for name in durations.dims}
    return {
        "fender_share": xr.DataArray(
            share,
            {"mode": names, "fender": run.fender},
            ("mode", "fender"),
            attrs=_attributes("fraction of the time", "1"),
        ),
        "fender_slipped": run.fender_slip_distance.isel(time=-1, drop=True).assign_attrs(
            _attributes("distance slipped", "m")
        ),
        "phase_duration": durations,
        "phase_crawl": xr.DataArray(
            np.array(crawl),
            {**phases, "body": run.body, "axis": ["x", "y"]},
            (*phases, "body", "axis"),
            attrs=_attributes("slow displacement from the beginning to the end of the phase", "m"),
        ),
    }


def phase_durations(run: xr.Dataset) -> xr.DataArray:
    """How long each group of contacts is in each phase [s] (contact_group, phase)."""
    phase = run.contact_phase.transpose("contact_group", "time").values
    span = np.ptp(run.time.values)
    time = np.array([[np.mean(of == one) * span for one in Phase] for of in phase])
    names = [one.name.lower().replace("_", " ") for one in Phase]
    phases = {"contact_group": run.contact_group, "phase": names}
    return xr.DataArray(time, phases, tuple(phases), attrs=_attributes("duration", "s"))


def crawl(run: xr.Dataset) -> xr.DataArray:
    """Path length of the contact nodes (time, fender, axis) since the start [m]. While open, a node
    stays at the point of last contact; NaN before the first contact."""
    node = run.fender_node.transpose("time", "fender", "axis")
    gone = (node - node[0]).values
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


def _attributes(what: str, unit: str) -> dict[str, str]:
    return {"long_name": what, "units": unit}
