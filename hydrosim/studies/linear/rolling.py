"""Viscous roll damping in the frequency domain, by stochastic linearisation.

The damping B2 |p| p + B3 p^3 of a Gaussian roll rate p of standard deviation s takes the same mean
power as (sqrt(8/pi) s B2 + 3 s^2 B3) p (`hydrosim.forces.damping.viscous_roll.linearise_damping`).
The rate depends on the damping in turn, so both are iterated in the random waves of the scene. In a
scene without random waves, the linear part B1 alone is there, for motions that are small.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.forces.damping.viscous_roll import VISCOUS_ROLL_KIND

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.studies.linear.response import Responder
    from hydrosim.waves.components import WaveComponents

ROLL_INDEX = DOFS.index("roll")
MAX_ITERATIONS = 50  # iterations
RATE_RTOL = 1e-6  # relative change of the rates at which they end


def respond(
    compiled: Compiled,
    respond_at: Callable[[np.ndarray | None], Responder],
    seas: Sequence[WaveComponents],
) -> tuple[Responder, np.ndarray | None]:
    """Linearise a scene by ``respond_at`` the roll rates [rad/s] in its ``seas``, one per element
    with viscous roll damping; the rates are None if they do not matter."""
    rolling = VISCOUS_ROLL_KIND.constants_in(compiled.model)
    about = respond_at(None)
    if not seas or not (rolling["quadratic"].any() or rolling["cubic"].any()):
        return about, None
    rates = _roll_rates(about, seas, rolling["body"])
    for _ in range(MAX_ITERATIONS):
        about = respond_at(rates)
        new_rates = _roll_rates(about, seas, rolling["body"])
        if np.abs(new_rates - rates).max() <= RATE_RTOL * rates.max():
            break
        rates = np.sqrt(new_rates * rates)
    return about, rates


def _roll_rates(about: Responder, seas: Sequence[WaveComponents], bodies: np.ndarray) -> np.ndarray:
    """Standard deviations (ne,) [rad/s] of the roll rate of each of the ``bodies`` (ne,)."""
    energy = sum(
        0.5 * np.sum(np.abs(waves.omega[:, None] * about.motions(waves)) ** 2, axis=0)
        for waves in seas
    )
    return np.sqrt(np.asarray(energy)[6 * bodies + ROLL_INDEX])


def rolling_remarks(compiled: Compiled, rates: np.ndarray | None) -> Iterator[str]:
    """Remarks on viscous roll damping that is linear for the sea, or left out."""
    rolling = VISCOUS_ROLL_KIND.constants_in(compiled.model)
    if rates is not None:
        values = ", ".join(f"{np.degrees(rate):.3g}" for rate in rates)
        yield (
            "quadratic and cubic roll damping is linearised for the roll rates in this sea, of"
            f" {values} deg/s (std). RAOs and natural modes are those of this sea; another height"
            " gives others."
        )
    elif rolling["quadratic"].any() or rolling["cubic"].any():
        yield (
            "quadratic and cubic roll damping is left out, because there are no random waves to"
            " linearise it for. Roll near resonance is too large: simulate it."
        )
