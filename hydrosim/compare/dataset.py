"""A comparison as a dataset: both series, what is between them, and the figures."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import xarray as xr

from hydrosim.compare.comparison import Comparison, Result
from hydrosim.compare.figures import BANDS, Contact

OVER_TIME = {
    "ours": "the run",
    "recorded": "the recording, in units and at the point of the run",
    "residual": "ours minus recorded",
}
PER_CHANNEL = {
    "rms": "rms of the residual",
    "relative": "rms of the residual over the std recorded",
    "std": "standard deviation recorded",
    "peak": "largest residual",
    "peak_time": "time of the largest residual [s]",
    "mean": "mean of the residual",
    "drift": "difference of drifts, from the first tenth of the time to the last",
    "correlation": "correlation",
}
OF_FIT = {
    "gain": "of recorded(t) = gain ours(t - lag) + offset",
    "lag": "of it [s]",
    "offset": "of it",
}
PER_BAND = {
    "band_rms": "rms of the residual, without its mean",
    "band_ours": "standard deviation of the run",
    "band_recorded": "standard deviation of the recording",
}
CONTACT = dict(
    zip(Contact._fields, ("first contact [s]",) * 2 + ("share of contact",) * 2, strict=True)
)


def to_dataset(found: Comparison, attributes: Mapping[str, object]) -> xr.Dataset:
    """Dimensions time, channel, band; units of a channel are in the coordinate ``units``."""
    results = list(found.results.values())
    pairs = [result.pair for result in results]
    ours, recorded = (
        np.stack(x, axis=1) for x in zip(*((p.ours, p.recorded) for p in pairs), strict=True)
    )
    data = dict(zip(OVER_TIME, (ours, recorded, ours - recorded), strict=True))
    dataset = xr.Dataset(
        {name: (("time", "channel"), values) for name, values in data.items()}
        | {name: ("channel", [getattr(r.figures, name) for r in results]) for name in PER_CHANNEL}
        | {name: ("channel", [getattr(r.fit, name) for r in results]) for name in OF_FIT}
        | {
            name: (("channel", "band"), [getattr(r.figures, name) for r in results])
            for name in PER_BAND
        }
        | {name: ("channel", [_of_contact(r, name) for r in results]) for name in CONTACT}
        | {"verdict": ("channel", [result.verdict for result in results])},
        coords={
            "time": ("time", found.overlap.time, {"units": "s", "long_name": "time of the run"}),
            "channel": ("channel", list(found.results)),
            "units": ("channel", [pair.unit for pair in pairs]),
            "column": ("channel", [pair.column for pair in pairs]),
            "band": ("band", list(BANDS)),
        },
    )
    for name, text in (OVER_TIME | PER_CHANNEL | OF_FIT | PER_BAND | CONTACT).items():
        dataset[name].attrs["long_name"] = text
    dataset.attrs.update(attributes, compared=found.overlap.method, band_edges=found.edges)
    if found.shift is not None:
        dataset.attrs["shift"] = found.shift
    return dataset


def _of_contact(result: Result, name: str) -> float:
    return float("nan") if result.contact is None else float(getattr(result.contact, name))
