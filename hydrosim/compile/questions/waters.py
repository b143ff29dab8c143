"""Questions about waves, streams, steps for them, and sloshing in tanks.

Steepness: 2 pi Hs / (g Tz^2) of random seas is at most 1/10 (DNV-RP-C205, 3.5.4), with the mean
zero-crossing period Tz of the drawn sea. A regular wave breaks at a height of 0.142 tanh(k d)
wavelengths (Miche 1944). Current: the Gulf Stream reaches 2.5 m/s (NOAA, How fast is the Gulf
Stream?). Only tides in straits are faster.

Questions about sloshing in tanks, which is not modelled: surfaces stay level.

The lowest mode of a box of breadth b, filled to h, has omega^2 = g k tanh(k h), k = pi / b (Lamb
1932, Hydrodynamics, section 257). For other shapes, b is the extent of the free surface. Rules of
classification societies keep this period at least 20 % away from the periods of the ship.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim import scene
from hydrosim.compile.questions import query
from hydrosim.dofs import DOFS
from hydrosim.elements import signals_of
from hydrosim.errors import InputError
from hydrosim.linear import modes
from hydrosim.linear.linearise import linearise, without_waves
from hydrosim.scene.signal import Harmonic
from hydrosim.tanks.contents import changing_tanks, level_of, tank_names, unforeseen_tanks
from hydrosim.tanks.shapes import height, volume_at
from hydrosim.tanks.timeline import integrate_tanks
from hydrosim.water.database_limits import Outside, shares_outside

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydrosim.database.database import HydroDatabase
    from hydrosim.water.components import WaveComponents

# Usual densities [kg/m^3] and gravity [m/s^2].
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
USUAL_PERIODS_S = (1.0, 30.0)
MAX_STEEPNESS = 0.1
MAX_PEAK_ENHANCEMENT = 20.0  # peak enhancement: long swell is modelled with up to 15
MICHE = 0.142
MOST_STEPS = 1e9  # of a run: about an hour
MIN_STEPS_PER_PERIOD = 10.0  # fewest steps of a method in a period of the waves


def ask_about_water(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about density and gravity of another liquid or planet."""
    environment = about.scene.environment
    (low, high) = DENSITIES
    if not any(about.floating_bodies()):
        return
    if not low <= environment.water_density <= high:
        found_text = f"{environment.water_density:g} kg/m^3"
        usual = f"usual is {low:g} to {high:g}"
        yield query.Query("environment.water_density", found_text, usual)
    low, high = GRAVITIES
    if not low <= environment.gravity <= high:
        found_text = f"{environment.gravity:g} m/s^2"
        usual = f"usual is {low:g} to {high:g}"
        yield query.Query("environment.gravity", found_text, usual)


def ask_about_streams(about: query.SceneContext) -> Iterator[query.Query]:
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
        speed = stream.top_speed
        if speed > limit:
            usual = f"usual is up to {limit:g} m/s"
            advice = "Is it in knots?"
            yield query.Query(f"environment.{name}.speed", f"{speed:g} m/s", usual, advice)
        if speed > 0.0 and name not in felt:
            yield query.Query(
                f"environment.{name}",
                f"{speed:g} m/s and no force element that it loads",
                FEELERS[name],
                "Without such an element, no body drifts with it.",
            )


def ask_about_waves(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about seas that are higher, shorter, longer or more regular than real seas."""
    yield from _ask_about_peaks(about)
    for sea in about.sea:
        height = query.height_of(sea)
        peak = query.peak_period(sea)
        if height > HIGHEST:
            usual = f"usual is up to {HIGHEST:g} m"
            yield query.Query(
                "environment.waves", f"a height of {query.text_beyond(height, HIGHEST)} m", usual
            )
        if not USUAL_PERIODS_S[0] <= peak <= USUAL_PERIODS_S[1]:
            usual = f"usual is {USUAL_PERIODS_S[0]:g} to {USUAL_PERIODS_S[1]:g} s"
            found_text = f"a period of {query.text_outside_range(peak, *USUAL_PERIODS_S)} s"
            yield query.Query("environment.waves", found_text, usual)


def _ask_about_peaks(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about spectra with a peak that no wind sea or swell has."""
    for train in about.scene.environment.waves:
        if (
            isinstance(train.spectrum, scene.Jonswap | scene.Tma)
            and train.spectrum.peak_enhancement > MAX_PEAK_ENHANCEMENT
        ):
            found_text = (
                f"{query.text_beyond(train.spectrum.peak_enhancement, MAX_PEAK_ENHANCEMENT)}"
            )
            yield query.Query("environment.waves.peak_enhancement", found_text, "usual is 1 to 7")


def ask_about_steepness(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about waves that would have broken."""
    environment = about.scene.environment
    for sea in about.sea:
        height = query.height_of(sea)
        period = query.crossing_period(sea)
        if sea.omega.size == 1:
            k = float(sea.wavenumber[0])
            steep = height * k / (2.0 * np.pi)
            limit = MICHE * np.tanh(k * environment.water_depth)
            what = f"waves of {height:.3g} m"
        else:
            steep = 2.0 * np.pi * height / (environment.gravity * period**2)
            limit = MAX_STEEPNESS
            what = f"a significant height of {height:.3g} m"
        if steep > limit:
            steepness_text = query.text_beyond(steep, limit, ".2g")
            found_text = (
                f"{what} at a mean period of {period:.3g} s, a steepness of {steepness_text}"
            )
            usual = f"waves break above {limit:.2g}"
            yield query.Query(
                "environment.waves", found_text, usual, "Linear waves do not describe such a sea."
            )


def ask_about_ramp(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about ramps that last longer than the run."""
    for sea in about.sea:
        if sea.ramp > about.end:
            found_text = f"{sea.ramp:g} s"
            usual = f"usual is a ramp within the run, which ends at {about.end:g} s"
            yield query.Query(
                "environment.waves.ramp",
                found_text,
                usual,
                "The sea never reaches its full height.",
            )


def ask_about_step(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about steps that are too large for the waves, or so small that a run takes hours."""
    solver = about.scene.solver
    duration = about.scene.duration
    free = solver.method.adapts or about.derived.exact
    if not free and duration > MOST_STEPS * solver.step:
        found_text = f"{solver.step:g} s, {duration / solver.step:.1e} steps of {duration:g} s"
        usual = f"usual is up to {MOST_STEPS:g} steps, which may take an hour"
        yield query.Query("solver.step", found_text, usual, refused=True)
    for sea in about.sea:
        period = query.peak_period(sea)
        if about.scene.output_step > period / 2.0:
            usual = f"usual is far below the waves' period, {period:.3g} s"
            advice = "Records and their statistics miss the motion in waves."
            yield query.Query("output.step", f"{about.scene.output_step:g} s", usual, advice)
    for key, signal in signals_of(about.scene.forces):
        if not isinstance(signal, Harmonic) or signal.amplitude == 0.0:
            continue
        if about.scene.output_step >= signal.period / 2.0:
            usual = f"usual is far below the period of {key}, {signal.period:.3g} s"
            advice = "Records, and all that is told of them, miss that motion."
            yield query.Query("output.step", f"{about.scene.output_step:g} s", usual, advice)
    for sea in () if free else about.sea:
        period = query.peak_period(sea)
        if solver.step > period / MIN_STEPS_PER_PERIOD:
            usual = f"usual is up to a tenth of the waves' period, {period:.3g} s"
            yield query.Query("solver.step", f"{solver.step:g} s", usual)


# Waves outside the frequencies of a database.

# Fraction of the energy of the loads, or of the waves if the loads are unknown
OUTSIDE_REFUSED = 0.01


def ask_about_ranges(about: query.SceneContext) -> Iterator[query.Query]:
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
                yield query.Query("environment.waves", found_in_words, usual, advice, refused=True)


def outside_range_text(range_loss: Outside, body: scene.Body, db: HydroDatabase) -> str:
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


WAVE_RESONANCE_RTOL = 0.1  # of the period: waves within it make the fluid slosh
MIN_RESONANT_ENERGY_SHARE = 0.1  # of the waves' energy within `WAVE_RESONANCE_RTOL`
BODY_RESONANCE_RTOL = 0.2  # of the period: a mode of the body within it drives the fluid
REACHED = 0.01  # of the waves' energy within `WAVE_RESONANCE_RTOL` of that mode of the body
MATTERS = 0.01  # of the mass of the body
MIN_LEVEL_FRACTION = 0.01  # of the height: an empty or full tank does not slosh
LEVELS = 41  # between the lowest and the highest level of the run


# Motions that excite sloshing along x, y
SLOSHING_DOFS = (("surge", "pitch", "yaw"), ("sway", "roll", "yaw"))


class SloshingResonance(NamedTuple):
    """A tank, the levels (n,) at which it is near resonance, their periods and fractions of wave
    energy. ``rolls`` says whether the roll of the body is near such a period."""

    tank: scene.Tank
    level: np.ndarray
    period: np.ndarray
    share: np.ndarray
    rolls: bool


def ask_about_sloshing(about: query.SceneContext) -> Iterator[query.Query]:
    """Ask about tanks whose fluid would slosh with the waves, or with the roll of their body."""
    for b, body, db in about.floating_bodies():
        levels = dict(_tank_levels(about, body)) if about.sea else {}
        for axis, driven in enumerate(SLOSHING_DOFS if levels else ()):
            if not set(driven) & set(body.dofs):
                continue
            roll = _roll_period(about, b, body, db) if axis == 1 else np.inf
            candidates = (
                _sloshing_resonance(about, body, *item, axis, roll) for item in levels.items()
            )
            resonances = [hit for hit in candidates if hit is not None]
            if sum(map(_fluid_mass, resonances)) > MATTERS * body.mass:
                yield _resonance_query(body, resonances, axis, roll)


def _roll_period(about: query.SceneContext, i: int, body: scene.Body, db: HydroDatabase) -> float:
    """Natural period [s] in roll of body ``i`` at the start, as `hydrosim analyse` computes it,
    with the free surfaces of tanks and all restoring forces. Infinite if it does not roll."""
    calm = without_waves(about.model)
    try:
        periods = modes.natural_periods(linearise(calm, about.state))
    except InputError:  # forces of constraints are not defined, or there is no inertia
        return query.natural_periods(about, i, body, db).get("roll", np.inf)
    return periods.get(6 * i + DOFS.index("roll"), np.inf)


def _fluid_mass(hit: SloshingResonance) -> float:
    """Mass of the fluid at the highest level near resonance [kg]."""
    return hit.tank.density * volume_at(hit.tank.shape, float(hit.level.max()))


def _resonance_query(
    body: scene.Body, resonances: Sequence[SloshingResonance], axis: int, roll: float
) -> query.Query:
    worst = max(resonances, key=lambda hit: float(hit.share.max()))
    names = ", ".join(hit.tank.name for hit in resonances)
    rolls = f", and a roll of about {roll:.3g} s" if any(hit.rolls for hit in resonances) else ""
    return query.Query(
        f"bodies.{body.name}.tanks ({names})",
        f"fluid that sloshes along {'xy'[axis]} with a period of {_range_text(worst.period)} s at"
        f" levels of {_range_text(worst.level)} m ({worst.tank.name}), with a fraction of"
        f" {worst.share.max():.2g} of the wave energy within {WAVE_RESONANCE_RTOL:.0%} of such a"
        f" period{rolls}",
        f"usual is a period {BODY_RESONANCE_RTOL:.0%} away from those of waves and roll",
        "The model keeps the fluid level, without sloshing. Divide the tanks, avoid these levels"
        " in such waves, or take the loads from a computation of sloshing.",
    )


def _range_text(values: np.ndarray) -> str:
    low, high = f"{values.min():.3g}", f"{values.max():.3g}"
    return low if low == high else f"{low} to {high}"


def _sloshing_resonance(
    about: query.SceneContext,
    body: scene.Body,
    tank: scene.Tank,
    level: np.ndarray,
    axis: int,
    roll: float,
) -> SloshingResonance | None:
    """Resonance of a tank; None if it has none at any ``level`` (n,)."""
    full = height(tank.shape)
    level = level[(level > MIN_LEVEL_FRACTION * full) & (level < (1.0 - MIN_LEVEL_FRACTION) * full)]
    widths = np.array([surface_width(tank.shape, float(x), axis) for x in level])
    level = level[widths > 0.0]
    widths = widths[widths > 0.0]
    period = mode_period(widths, level, about.scene.environment.gravity)
    angle = body.heading + body.position[5] + 0.5 * np.pi * axis
    share = np.array([_energy_share_near(about.sea, angle, T, WAVE_RESONANCE_RTOL) for T in period])
    reached = np.array(
        [_energy_share_near(about.sea, angle, T, BODY_RESONANCE_RTOL) for T in period]
    )
    rolls = (np.abs(period / roll - 1.0) < BODY_RESONANCE_RTOL) & (reached > REACHED)
    hit = (share > MIN_RESONANT_ENERGY_SHARE) | rolls
    if not hit.any():
        return None
    return SloshingResonance(tank, level[hit], period[hit], share[hit], bool(rolls.any()))


def mode_period(breadth: np.ndarray, level: np.ndarray, gravity: float) -> np.ndarray:
    """Period (n,) [s] of the lowest mode across a ``breadth`` (n,) [m]."""
    k = np.pi / breadth
    return np.asarray(2.0 * np.pi / np.sqrt(gravity * k * np.tanh(k * level)))


def surface_width(shape: scene.TankShape, level: float, axis: int) -> float:
    """Extent [m] of the free surface along an axis."""
    match shape:
        case scene.Box():
            return float(shape.high[axis] - shape.low[axis])
        case scene.TankTable():
            area = np.interp(level, shape.level, np.gradient(shape.volume, shape.level))
            second = np.interp(level, shape.level, shape.surface[:, 2 * axis])
            return float(np.sqrt(12.0 * second / area))
        case scene.TankMesh():
            return _width_of_mesh(shape.corners, level, axis)


def _width_of_mesh(corners: np.ndarray, level: float, axis: int) -> float:
    """Extent of the section of triangles (nt, 3, 3) at a level."""
    above = corners[..., 2] - corners[..., 2].min() - level
    ends, over = np.roll(corners, -1, axis=1), np.roll(above, -1, axis=1)
    cut = (above > 0.0) != (over > 0.0)
    part = above[cut] / (above[cut] - over[cut])
    here = corners[cut][:, axis]
    return float(np.ptp(here + part * (ends[cut][:, axis] - here)))


def _energy_share_near(
    seas: Sequence[WaveComponents], angle: float, period: float, near: float
) -> float:
    """Fraction of wave energy within ``near`` of a period, and along a direction at an ``angle``
    [rad]."""
    total = sum(float(np.sum(sea.amplitude**2)) for sea in seas)
    within = 0.0
    for sea in seas:
        hit = np.abs(2.0 * np.pi / (sea.omega * period) - 1.0) < near
        along = np.cos(sea.heading[hit] - angle)
        within += float(np.sum((sea.amplitude[hit] * along) ** 2))
    return within / total


def _tank_levels(
    about: query.SceneContext, body: scene.Body
) -> Iterator[tuple[scene.Tank, np.ndarray]]:
    """Levels (n,) of tanks with a free surface during the run. A tank that is pumped by events may
    become empty or full."""
    names = tank_names(about.scene)
    p = about.model.tanks
    timeline = integrate_tanks(p, about.end) if names else None
    unforeseen = unforeseen_tanks(body)
    for tank in body.tanks:
        if tank.free_surface == scene.FreeSurface.FROZEN:
            continue
        ends = np.array([tank.level])
        if tank.name in unforeseen:
            ends = np.array([0.0, height(tank.shape)])
        elif timeline is not None and tank in changing_tanks(body):
            k = names.index(f"{tank.name} of {body.name}")
            ends = level_of(p, k, timeline.volume[:, k])
        yield tank, np.unique(np.linspace(ends.min(), ends.max(), LEVELS))
