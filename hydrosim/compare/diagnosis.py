"""What the difference between a recording and ours is, in words.

The recorded series is fitted as gain * ours(t - lag) + offset; what of that explains the difference
is named: a wrong sign or unit by its gain, then gain, lag and offset, each if the fit without it is
clearly worse. Where waves of the same spectrum do not correlate it is another realisation; where
they are a small part of what correlates otherwise, that is said of the waves alone.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import log

import numpy as np

from hydrosim.compare.align import Pair
from hydrosim.compare.figures import Figures, varies
from hydrosim.compare.signals import Fit, fit, rms, split_bands
from hydrosim.documents.units import factor

EQUAL = 1e-3  # rms over std: what differs less is not told apart
ALIKE = 0.8  # correlation: what is less is no gain, lag or offset
UNLIKE = 0.5  # correlation in the wave band: what is less is of other waves
SPECTRUM = 1.5  # ratio of std in the wave band: what is more is another spectrum
WAVES = 0.05  # of the std: what is less in the wave band is none
CLEAR = 0.3  # of the rms: an effect that is named
MOSTLY = 0.7  # of the mean square
NEAR = 0.03  # of a gain, to be that of units
ROUNDING = 1e-12  # of the largest value
UNITS = {  # that are taken for ours
    "m": ("mm", "cm", "ft"),
    "m/s": ("mm/s", "cm/s", "km/h", "ft/s"),
    "rad": ("deg",),
    "rad/s": ("deg/s",),
    "N": ("kN", "MN", "tonne_force", "lbf"),
    "N m": ("kN*m", "MN*m", "tonne_force*m"),
    "J": ("kJ", "MJ"),
}
WORDS = {"deg": "degrees", "rad": "radians", "tonne_force": "tonne-force"}


def diagnose(
    time: np.ndarray,
    pair: Pair,
    found: Figures,
    fitted: Fit,
    edges: tuple[float, float],
    most: float,
) -> str:
    """One line about a pair, of which the figures and the fit are known; lags up to ``most`` [s]
    are looked for."""
    ours, recorded = pair.ours, pair.recorded
    largest = float(np.abs(np.concatenate([ours, recorded])).max())
    if largest == 0.0:
        return "both zero"
    if found.peak <= 1.001 * pair.precision + ROUNDING * largest:
        return f"equal to print precision ({pair.precision:.2g} {pair.unit})"
    if found.std == 0.0 or varies(ours) == 0.0:
        return _constant(pair, found, varies(ours))
    if found.relative < EQUAL:
        return f"equal within {100.0 * found.relative:.2g} % of the std"
    other = _other_waves(time, pair, edges, most)
    if other and abs(fitted.correlation) < UNLIKE:
        return "another realisation (same spectrum, no correlation): another seed?"
    if abs(fitted.correlation) < ALIKE:
        said = f"other (correlation {fitted.correlation:.2f}){_where(found)}"
    else:
        said = ", ".join(_named(time, pair, found, fitted, most))
    return f"{said}; its waves, {_share(found)}, are another realisation" if other else said


def _share(found: Figures) -> str:
    """How much of what was recorded is in the wave band."""
    return f"{100.0 * found.band_recorded[1] / found.std:.2g} % of the std"


def _constant(pair: Pair, found: Figures, ours: float) -> str:
    if found.std == 0.0 and ours == 0.0:
        offset = float(pair.recorded.mean() - pair.ours.mean())
        return f"both constant, offset {_amount(offset, pair.unit)}"
    return "constant in the " + ("recording" if found.std == 0.0 else "run")


def _other_waves(time: np.ndarray, pair: Pair, edges: tuple[float, float], most: float) -> bool:
    """True if there are waves in both, of the same spectrum, that do not correlate at any lag."""
    a, r = (split_bands(time, x, edges)[1] for x in (pair.ours, pair.recorded))
    sizes = float(np.std(a)), float(np.std(r))
    if min(sizes) < WAVES * min(np.std(pair.ours), np.std(pair.recorded)):
        return False
    if not 1.0 / SPECTRUM < sizes[0] / sizes[1] < SPECTRUM:
        return False
    even = np.linspace(time[0], time[-1], time.size)
    return abs(fit(even, a, r, most).correlation) < UNLIKE


def _named(time: np.ndarray, pair: Pair, found: Figures, fitted: Fit, most: float) -> Iterator[str]:
    """What there is: sign, unit, gain, lag, offset, and how much is left."""
    sign = float(np.sign(fitted.gain))
    unit, size = _unit_taken(abs(fitted.gain), pair.unit)
    if sign < 0.0:
        yield "sign swapped"
    if unit:
        yield unit
    mended = sign * pair.recorded / size
    before = rms(mended - pair.ours)
    if before <= pair.precision / size:
        return
    if sign < 0.0 or unit:
        fitted = fit(time, pair.ours, mended, most)
    causes = list(_causes(fitted, pair.unit, before))
    yield from causes
    std = found.std / size
    if causes and fitted.rest > max(EQUAL * std, CLEAR * before):
        yield f"{100.0 * fitted.rest / std:.3g} % of the std left"
    if not causes and before > EQUAL * std:
        yield f"apart by {100.0 * before / std:.3g} % of the std{_where(found)}"


def _causes(fitted: Fit, unit: str, before: float) -> Iterator[str]:
    """Gain, lag and offset, those that matter."""
    if fitted.gain_effect > CLEAR * before:
        yield f"gain {fitted.gain:.4g}"
    if fitted.lag_effect > CLEAR * before:
        yield f"{'late' if fitted.lag > 0.0 else 'early'} by {abs(fitted.lag):.3f} s"
    if fitted.offset_effect > CLEAR * before:
        yield f"offset {_amount(fitted.offset, unit)}"


def _unit_taken(gain: float, ours: str) -> tuple[str, float]:
    """Which unit was taken for which, and the gain of that; "" and 1 if none."""
    for other in UNITS.get(ours, ()):
        size = factor(other, ours)
        for text, expected in (
            (f"{_word(other)} for {_word(ours)}", 1.0 / size),
            (f"{_word(ours)} for {_word(other)}", size),
        ):
            if abs(log(gain / expected)) < NEAR:
                return text, expected
    return "", 1.0


def _word(unit: str) -> str:
    return WORDS.get(unit, unit)


def _where(found: Figures) -> str:
    """In which band of frequencies the difference is, if it is mostly in one."""
    squares = np.square(found.band_rms)
    squares[0] += found.mean**2
    worst = int(np.argmax(squares))
    if squares[worst] < MOSTLY * squares.sum():
        return ""
    return f", mostly {('slow', 'in the wave band', 'fast')[worst]}"


def _amount(value: float, unit: str) -> str:
    """A value in the unit that people read."""
    return f"{np.degrees(value):.3g} deg" if unit == "rad" else f"{value:.3g} {unit}"
