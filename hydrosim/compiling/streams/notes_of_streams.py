"""Messages on the wind and the current that a scene has: figures that its keys do not show."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.streams.currents import draught_of
from hydrosim.forces import heights_of_wind
from hydrosim.forces.stream_load import STREAM_LOAD_KIND, StreamLoad, WindLoad
from hydrosim.scene import Scene
from hydrosim.streams.current import current_table, is_sheared
from hydrosim.streams.gusts import gust_band
from hydrosim.streams.spectra import variance
from hydrosim.streams.wind import REFERENCE_HEIGHT, MeanWind, gust_factor, mean_wind

if TYPE_CHECKING:
    from hydrosim.scene import Gusts
    from hydrosim.stepping.dynamics import Model

GUSTS = {3.0: "3 s", 60.0: "1 min"}
"""Averaging times [s] of gusts that are told."""


def said_of_streams(scene: Scene, model: Model) -> Iterator[str]:
    """Notes on gusts and profiles: what is left out, and which speed each load and hull has."""
    water = scene.environment
    wind = mean_wind(water)
    if water.gusts is not None and wind.hour_mean > 0.0:
        yield from _said_of_gusts(water.gusts, wind)
    loads = [(name, e) for name, e in scene.forces.items() if isinstance(e, StreamLoad)]
    p = STREAM_LOAD_KIND.constants_in(model)
    heights = heights_of_wind(model.elements)
    for (name, load), row in zip(loads, p.each, strict=True):
        speed = _speed(row["stream"])
        if isinstance(load, WindLoad) and water.wind_profile is not None:
            height = heights[row["gusts"]]
            yield f"{name} feels the wind at {height:.3g} m: a mean of {speed:.3g} m/s"
        elif not isinstance(load, WindLoad) and is_sheared(current_table(water)):
            yield f"{name} feels a mean current of {speed:.3g} m/s"
    if is_sheared(current_table(water)):
        for b in model.headings.turned:
            body = scene.bodies[b]
            speed = _speed(model.headings.current[b])
            yield (
                f"{body.name} feels a current of {speed:.3g} m/s, the mean over its draught of"
                f" {draught_of(body):.3g} m"
            )


def _speed(velocity: np.ndarray) -> float:
    return float(np.hypot(*velocity))


def _said_of_gusts(gusts: Gusts, wind: MeanWind) -> Iterator[str]:
    lowest, highest = gust_band(gusts)
    below, within, above = variance(gusts.spectrum, REFERENCE_HEIGHT, wind, lowest, highest)
    total = below + within + above
    each = " and ".join(
        f"{gust_factor(wind.hour_mean, REFERENCE_HEIGHT, time):.3g} over {text}"
        for time, text in GUSTS.items()
    )
    yield (
        f"gusts ({gusts.spectrum}) about {wind.hour_mean:.4g} m/s, the mean of one hour at 10 m:"
        f" standard deviation {within**0.5:.3g} m/s"
    )
    yield (
        f"gusts from {lowest:.3g} to {highest:.3g} Hz; the spectrum has {below / total:.1%} of its"
        f" variance below and {above / total:.1%} above, which is left out"
    )
    yield (
        f"largest means of the NPD wind in an hour, over its mean: {each}. Gusts act along the wind"
        " and on all bodies at the same instant"
    )
