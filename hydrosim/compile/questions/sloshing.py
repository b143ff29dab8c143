"""Questions about sloshing in tanks, which is not modelled: surfaces stay level.

The lowest mode of a box of breadth b, filled to h, has omega^2 = g k tanh(k h), k = pi / b (Lamb
1932, Hydrodynamics, section 257). For other shapes, b is the extent of the free surface. Rules of
classification societies keep this period at least 20 % away from the periods of the ship.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compile.questions.query import Query, SceneContext, natural_periods
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.linear import modes
from hydrosim.linear.linearise import linearise, without_waves
from hydrosim.scene import Body, Box, FreeSurface, Tank, TankMesh, TankShape, TankTable
from hydrosim.tanks.contents import changing_tanks, level_of, tank_names, unforeseen_tanks
from hydrosim.tanks.shapes import height, volume_at
from hydrosim.tanks.timeline import integrate_tanks

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hydrosim.database.database import HydroDatabase
    from hydrosim.water.components import WaveComponents

WAVE_RESONANCE_RTOL = 0.1  # of the period: waves within it make the fluid slosh
MIN_RESONANT_ENERGY_SHARE = 0.1  # of the waves' energy within `WAVE_RESONANCE_RTOL`
BODY_RESONANCE_RTOL = 0.2  # of the period: a mode of the body within it drives the fluid
REACHED = 0.01  # of the waves' energy within `WAVE_RESONANCE_RTOL` of that mode of the body
MATTERS = 0.01  # of the mass of the body
MIN_LEVEL_FRACTION = 0.01  # of the height: an empty or full tank does not slosh
LEVELS = 41  # between the lowest and the highest level of the run


# motions that excite sloshing along x, y
SLOSHING_DOFS = (("surge", "pitch", "yaw"), ("sway", "roll", "yaw"))


class SloshingResonance(NamedTuple):
    """A tank, the levels (n,) at which it is near resonance, their periods and fractions of wave
    energy. ``rolls`` says whether the roll of the body is near such a period."""

    tank: Tank
    level: np.ndarray
    period: np.ndarray
    share: np.ndarray
    rolls: bool


def ask_about_sloshing(about: SceneContext) -> Iterator[Query]:
    """Ask about tanks whose fluid would slosh with the waves, or with the roll of their body."""
    for b, body, db in about.floating_bodies():
        levels = dict(_levels(about, body)) if about.sea else {}
        for axis, driven in enumerate(SLOSHING_DOFS if levels else ()):
            if not set(driven) & set(body.dofs):
                continue
            roll = _roll_period(about, b, body, db) if axis == 1 else np.inf
            candidates = (_resonance(about, body, *item, axis, roll) for item in levels.items())
            resonances = [hit for hit in candidates if hit is not None]
            if sum(map(_fluid, resonances)) > MATTERS * body.mass:
                yield _query(body, resonances, axis, roll)


def _roll_period(about: SceneContext, i: int, body: Body, db: HydroDatabase) -> float:
    """Natural period [s] in roll of body ``i`` at the start, as `hydrosim linear` computes it, with
    the free surfaces of tanks and all restoring forces. Infinite if it does not roll."""
    calm = without_waves(about.model)
    try:
        periods = modes.natural_periods(linearise(calm, about.state))
    except InputError:  # forces of constraints are not defined, or there is no inertia
        return natural_periods(about, i, body, db).get("roll", np.inf)
    return periods.get(6 * i + DOFS.index("roll"), np.inf)


def _fluid(hit: SloshingResonance) -> float:
    """Mass of the fluid at the highest level near resonance [kg]."""
    return hit.tank.density * volume_at(hit.tank.shape, float(hit.level.max()))


def _query(body: Body, resonances: Sequence[SloshingResonance], axis: int, roll: float) -> Query:
    worst = max(resonances, key=lambda hit: float(hit.share.max()))
    names = ", ".join(hit.tank.name for hit in resonances)
    rolls = f", and a roll of about {roll:.3g} s" if any(hit.rolls for hit in resonances) else ""
    return Query(
        f"bodies.{body.name}.tanks ({names})",
        f"fluid that sloshes along {'xy'[axis]} with a period of {_range(worst.period)} s at"
        f" levels of {_range(worst.level)} m ({worst.tank.name}), with a fraction of"
        f" {worst.share.max():.2g} of the wave energy within {WAVE_RESONANCE_RTOL:.0%} of such a"
        f" period{rolls}",
        f"usual is a period {BODY_RESONANCE_RTOL:.0%} away from those of waves and roll",
        "The model keeps the fluid level, without sloshing. Divide the tanks, avoid these levels"
        " in such waves, or take the loads from a computation of sloshing.",
    )


def _range(values: np.ndarray) -> str:
    low, high = f"{values.min():.3g}", f"{values.max():.3g}"
    return low if low == high else f"{low} to {high}"


def _resonance(
    about: SceneContext, body: Body, tank: Tank, level: np.ndarray, axis: int, roll: float
) -> SloshingResonance | None:
    """Resonance of a tank; None if it has none at any ``level`` (n,)."""
    full = height(tank.shape)
    level = level[(level > MIN_LEVEL_FRACTION * full) & (level < (1.0 - MIN_LEVEL_FRACTION) * full)]
    widths = np.array([surface_width(tank.shape, float(x), axis) for x in level])
    level = level[widths > 0.0]
    widths = widths[widths > 0.0]
    period = mode_period(widths, level, about.scene.environment.gravity)
    angle = body.heading + body.position[5] + 0.5 * np.pi * axis
    share = np.array([_share(about.sea, angle, T, WAVE_RESONANCE_RTOL) for T in period])
    reached = np.array([_share(about.sea, angle, T, BODY_RESONANCE_RTOL) for T in period])
    rolls = (np.abs(period / roll - 1.0) < BODY_RESONANCE_RTOL) & (reached > REACHED)
    hit = (share > MIN_RESONANT_ENERGY_SHARE) | rolls
    if not hit.any():
        return None
    return SloshingResonance(tank, level[hit], period[hit], share[hit], bool(rolls.any()))


def mode_period(breadth: np.ndarray, level: np.ndarray, gravity: float) -> np.ndarray:
    """Period (n,) [s] of the lowest mode across a ``breadth`` (n,) [m]."""
    k = np.pi / breadth
    return np.asarray(2.0 * np.pi / np.sqrt(gravity * k * np.tanh(k * level)))


def surface_width(shape: TankShape, level: float, axis: int) -> float:
    """Extent [m] of the free surface along an axis."""
    match shape:
        case Box():
            return float(shape.high[axis] - shape.low[axis])
        case TankTable():
            area = np.interp(level, shape.level, np.gradient(shape.volume, shape.level))
            second = np.interp(level, shape.level, shape.surface[:, 2 * axis])
            return float(np.sqrt(12.0 * second / area))
        case TankMesh():
            return _width_of_mesh(shape.corners, level, axis)


def _width_of_mesh(corners: np.ndarray, level: float, axis: int) -> float:
    """Extent of the section of triangles (nt, 3, 3) at a level."""
    above = corners[..., 2] - corners[..., 2].min() - level
    ends, over = np.roll(corners, -1, axis=1), np.roll(above, -1, axis=1)
    cut = (above > 0.0) != (over > 0.0)
    part = above[cut] / (above[cut] - over[cut])
    here = corners[cut][:, axis]
    return float(np.ptp(here + part * (ends[cut][:, axis] - here)))


def _share(seas: Sequence[WaveComponents], angle: float, period: float, near: float) -> float:
    """Fraction of wave energy within ``near`` of a period, and along a direction at an ``angle``
    [rad]."""
    total = sum(float(np.sum(sea.amplitude**2)) for sea in seas)
    within = 0.0
    for sea in seas:
        hit = np.abs(2.0 * np.pi / (sea.omega * period) - 1.0) < near
        along = np.cos(sea.heading[hit] - angle)
        within += float(np.sum((sea.amplitude[hit] * along) ** 2))
    return within / total


def _levels(about: SceneContext, body: Body) -> Iterator[tuple[Tank, np.ndarray]]:
    """Levels (n,) of tanks with a free surface during the run. A tank that is pumped by events may
    become empty or full."""
    names = tank_names(about.scene)
    p = about.model.tanks
    timeline = integrate_tanks(p, about.end) if names else None
    unforeseen = unforeseen_tanks(body)
    for tank in body.tanks:
        if tank.surface == FreeSurface.FROZEN:
            continue
        ends = np.array([tank.level])
        if tank.name in unforeseen:
            ends = np.array([0.0, height(tank.shape)])
        elif timeline is not None and tank in changing_tanks(body):
            k = names.index(f"{tank.name} of {body.name}")
            ends = level_of(p, k, timeline.volume[:, k])
        yield tank, np.unique(np.linspace(ends.min(), ends.max(), LEVELS))
