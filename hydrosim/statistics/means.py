"""Mean forces from impulses, for runs that record them.

A force that chatters, or peaks between two output times, has a different mean in the records than
over the time. Its impulse, an integral over the solver's own steps, gives the true mean. It
replaces the mean of the records if both differ by more than `MEAN_DIFFERENCE_FRACTION` of the
force's standard deviation.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

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
        own = [of] if of in run.fender.values else run.fender.values[run.fender_group.values == of]
        impulse = run.contact_impulse.sel(fender=own).transpose("time", ...)
        return np.asarray(impulse.values.reshape(run.sizes["time"], -1).sum(axis=1))
    if kind.startswith("force_") and "impulse" in run:
        force, body, dof = kind.removeprefix("force_"), *of.split(".")
        return np.asarray(run.impulse.sel(force=force, body=body, dof=dof).values)
    return None
