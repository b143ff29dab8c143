"""Statistics of a run: moments, periods, extremes and spectra, and contact.

`hydrosim.statistics.extremes` gives, for each channel, the most probable smallest and largest value
with a confidence interval, and a prediction interval for another such run. If a channel is too
short or not stationary, there are none, and its basis gives the reason.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import scipy
import xarray as xr
from numpy.lib.stride_tricks import sliding_window_view

from hydrosim.files.series import STATISTIC_UNITS
from hydrosim.results.channels import channel_series, lowest_value
from hydrosim.results.dataset import KIND, ResultKind, new_dataset
from hydrosim.results.phases import Phase, stages
from hydrosim.results.variables import (
    LOADS,
    OF_CHANNEL,
    TENSIONS,
    describe_coordinates,
    describe_values,
    quantity_attributes,
)
from hydrosim.statistics.extremes import (
    CHANGES,
    LAWS,
    RECORD_ROUNDING_FRACTION,
    ExtremeModel,
    RecordExtremes,
    extremes,
    refusal_reason,
    undefined_extremes,
)
from hydrosim.statistics.figures import FENDER_NORMAL_FORCE, means_between_records
from hydrosim.statistics.gumbel import INTERVAL_PROBABILITY
from hydrosim.statistics.results import contact_statistics
from hydrosim.statistics.series import fit_weibull, lowest_frequency, peaks, upcrossings

PART_STATISTICS = ("first_mean", "last_mean", "first_std", "last_std")
ExtremesArguments = tuple[float, float | None, float, bool]
"""Arguments of `extremes` beside the record."""
MOMENT_NAMES = ("skewness", "kurtosis")  # kurtosis of a Gaussian record is 3
PEAK_NAMES = ("peak_shape", "peak_scale")  # Weibull law of the peaks above the mean
STATISTIC_NAMES = (
    "mean",
    "std",
    "significant",
    "period",
    *PART_STATISTICS,
    "smallest",
    "largest",
    *MOMENT_NAMES,
    *PEAK_NAMES,
)
EXTREME_SIDES = ("smallest", "largest")
EXTREME_FIGURES = RecordExtremes._fields[:-1]
MIN_PHASE_FRACTION = 0.05  # of the record, in a phase
PART_FRACTION = 0.2  # of a record: its first and its last part
SPECTRUM_SEGMENTS = 8  # of a run, whose spectra are averaged
STEP_TOLERANCE = 1e-6  # of a step
MIN_SAMPLES = 4  # values of a phase, records of a run
MOTION_DIMS = ("body", "dof")
NAMED_CHANNELS = "named"  # of those that are asked for by name
RECORDED_SUFFIX = "_recorded_mean"  # ends the name of a variable that not every run has
OWN_COORDINATES = {  # coordinates of statistics
    "statistic": STATISTIC_NAMES,
    "side": EXTREME_SIDES,
    "extreme": EXTREME_FIGURES,
    "phase": [phase.name.lower().replace("_", " ") for phase in Phase],
}
Variables = dict[str, tuple[tuple[str, ...], np.ndarray, dict[str, Any]]]
"""Dimensions, values and attributes of a variable."""
AS_CHANNEL = "that of the channel"
UNITS_APART = {"period": "s", "skewness": "1", "kurtosis": "1", "peak_shape": "1"}
"""Units of statistics that do not have that of their channel."""
OWN_UNITS = {STATISTIC_UNITS: ", ".join(f"{name}: {unit}" for name, unit in UNITS_APART.items())}
# Variables that a run may have: name, variable, its dimensions without time, units.
CHANNEL_VARIABLES = {
    "motion": ("position", MOTION_DIMS, "m or rad"),
    "wave": ("wave_elevation", (), "m"),
    **{f"{dim}_force": (load, (dim,), "N") for dim, load in LOADS.items()},
}


def has_enough_records(run: xr.Dataset, start: float) -> bool:
    """Whether a run has enough records for `statistics` from ``start`` [s] on."""
    return int(np.count_nonzero(run.time.values >= start)) >= MIN_SAMPLES


def statistics(
    run: xr.Dataset,
    start: float = 0.0,
    exposure: float | None = None,
    channels: Sequence[str] = (),
) -> xr.Dataset:
    """Statistics of motions, of the wave, of fenders and springs, and of the requested ``channels``
    (`hydrosim.results.channels`), from ``start`` [s] on, by ``statistic``. Requested channels also
    have statistics by phase. Extremes are for an ``exposure`` [s]; default: the length of the
    record. Spectra are those of motions. For the whole run, each fender has the time in each mode
    and its slip, and each group of fenders the crawl by phase. Raises InputError if a channel does
    not exist."""
    variables, coords, attributes = columns(run, start, exposure, channels)
    attributes[KIND] = ResultKind.STATISTICS.value
    made = new_dataset({**variables, **unit_statistics(run)}, coords, attributes)
    return describe_coordinates(made)


def unit_statistics(run: xr.Dataset) -> dict[str, xr.DataArray]:
    """Statistics of the lines and contacts of a run, if it has any."""
    if "contact_group" not in run.dims:
        return line_statistics(run)
    return {**line_statistics(run), **contact_statistics(run), **stages(run)}


def line_statistics(run: xr.Dataset) -> dict[str, xr.DataArray]:
    """Of all that pulls, the tension at the start of a run; of what has a capacity, the largest
    share of it that was used, at output times."""
    variables = {}
    for dim, name in TENSIONS.items():
        if name not in run or not run.sizes["time"]:
            continue
        tension = run[name]
        start = tension.isel(time=0, drop=True)
        variables[f"{dim}_start"] = start.assign_attrs(
            quantity_attributes("tension at the start", "N")
        )
        if (capacity := f"{dim}_capacity") in run.coords:
            used = tension.max("time") / run[capacity]
            variables[f"{dim}_used"] = used.assign_attrs(
                quantity_attributes("largest tension over capacity", "1")
            )
    return variables


def columns(
    run: xr.Dataset,
    start: float = 0.0,
    exposure: float | None = None,
    channels: Sequence[str] = (),
) -> tuple[Variables, dict[str, Any], dict[str, Any]]:
    """`statistics` without contacts: variables, coordinates and attributes."""
    late = _records_from(run, start)
    time = run.variables["time"].values[late]
    step = float(np.diff(time[:2])[0])
    growing = float(time[0]) < float(run.attrs.get("wave_ramp", 0.0))
    slowest = _lowest_of_waves(run.variables["wave_elevation"].values[late], step)
    how = step, exposure, slowest, "contact_group" in run.dims
    variables: Variables = {}
    coords: dict[str, Any] = {}
    for name, (variable, dims, unit) in CHANNEL_VARIABLES.items():
        if variable in run:
            series = run.variables[variable].isel(time=late).transpose(*dims, "time")
            lowest = np.full(series.shape[:-1], lowest_value(variable))
            variables |= _statistics_of_channels(name, series, lowest, how, growing, unit)
    if "fender_force" in variables:
        names = [f"{FENDER_NORMAL_FORCE}.{fender}" for fender in run.fender.values]
        variables |= _replace_means_by_impulses(
            "fender_force", run.isel(time=late), names, variables
        )
    if channels:
        named, coords = _requested_channels(run, late, channels)
        lowest = np.array([lowest_value(channel) for channel in channels])
        variables |= _statistics_of_channels(
            NAMED_CHANNELS, named, lowest, how, growing, OF_CHANNEL
        )
        variables |= _statistics_by_phase(run, late, named.values, step)
        variables |= _replace_means_by_impulses(
            NAMED_CHANNELS, run.isel(time=late), channels, variables
        )
    if _has_phases(run, late):
        _leave_out_laws(variables)
    places = run.variables["position"].transpose(*MOTION_DIMS, "time").values[..., late]
    frequency, spectrum = _spectrum_of_series(places, step)
    attributes_of_density = quantity_attributes("one-sided spectral density", "m^2 s/rad or rad s")
    variables["motion_spectrum"] = ((*MOTION_DIMS, "frequency"), spectrum, attributes_of_density)
    coords["frequency"] = describe_values("frequency", frequency, "angular frequency", "rad/s")
    attributes = {
        "title": run.attrs["title"],
        "start": start,
        "exposure": step * time.size if exposure is None else exposure,
        "wave_ramp": float(run.attrs.get("wave_ramp", 0.0)),
    }
    return variables, _shared_coordinates(run, variables) | coords, attributes


def _records_from(run: xr.Dataset, start: float) -> slice:
    """Records from ``start`` [s] on. The last record of a run is left out if it is not a whole
    output step after the record before it."""
    time = run.variables["time"].values
    first = int(np.searchsorted(time, start))
    steps = np.diff(time[first:].astype(float))
    odd = steps.size > 1 and abs(steps[-1] - steps[0]) > STEP_TOLERANCE * steps[0]
    return slice(first, time.size - int(odd))


def _shared_coordinates(run: xr.Dataset, variables: Variables) -> dict[str, Any]:
    """Coordinates of the variables ``variables``: those of the run, and names of their own."""
    dims = {dim for over, *_ in variables.values() for dim in over}
    of_run = {str(name): run.variables[name] for name in run.coords}
    of_run = {name: coordinate for name, coordinate in of_run.items() if {*coordinate.dims} <= dims}
    own_coordinates: dict[str, Any] = {
        name: list(labels) for name, labels in OWN_COORDINATES.items() if name in dims
    }
    own_coordinates["statistic_unit"] = (
        "statistic",
        [UNITS_APART.get(name, AS_CHANNEL) for name in STATISTIC_NAMES],
    )
    return of_run | own_coordinates


def _requested_channels(
    run: xr.Dataset, late: slice, names: Sequence[str]
) -> tuple[xr.Variable, dict[str, Any]]:
    """Channels (channel, time) by name, with names and units as coordinates."""
    values, units = zip(*(channel_series(run, name) for name in names), strict=True)
    coords = {"channel": list(names), "unit": ("channel", list(units))}
    return xr.Variable(("channel", "time"), np.array(values)[:, late]), coords


def _statistics_by_phase(
    run: xr.Dataset, late: slice, series: np.ndarray, step: float
) -> Variables:
    """Statistics of channels in the phases of each group of contacts; NaN if a phase has fewer than
    `MIN_SAMPLES` values."""
    if "contact_group" not in run.dims:
        return {}
    phases = _phases_of_groups(run, late)
    nothing = np.full((len(series), len(STATISTIC_NAMES)), np.nan)
    figures_by_phase = [
        [
            [_moments_of_series(x[of == phase], step) for x in series]
            if np.count_nonzero(of == phase) >= MIN_SAMPLES
            else nothing
            for phase in Phase
        ]
        for of in phases
    ]
    dims = ("contact_group", "phase", "channel", "statistic")
    phase_attributes = (
        quantity_attributes("statistics of a channel in a phase", OF_CHANNEL) | OWN_UNITS
    )
    return {f"{NAMED_CHANNELS}_phase": (dims, np.array(figures_by_phase), phase_attributes)}


def _statistics_of_channels(
    name: str,
    series: xr.Variable,
    lowest: np.ndarray,
    how: ExtremesArguments,
    growing: bool,
    unit: str,
) -> Variables:
    """Statistics, extremes and their basis of all channels of a variable, along its dimensions. The
    channels are never below the ``lowest`` of each. Other arguments are those of `extremes`;
    ``growing`` says that the waves still grow."""
    dims = tuple(map(str, series.dims[:-1]))
    size = series.shape[:-1]
    channels = series.values.reshape(-1, series.shape[-1])
    figures = [_moments_of_series(x, how[0]) for x in channels]
    sides = [_channel_extremes(x, how, growing) for x in channels]
    values = np.array([[side[:-1] for side in both] for both in sides])
    values = np.maximum(values, lowest.reshape(-1, 1, 1))
    basis = np.array([[side.basis for side in both] for both in sides], dtype=np.int8)
    extreme_attributes = quantity_attributes(
        "most probable extreme and interval, prediction interval", unit
    )
    return {
        name: (
            (*dims, "statistic"),
            np.reshape(figures, (*size, -1)),
            quantity_attributes(name.replace("_", " "), unit) | OWN_UNITS,
        ),
        f"{name}_extreme": (
            (*dims, "side", "extreme"),
            np.reshape(values, (*size, len(EXTREME_SIDES), -1)),
            {**extreme_attributes, "interval_probability": INTERVAL_PROBABILITY},
        ),
        f"{name}_basis": ((*dims, "side"), basis.reshape(*size, -1), _basis_flags()),
    }


def _moments_of_series(x: np.ndarray, step: float) -> list[float]:
    """Values of `STATISTIC_NAMES`. significant is four standard deviations, a double amplitude.
    period is the mean time between upcrossings of the mean, NaN if there are fewer than two.
    skewness and kurtosis are the mean third and fourth powers of (x - mean) / std, NaN for a
    constant. For peaks see `hydrosim.statistics.series`."""
    mean = x.mean()
    std = x.std()
    crossings = upcrossings(x - mean)
    period = np.nan
    if crossings.size > 1:
        period = step * (crossings[-1] - crossings[0]) / (crossings.size - 1)
    size = max(int(PART_FRACTION * x.size), 1)
    parts = x[:size], x[-size:]
    ends = *(part.mean() for part in parts), *(part.std() for part in parts)
    z = (
        (x - mean) / std
        if std > RECORD_ROUNDING_FRACTION * np.abs(x).max()
        else np.full(x.size, np.nan)
    )
    moments = (z**3).mean(), (z**4).mean()
    more = (*moments, *fit_weibull(peaks(x)))
    return [*map(float, (mean, std, 4.0 * std, period, *ends, x.min(), x.max(), *more))]


def _replace_means_by_impulses(
    kind: str, run: xr.Dataset, names: Sequence[str], variables: Variables
) -> Variables:
    """Replace means of force channels by means from impulses, if these differ, in the statistics
    ``variables`` of a ``kind`` and by phase. Returns the means of the records that were
    replaced."""
    dims, figures, figure_attributes = variables[kind]
    recorded = np.full(len(names), np.nan)
    for k, name in enumerate(names):
        means = means_between_records(run, name, channel_series(run, name)[0])
        if means is None:
            continue
        recorded[k] = figures[k, STATISTIC_NAMES.index("mean")]
        size = max(int(PART_FRACTION * means.size), 2)  # the first mean is not known
        parts = {"mean": means, "first_mean": means[:size], "last_mean": means[-size:]}
        for which, part in parts.items():
            figures[k, STATISTIC_NAMES.index(which)] = np.nanmean(part)
        if kind == NAMED_CHANNELS and f"{NAMED_CHANNELS}_phase" in variables:
            _replace_phase_means_by_impulses(
                variables[f"{NAMED_CHANNELS}_phase"][1][:, :, k], run, means
            )
    if np.isnan(recorded).all():
        return {}
    figure_attributes = {
        **figure_attributes,
        "long_name": "mean of the records, where impulses have another",
    }
    return {f"{kind}{RECORDED_SUFFIX}": (dims[:-1], recorded, figure_attributes)}


def _replace_phase_means_by_impulses(
    figures: np.ndarray, run: xr.Dataset, means: np.ndarray
) -> None:
    """Write means by impulses into the ``figures`` (contact_group, phase, statistic) of a
    channel."""
    for series_figures, phases in zip(figures, _phases_of_groups(run, slice(None)), strict=True):
        for phase_figures, phase in zip(series_figures, Phase, strict=True):
            if np.isfinite(phase_figures[STATISTIC_NAMES.index("mean")]):
                phase_figures[STATISTIC_NAMES.index("mean")] = np.nanmean(means[phases == phase])


def _channel_extremes(
    x: np.ndarray, how: ExtremesArguments, growing: bool
) -> tuple[RecordExtremes, RecordExtremes]:
    """Extremes of a channel; none while the waves grow."""
    if growing and refusal_reason(x) is not ExtremeModel.CONSTANT:
        return undefined_extremes(ExtremeModel.WAVES_GROW), undefined_extremes(
            ExtremeModel.WAVES_GROW
        )
    return extremes(x, *how)


def _phases_of_groups(run: xr.Dataset, late: slice) -> np.ndarray:
    """Phase (contact_group, time) of each group of contacts."""
    phases = run.variables["contact_phase"].transpose("contact_group", "time")
    return np.asarray(phases.values[:, late])


def _has_phases(run: xr.Dataset, late: slice) -> bool:
    """Whether a group of contacts is in one phase for some time and then in another."""
    if "contact_group" not in run.dims:
        return False
    phases = _phases_of_groups(run, late)
    shares = np.array([(phases == phase).mean(axis=1) for phase in Phase])
    return bool(np.any((shares > MIN_PHASE_FRACTION).sum(axis=0) > 1))


def _leave_out_laws(variables: Variables) -> None:
    """Extremes are not fitted where a channel is not stationary. In an operation this holds for all
    channels of bodies and contacts if one of them changes, because single phases may be long
    without a contact."""
    names = [
        name
        for name in (*CHANNEL_VARIABLES, NAMED_CHANNELS)
        if name != "wave" and name in variables
    ]
    bases = {name: variables[f"{name}_basis"][1] for name in names}
    if not any(np.isin(basis, CHANGES).any() for basis in bases.values()):
        return
    for name, basis in bases.items():
        by_law = np.isin(basis, LAWS)
        variables[f"{name}_extreme"][1][by_law] = np.nan
        basis[by_law] = ExtremeModel.OPERATION


def _lowest_of_waves(elevation: np.ndarray, step: float) -> float:
    return lowest_frequency(elevation, step) if np.ptp(elevation) > 0.0 else 0.0


def _spectrum_of_series(x: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [rad/s] and one-sided spectral densities by Welch's method: segments that overlap
    by half are detrended and tapered, and their spectra are averaged."""
    size = max(2 * x.shape[-1] // (SPECTRUM_SEGMENTS + 1), 2)
    segments = sliding_window_view(x, size, axis=-1)[..., :: size - size // 2, :]
    straight = scipy.signal.detrend(segments, type="linear")
    frequency, density = scipy.signal.periodogram(straight, 1.0 / step, "hann", detrend=False)
    return 2.0 * np.pi * frequency, density.mean(axis=-2) / (2.0 * np.pi)


def _basis_flags() -> dict[str, Any]:
    return {
        "long_name": "method of extremes, or reason why there are none",
        "flag_values": np.array(list(ExtremeModel), dtype=np.int8),
        "flag_meanings": " ".join(basis.name.lower() for basis in ExtremeModel),
    }
