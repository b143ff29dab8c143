"""Limits of linear scenes, from response spectra: no runs.

A motion is Gaussian, and its standard deviation goes with the height of the sea. The limit is the
height in which it stays within its limits with the probability that is asked for
(`hydrosim.statistics.gaussian`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf, log, sqrt
from typing import TYPE_CHECKING

import numpy as np
import scipy

from hydrosim.analysis.response import Responder, at_rest, responder
from hydrosim.compile.compile import Radiation, compile_for_linear
from hydrosim.dofs import DOFS
from hydrosim.scene import Scene, SecondOrder
from hydrosim.statistics.gaussian import LEVEL_RANGE, Excursions, find_excursions
from hydrosim.study.seas import Sea, scene_in_sea
from hydrosim.water.components import sea as drawn

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled
    from hydrosim.statistics.figures import RequestedStatistic

DERIVATIVE_ORDERS = {"position": 0, "velocity": 1, "acceleration": 2}
"""Channels that are linear in the motions, and how often they are derived."""
STATISTICS_ABOUT_MEAN = ("largest", "smallest", "largest_absolute", "std")


class Spectral:
    """A linear scene, and limits of its motions."""

    def __init__(self, calm: Compiled) -> None:
        self.scene = calm.scene
        rest = at_rest(calm, free=True)
        self.rest = rest.position
        self.about: Responder = responder(calm, rest.state)

    def limit(
        self, sea: Sea, figure: RequestedStatistic, limit: float, probability: float
    ) -> float:
        """The significant height [m] up to which a ``figure`` stays within its ``limit`` with this
        probability, infinite where waves do not move it; 0 if it never does."""
        (waves,) = drawn(scene_in_sea(self.scene, replace(sea, swell=None), 1.0, 1).environment)
        name, body, dof = figure.channel.split(".")
        names = [body.name for body in self.scene.bodies]
        order = DERIVATIVE_ORDERS[name]
        at = 6 * names.index(body) + DOFS.index(dof)
        energy = 0.5 * np.abs(self.about.motions(waves)[:, at] * waves.omega**order) ** 2
        m0, m1, m2 = (float(energy @ waves.omega**n) for n in range(3))
        if m0 == 0.0:
            return inf
        mean = self.rest.ravel()[at] if order == 0 else 0.0
        duration = self.scene.duration - max(waves.ramp, figure.start)
        motion = find_excursions(m0, m1, m2, duration)
        rooms = _room_for_waves(figure.statistic, limit, mean)
        if min(rooms) <= 0.0:
            return 0.0
        if figure.statistic == "std":
            return limit / sqrt(m0)
        return _allowed_deviation(rooms, motion, probability) / sqrt(m0)


def spectral(scene: Scene, figures: Sequence[RequestedStatistic], swell: bool) -> Spectral | str:
    """What gives limits by spectra; or, in words, why runs are needed."""
    for figure in figures:
        name, *rest = figure.channel.split(".")
        if name not in DERIVATIVE_ORDERS or len(rest) != 2 or rest[1] not in DOFS:
            return f"{figure.channel or figure} is no motion of a body"
        if figure.statistic not in STATISTICS_ABOUT_MEAN or figure.phase is not None:
            return f"{figure} has no closed form"
    if swell:
        return "there is swell"
    if any(body.wave_forces.second_order != SecondOrder.NONE for body in scene.bodies):
        return "second-order loads are not Gaussian"
    calm = compile_for_linear(scene, Radiation.MODEL)
    reasons = calm.derived.nonlinear
    return reasons[0] if reasons else Spectral(calm)


def _room_for_waves(statistic: str, limit: float, mean: float) -> list[float]:
    """What is left for the waves, on one side of the mean or on both."""
    match statistic:
        case "smallest":
            return [mean - limit]
        case "largest":
            return [limit - mean]
        case "largest_absolute":
            return [limit - mean, limit + mean]
    return [limit]


def _allowed_deviation(rooms: list[float], motion: Excursions, probability: float) -> float:
    """The standard deviation of which a ``motion`` is within the ``rooms`` with this
    probability."""
    room = min(rooms)

    def excess(part: float) -> float:
        return motion.log_inside([room_ / (part * room) for room_ in rooms]) - log(probability)

    return room * float(scipy.optimize.brentq(excess, *LEVEL_RANGE, xtol=1e-12))
