"""Questions about the environment, and about steps for its waves.

Steepness: 2 pi Hs / (g Tz^2) of random seas is at most 1/10 (DNV-RP-C205, 3.5.4), with the mean
zero-crossing period Tz of the drawn sea. A regular wave breaks at a height of 0.142 tanh(k d)
wavelengths (Miche 1944). Current: the Gulf Stream reaches 2.5 m/s (NOAA, How fast is the Gulf
Stream?). Only tides in straits are faster.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compile.questions.query import (
    Query,
    SceneContext,
    crossing_period,
    height_of,
    peak_period,
    text_beyond,
    text_outside_range,
)
from hydrosim.scene import Jonswap, Tma
from hydrosim.water.database_limits import Outside, shares_outside

if TYPE_CHECKING:
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Body

# kg/m^3, m/s^2
DENSITIES = (990.0, 1035.0)
GRAVITIES = (9.75, 9.85)
# m/s
CURRENT = 2.5
WIND = 70.0
FEELERS = {
    "current": "expected a current_load, quadratic_damping, or linear_damping with"
    " relative_to_current",
    "wind": "expected a wind_load",
}
# m; s
HIGHEST = 20.0
PERIODS = (1.0, 30.0)
STEEPEST = 0.1
SHARPEST = 20.0  # peak enhancement: long swell is modelled with up to 15
MICHE = 0.142
MOST_STEPS = 1e9  # of a run: about an hour
MIN_STEPS_PER_PERIOD = 10.0  # fewest steps of a method in a period of the waves


def ask_about_water(about: SceneContext) -> Iterator[Query]:
    """Ask about density and gravity of another liquid or planet."""
    environment = about.scene.environment
    (low, high) = DENSITIES
    if not any(about.floating_bodies()):
        return
    if not low <= environment.water_density <= high:
        found_text = f"{environment.water_density:g} kg/m^3"
        usual = f"usual is {low:g} to {high:g}"
        yield Query("environment.water_density", found_text, usual)
    low, high = GRAVITIES
    if not low <= environment.gravity <= high:
        found_text = f"{environment.gravity:g} m/s^2"
        usual = f"usual is {low:g} to {high:g}"
        yield Query("environment.gravity", found_text, usual)


def ask_about_streams(about: SceneContext) -> Iterator[Query]:
    """Ask about currents as fast as wind, winds beyond any storm, and streams that load no
    element."""
    environment = about.scene.environment
    felt = {
        stream for element in about.scene.forces.values() for stream in element.dragging_streams()
    }
    for name, stream, limit in (
        ("current", environment.current, CURRENT),
        ("wind", environment.wind, WIND),
    ):
        if stream.speed > limit:
            usual = f"usual is up to {limit:g} m/s"
            advice = "Is it in knots?"
            yield Query(f"environment.{name}.speed", f"{stream.speed:g} m/s", usual, advice)
        if stream.speed > 0.0 and name not in felt:
            yield Query(
                f"environment.{name}",
                f"{stream.speed:g} m/s and no force element that it loads",
                FEELERS[name],
                "Without such an element, no body drifts with it.",
            )


def ask_about_waves(about: SceneContext) -> Iterator[Query]:
    """Ask about seas that are higher, shorter, longer or more regular than real seas."""
    yield from _peaks(about)
    for sea in about.sea:
        height = height_of(sea)
        peak = peak_period(sea)
        if height > HIGHEST:
            usual = f"usual is up to {HIGHEST:g} m"
            yield Query("environment.waves", f"a height of {text_beyond(height, HIGHEST)} m", usual)
        if not PERIODS[0] <= peak <= PERIODS[1]:
            usual = f"usual is {PERIODS[0]:g} to {PERIODS[1]:g} s"
            found_text = f"a period of {text_outside_range(peak, *PERIODS)} s"
            yield Query("environment.waves", found_text, usual)


def _peaks(about: SceneContext) -> Iterator[Query]:
    """Ask about spectra with a peak that no wind sea or swell has."""
    for train in about.scene.environment.waves:
        if isinstance(train.spectrum, Jonswap | Tma) and train.spectrum.peak_enhancement > SHARPEST:
            found_text = f"{text_beyond(train.spectrum.peak_enhancement, SHARPEST)}"
            yield Query("environment.waves.peak_enhancement", found_text, "usual is 1 to 7")


def ask_about_steepness(about: SceneContext) -> Iterator[Query]:
    """Ask about waves that would have broken."""
    environment = about.scene.environment
    for sea in about.sea:
        height = height_of(sea)
        period = crossing_period(sea)
        if sea.omega.size == 1:
            k = float(sea.wavenumber[0])
            steep = height * k / (2.0 * np.pi)
            limit = MICHE * np.tanh(k * environment.water_depth)
            what = f"waves of {height:.3g} m"
        else:
            steep = 2.0 * np.pi * height / (environment.gravity * period**2)
            limit = STEEPEST
            what = f"a significant height of {height:.3g} m"
        if steep > limit:
            steepness_text = text_beyond(steep, limit, ".2g")
            found_text = (
                f"{what} at a mean period of {period:.3g} s, a steepness of {steepness_text}"
            )
            usual = f"waves break above {limit:.2g}"
            yield Query(
                "environment.waves", found_text, usual, "Linear waves do not describe such a sea."
            )


def ask_about_ramp(about: SceneContext) -> Iterator[Query]:
    """Ask about ramps that last longer than the run."""
    for sea in about.sea:
        if sea.ramp > about.end:
            found_text = f"{sea.ramp:g} s"
            usual = f"usual is a ramp within the run, which ends at {about.end:g} s"
            yield Query(
                "environment.waves.ramp",
                found_text,
                usual,
                "The sea never reaches its full height.",
            )


def ask_about_step(about: SceneContext) -> Iterator[Query]:
    """Ask about steps that are too large for the waves, or so small that a run takes hours."""
    solver = about.scene.solver
    duration = about.scene.duration
    free = solver.method.adapts or about.derived.exact
    if not free and duration > MOST_STEPS * solver.step:
        found_text = f"{solver.step:g} s, {duration / solver.step:.1e} steps of {duration:g} s"
        usual = f"usual is up to {MOST_STEPS:g} steps, which may take an hour"
        yield Query("solver.step", found_text, usual, refused=True)
    for sea in about.sea:
        period = peak_period(sea)
        if about.scene.output_step > period / 2.0:
            usual = f"usual is far below the waves' period, {period:.3g} s"
            advice = "Records and their statistics miss the motion in waves."
            yield Query("output.step", f"{about.scene.output_step:g} s", usual, advice)
    for sea in () if free else about.sea:
        period = peak_period(sea)
        if solver.step > period / MIN_STEPS_PER_PERIOD:
            usual = f"usual is up to a tenth of the waves' period, {period:.3g} s"
            yield Query("solver.step", f"{solver.step:g} s", usual)


# Questions about waves outside the frequencies of a database.

# fraction of the energy of the loads, or of the waves if the loads are unknown
OUTSIDE_REFUSED = 0.01


def ask_about_ranges(about: SceneContext) -> Iterator[Query]:
    """Ask about seas with too much energy outside the frequencies of a database."""
    for _, body, db in about.floating_bodies():
        if about.sea and body.wave_forces.first_order:
            range_loss = shares_outside(db, about.sea)
            if range_loss.share > OUTSIDE_REFUSED:
                usual = f"usual is up to {OUTSIDE_REFUSED:.0%} of the energy of the loads"
                advice = (
                    "Waves there have no first-order loads. Use a database with a wider range,"
                    " or other waves."
                )
                found_in_words = outside_range_text(range_loss, body, db)
                yield Query("environment.waves", found_in_words, usual, advice, refused=True)


def outside_range_text(range_loss: Outside, body: Body, db: HydroDatabase) -> str:
    """Text on the part of a sea outside the frequencies of the database of a body."""
    low, high = db.frequency[[0, -1]]
    text = (
        f"{range_loss.below + range_loss.above:.1%} of the waves' energy outside the frequencies of"
        f" the database of {body.name}, {low:.3g} to {high:.3g} rad/s"
    )
    if range_loss.loads is None or range_loss.above == 0.0:
        return text
    return (
        f"{text}, with an estimated fraction {range_loss.below + range_loss.loads:.2g} of the"
        " energy of its loads"
    )
