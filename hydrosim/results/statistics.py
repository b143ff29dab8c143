"""Statistics of a run: moments, periods, extremes, spectra, and what friction did.

Extremes are maxima between upcrossings of the mean. A Weibull distribution is fitted to those above
their median (two parameters, least squares on its probability paper); from it follow the most
probable largest of the run and, by Gumbel's law of largest values, its 90 % interval (Ochi 1990,
chapter 4, Applied Probability and Stochastic Processes).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr
from scipy import signal

from hydrosim.results.phases import Phase

NAMES = ("mean", "std", "significant", "period", "maximum", "lower", "upper", "smallest", "largest")
INTERVAL = 0.9  # probability of the largest value's interval
ALIKE = 1e-6  # maxima that differ by less are one, as those of a regular wave
FEWEST = 20  # maxima, to fit their distribution to
SEGMENTS = 8  # of a run, whose spectra are averaged
CRAWL = 60.0  # s: mean of the place at the ends of a phase
MOTION = ("body", "dof")


def statistics(run: xr.Dataset, start: float = 0.0) -> xr.Dataset:
    """Statistics of motions and of the wave from ``start`` [s] on, by ``statistic``, and their
    spectra; and of each fender, the time in each mode, slip, and crawl by phase, of the whole run.
    """
    late = run.sel(time=slice(start, None))
    step = float(np.diff(late.time.values[:2])[0])
    motions = late.position.transpose("body", "dof", "time")
    figures = [[_figures(x, step) for x in body] for body in motions.values]
    frequency, spectrum = _spectrum(motions.values, step)
    found = {
        "motion": ((*MOTION, "statistic"), np.array(figures), _said("motion", "m, rad or s")),
        "motion_spectrum": (
            (*MOTION, "frequency"),
            spectrum,
            _said("one-sided spectral density", "m^2 s/rad, rad s"),
        ),
        "wave": ("statistic", _figures(late.wave_elevation.values, step), _said("wave", "m or s")),
    }
    coords = {
        "body": run.body.values,
        "dof": run.dof.values,
        "statistic": list(NAMES),
        "frequency": ("frequency", frequency, _said("angular frequency", "rad/s")),
    }
    dataset = xr.Dataset(found, coords=coords, attrs={"title": run.attrs["title"], "start": start})
    return dataset.assign(_fenders(run)) if "fender" in run.dims else dataset


def _figures(x: np.ndarray, step: float) -> np.ndarray:
    """The values of `NAMES`: significant is four standard deviations, a double amplitude; period
    the mean between upcrossings of the mean; maximum, lower and upper the most probable largest
    deviation from the mean and its interval; NaN what there are too few waves for."""
    mean, std = x.mean(), x.std()
    crossings = _upcrossings(x - mean)
    period = np.nan
    if crossings.size > 1:
        period = step * (crossings[-1] - crossings[0]) / (crossings.size - 1)
    extremes = np.array([np.nan] * 3)
    if crossings.size > FEWEST and std > 0.0:
        edges = np.ceil(crossings).astype(int)
        extremes = largest(np.maximum.reduceat(x - mean, edges)[:-1])
    return np.array([mean, std, 4.0 * std, period, *extremes, x.min(), x.max()])


def _upcrossings(x: np.ndarray) -> np.ndarray:
    """Where x rises through zero, in steps, by linear interpolation."""
    before = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
    return np.asarray(before + x[before] / (x[before] - x[before + 1]))


def largest(maxima: np.ndarray) -> np.ndarray:
    """Most probable largest of as many ``maxima`` (n,) as there are, and the ends of its interval,
    (3,), from a Weibull fit to the upper half."""
    ordered, n = np.sort(maxima), maxima.size
    if ordered[-1] - ordered[n // 2] <= ALIKE * ordered[-1]:
        return np.full(3, ordered[-1])
    above = 1.0 - (np.arange(1, n + 1) - 0.5) / n
    upper = slice(n // 2, None)
    x, y = np.log(ordered[upper]), np.log(-np.log(above[upper]))
    shape, offset = np.polyfit(x, y, 1)
    scale = np.exp(-offset / shape)
    # exceeded once in n; Gumbel's law of the largest about it
    quantiles = np.array([1.0, *(-np.log([(1 - INTERVAL) / 2, (1 + INTERVAL) / 2]))]) / n
    return np.asarray(scale * (-np.log(quantiles)) ** (1.0 / shape))


def _spectrum(x: np.ndarray, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [rad/s] and one-sided densities over them, by Welch's method."""
    size = max(2 * x.shape[-1] // (SEGMENTS + 1), 2)
    frequency, density = signal.welch(x, 1.0 / step, nperseg=size, detrend="linear")
    return 2.0 * np.pi * frequency, density / (2.0 * np.pi)


def _fenders(run: xr.Dataset) -> dict[str, xr.DataArray]:
    modes, phase = run.fender_mode, run.contact_phase.values
    names = modes.attrs["flag_meanings"].split()
    share = np.array([(modes.values == k).mean(axis=0) for k in range(len(names))])
    slipped = run.fender_slip_distance.isel(time=-1, drop=True)
    each = list(Phase)
    crawl = np.array([_moved(run, phase == one) for one in each])
    time = np.array([np.mean(phase == one) * np.ptp(run.time.values) for one in each])
    coords = {"phase": [one.name.lower().replace("_", " ") for one in each]}
    return {
        "fender_share": xr.DataArray(
            share,
            {"mode": names, "fender": run.fender},
            ("mode", "fender"),
            attrs=_said("share of the time", "1"),
        ),
        "fender_slipped": slipped.assign_attrs(_said("distance slipped", "m")),
        "phase_duration": xr.DataArray(time, coords, "phase", attrs=_said("duration", "s")),
        "phase_crawl": xr.DataArray(
            crawl,
            {**coords, "body": run.body, "axis": ["x", "y"]},
            ("phase", "body", "axis"),
            attrs=_said("slow displacement from beginning to end", "m"),
        ),
    }


def _moved(run: xr.Dataset, during: np.ndarray) -> np.ndarray:
    """Displacement (nb, 2) in x and y of the mean place from beginning to end of a phase."""
    place = run.position.transpose("time", "body", "dof").values[:, :, :2]
    if not during.any():
        return np.zeros(place.shape[1:])
    at = np.flatnonzero(during)[[0, -1]]
    width = max(round(0.5 * CRAWL / float(np.diff(run.time.values[:2])[0])), 1)
    ends = [place[max(k - width, 0) : k + width + 1].mean(axis=0) for k in at]
    return np.asarray(ends[1] - ends[0])


def _said(what: str, unit: str) -> dict[str, str]:
    return {"long_name": what, "units": unit}


def lines(found: xr.Dataset) -> Iterator[str]:
    """The statistics as text, a line for each motion and fender."""
    for body in found.body.values:
        for dof in found.dof.values:
            of = found.motion.sel(body=body, dof=dof)
            if float(of.sel(statistic="std")) > 0.0:
                yield f"{body} {dof}: {_text(of, str(dof) in ('roll', 'pitch', 'yaw'))}"
    if "phase_crawl" not in found:
        return
    for phase in found.phase.values:
        seconds = float(found.phase_duration.sel(phase=phase))
        for body in found.body.values:
            x, y = found.phase_crawl.sel(phase=phase, body=body).values
            yield f"{phase}: {seconds:.0f} s, {body} crawls {x:+.3f} m in x, {y:+.3f} m in y"


def _text(of: xr.DataArray, turns: bool) -> str:
    scale, unit = (180.0 / np.pi, "deg") if turns else (1.0, "m")
    at = {name: float(of.sel(statistic=name)) for name in NAMES}
    text = (
        f"mean {scale * at['mean']:.3f}, significant {scale * at['significant']:.3f} {unit},"
        f" period {at['period']:.2f} s"
    )
    if np.isnan(at["maximum"]):
        return text
    low, high = scale * at["lower"], scale * at["upper"]
    return f"{text}, most probable maximum {scale * at['maximum']:.3f} ({low:.3f} to {high:.3f})"
