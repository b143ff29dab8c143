"""The drum of a winch: its controls, how fast it pays out, and the delay of its signal.

    l0' = s        l0: length of the line off the drum without load, s: speed of pay-out

Four controls set s:

    length        l0 = a signal over time
    speed         s = a signal over time
    tension       s = 0 while  T0 (1 - d - f_in) < T < T0 (1 + d + f_out)
    compensation  l0 follows a given target

With tension control the drum is stick-slip. It is stuck between both bounds. On a bound it slips:
T stays on the bound, and s is what this needs, up to the largest speed v. Beyond, s = v or -v
until T is back on the bound. d is the dead band of the control, f the friction of the drum.
Friction loses f T0 |s|; the rest of the power T s goes into the drive.

With an ``acceleration`` a the drum cannot follow a bound. Beyond a bound it speeds up at a, to at
most v, until T is back at T0. Then it slows down at a to a stop.

A drum ends at its shortest and its longest length off it: there s = 0. A compensating drum that
cannot follow its target, because |s| is limited by v, moves at v until it has caught up.

The law does not know the line. `DrumLoad` has all that it needs: the tension T of a standing drum,
its rate, and dT/dl0, dT/ds. All changes of mode are events.

A pure delay of a signal, as states of the motion.

    exp(-s tau) = product of (s^2 - a s + b) / (s^2 + a s + b), three of them

The factors are those of Pade's approximant of degree 6 (Baker & Graves-Morris 1996, chapter 1). It
changes no amplitude. Its phase is behind by w tau + 1.7e-13 (w tau)^13 for small w tau: an error of
1.7e-13 rad at w tau = 1, 1.4e-9 at 2, 4.2e-7 at pi. So its equations are ordinary ones. A method of
any order keeps that order, and a restart continues to the bit.

Each factor has two states: x1' = x2, x2' = u - b x1 - a x2, and passes u - 2 a x2 on. They are
fast, with rates of about 8.5 / tau, which limits the step of an explicit method to about 0.3 tau.
"""

from __future__ import annotations

from math import factorial, inf
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel

FACTORS = 3
DELAY_STATES = 2 * FACTORS


def delay_factors(tau: float) -> np.ndarray:
    """a [1/s] and b [1/s^2] (3, 2) of a delay ``tau`` [s]; zeros if it is 0."""
    if tau == 0.0:
        return np.zeros((FACTORS, 2))
    m = DELAY_STATES
    terms = [factorial(2 * m - j) / (factorial(j) * factorial(m - j)) for j in range(m + 1)]
    poles = np.roots(terms[::-1])
    upper = poles[poles.imag > 0.0]
    upper = upper[np.argsort(upper.imag)]
    return np.stack([-2.0 * upper.real / tau, np.abs(upper) ** 2 / tau**2], axis=1)


@kernel
def start_delay(u, factors, y, k):
    """Fill the states from ``k`` on in ``y`` as if ``u`` had never changed."""
    for i in range(FACTORS):
        y[k + 2 * i] = u / factors[i, 1]
        y[k + 2 * i + 1] = 0.0


@kernel
def delayed_signal(u, rate, factors, y, k):
    """The delayed value of ``u`` and its rate, from the states from ``k`` on in ``y``."""
    for i in range(FACTORS):
        a = factors[i, 0]
        x2 = y[k + 2 * i + 1]
        change = u - factors[i, 1] * y[k + 2 * i] - a * x2
        u -= 2.0 * a * x2
        rate -= 2.0 * a * change
    return u, rate


@kernel
def add_rates(u, factors, y, k, dy):
    """Rates of the states from ``k`` on into ``dy``."""
    for i in range(FACTORS):
        a = factors[i, 0]
        x2 = y[k + 2 * i + 1]
        dy[k + 2 * i] = x2
        dy[k + 2 * i + 1] = u - factors[i, 1] * y[k + 2 * i] - a * x2
        u -= 2.0 * a * x2


LENGTH_CONTROL, SPEED_CONTROL, TENSION_CONTROL, COMPENSATION = range(4)
STUCK, SLIPPING_OUT, SLIPPING_IN, FAST_OUT, FAST_IN, EMPTY, FULL, PRESCRIBED = range(8)
SPEEDING_OUT, SPEEDING_IN, BRAKING_OUT, BRAKING_IN, DRUM_INACTIVE = range(8, 13)
DRUM_MODES = (
    *("stuck", "slipping_out", "slipping_in", "fast_out", "fast_in", "empty", "full", "driven"),
    *("speeding_out", "speeding_in", "braking_out", "braking_in", "absent"),
)
ON_BOUND = 1e-6  # of the set tension: T this close to a bound is on it
AT_REST = 1e-6  # of the largest speed: with damping a drum begins to slip at speed 0
MODE_EDGE_RTOL = 1e-11  # of the set tension or length: a mode that begins on its own edge lasts
AT_END = 1e-12  # of a length: l0 this close to an end of the drum is there

DRUM = np.dtype(
    [
        *(("control", int), ("tension", float), ("low", float), ("high", float)),
        *(("loss_in", float), ("loss_out", float), ("fastest", float), ("acceleration", float)),
        *(("shortest", float), ("longest", float)),
    ]
)
"""Constants of a drum: its control; T0 and both bounds; f T0 inwards and outwards; v, a, and the
ends of l0, infinite if there is none."""


class DrumLoad(NamedTuple):
    """A line at a standing drum: its tension ``still`` [N] and the ``rate`` of that [N/s]; its
    derivatives ``by_length`` dT/dl0 [N/m] and ``by_speed`` dT/ds [N s/m], 0 without damping."""

    still: float
    rate: float
    by_length: float
    by_speed: float


@kernel
def speed_at_bound(bound, pull):
    """The speed of pay-out that keeps the tension on a ``bound``."""
    if pull.by_speed < 0.0:
        return (bound - pull.still) / pull.by_speed
    return -pull.rate / pull.by_length


@kernel
def payout_speed(drum, mode, ramp_speed, demand, pull):
    """Speed s of a drum in a ``mode``; ``ramp_speed`` is its speed while it speeds up or brakes,
    ``demand`` the speed of its signal or target."""
    if mode == PRESCRIBED:
        return demand
    if mode == SLIPPING_OUT:
        return speed_at_bound(drum.high, pull)
    if mode == SLIPPING_IN:
        return speed_at_bound(drum.low, pull)
    if mode == FAST_OUT:
        return drum.fastest
    if mode == FAST_IN:
        return -drum.fastest
    if SPEEDING_OUT <= mode <= BRAKING_IN:
        return ramp_speed
    return 0.0


@kernel
def tension_at(drum, mode, s, pull):
    """Tension of a taut line at a drum."""
    if mode == SLIPPING_OUT:
        return drum.high
    if mode == SLIPPING_IN:
        return drum.low
    return pull.still + pull.by_speed * s


@kernel
def drum_acceleration(drum, mode):
    """Acceleration of a drum that speeds up or brakes."""
    if mode in (SPEEDING_OUT, BRAKING_IN):
        return drum.acceleration
    if mode in (SPEEDING_IN, BRAKING_OUT):
        return -drum.acceleration
    return 0.0


@kernel
def friction_loss(drum, s):
    """Power that friction in the drum takes."""
    return drum.loss_out * s if s > 0.0 else -drum.loss_in * s


@kernel
def _payout_sign(mode):
    """1 if a drum pays out in a mode, -1 if it heaves in, else 0."""
    if mode in (SLIPPING_OUT, FAST_OUT, SPEEDING_OUT, BRAKING_OUT):
        return 1.0
    if mode in (SLIPPING_IN, FAST_IN, SPEEDING_IN, BRAKING_IN):
        return -1.0
    return 0.0


@kernel
def law_margin(drum, mode, T, s, l0, target, demand):
    """Margin of the control: positive while the mode lasts."""
    T0 = drum.tension
    v = drum.fastest
    way = _payout_sign(mode)
    if drum.control == TENSION_CONTROL:
        if mode == STUCK:
            return min(T - drum.low, drum.high - T) + MODE_EDGE_RTOL * T0
        if mode == EMPTY:
            return T - drum.low
        if mode == FULL:
            return drum.high - T
        if mode in (SLIPPING_OUT, SLIPPING_IN):
            return min(way * s, v - way * s)
        if mode in (SPEEDING_OUT, SPEEDING_IN):
            return min(way * (T - T0) / T0, 1.0 - way * s / v)
        if mode in (BRAKING_OUT, BRAKING_IN):
            return min(way * s / v, way * (_tension_bound(drum, way) - T) / T0)
        if mode in (FAST_OUT, FAST_IN):
            return (
                way * (T - (T0 if drum.acceleration > 0.0 else _tension_bound(drum, way)))
                + MODE_EDGE_RTOL * T0
            )
    if drum.control == SPEED_CONTROL:
        if mode == EMPTY:
            return demand
        if mode == FULL:
            return -demand
    if drum.control == COMPENSATION:
        if mode == EMPTY:
            return target - drum.longest
        if mode == FULL:
            return drum.shortest - target
        if mode in (FAST_OUT, FAST_IN):
            return way * (target - l0) + MODE_EDGE_RTOL * l0
        if mode == PRESCRIBED and v < inf:
            return v - abs(demand)
    return 1.0


@kernel
def _tension_bound(drum, way):
    """The bound of the tension beyond which a drum pays out, or heaves in."""
    return drum.high if way > 0.0 else drum.low


@kernel
def end_margin(drum, mode, l0):
    """Way to the end of a drum that turns; 1 if there is none."""
    way = _payout_sign(mode)
    if mode == PRESCRIBED and drum.control != LENGTH_CONTROL:
        margin = min(l0 - drum.shortest, drum.longest - l0)
    elif way > 0.0:
        margin = drum.longest - l0
    elif way < 0.0:
        margin = l0 - drum.shortest
    else:
        return 1.0
    return min(margin, 1.0)


@kernel
def turning_mode(drum, way, pull, taut, l0):
    """Mode of a drum with tension control that begins to pay out (``way`` 1) or to heave in (-1),
    because the tension is on that bound or beyond."""
    out = way > 0.0
    if out and l0 >= drum.longest * (1.0 - AT_END):
        return EMPTY
    if not out and l0 <= drum.shortest * (1.0 + AT_END):
        return FULL
    if drum.acceleration > 0.0:
        return SPEEDING_OUT if out else SPEEDING_IN
    fast = FAST_OUT if out else FAST_IN
    bound = _tension_bound(drum, way)
    jumps = pull.by_speed < 0.0  # then the tension can be on the bound at once
    if not taut or (not jumps and way * (pull.still - bound) > ON_BOUND * drum.tension):
        return fast
    s = way * speed_at_bound(bound, pull)
    if s >= drum.fastest:
        return fast
    if s < -AT_REST * drum.fastest:
        return STUCK
    return SLIPPING_OUT if out else SLIPPING_IN


@kernel
def initial_mode(drum, pull, taut, l0, target, demand):
    """Mode of a drum at a start."""
    if drum.control == TENSION_CONTROL:
        T = pull.still if taut else 0.0
        if drum.high < T:
            return turning_mode(drum, 1.0, pull, taut, l0)
        if drum.low > T:
            return turning_mode(drum, -1.0, pull, taut, l0)
        return STUCK
    return following_mode(drum, l0, target, demand)


@kernel
def following_mode(drum, l0, target, demand):
    """Mode of a drum that follows its signal or target, or would, were it not for its ends."""
    if drum.control == SPEED_CONTROL:
        if demand > 0.0 and l0 >= drum.longest * (1.0 - AT_END):
            return EMPTY
        if demand < 0.0 and l0 <= drum.shortest * (1.0 + AT_END):
            return FULL
    if drum.control == COMPENSATION:
        if target > drum.longest:
            return EMPTY
        if target < drum.shortest:
            return FULL
        if abs(demand) > drum.fastest:
            return FAST_OUT if demand > 0.0 else FAST_IN
    return PRESCRIBED


@kernel
def next_mode(drum, mode, taut, w):
    """Mode of a drum after its law's margin has reached zero; ``w`` is the motion of its wire."""
    T0 = drum.tension
    v = drum.fastest
    way = _payout_sign(mode)
    if drum.control != TENSION_CONTROL:
        if drum.control == COMPENSATION and mode == PRESCRIBED:
            return FAST_OUT if w.demand > 0.0 else FAST_IN
        if abs(w.demand) > v:
            return FAST_OUT if w.demand > 0.0 else FAST_IN
        return PRESCRIBED
    if mode == STUCK:
        near = 1.0 if drum.high - w.tension < w.tension - drum.low else -1.0
        return turning_mode(drum, near, w.pull, taut, w.length)
    if mode in (EMPTY, FULL):
        return turning_mode(drum, 1.0 if mode == FULL else -1.0, w.pull, taut, w.length)
    if mode in (SLIPPING_OUT, SLIPPING_IN):
        if way * w.speed < 0.5 * v:
            return STUCK
        return FAST_OUT if way > 0.0 else FAST_IN
    if mode in (SPEEDING_OUT, SPEEDING_IN):
        if 1.0 - way * w.speed / v < way * (w.tension - T0) / T0:
            return FAST_OUT if way > 0.0 else FAST_IN
        return BRAKING_OUT if way > 0.0 else BRAKING_IN
    if mode in (BRAKING_OUT, BRAKING_IN):
        if way * (_tension_bound(drum, way) - w.tension) / T0 < way * w.speed / v:
            return SPEEDING_OUT if way > 0.0 else SPEEDING_IN
        return initial_mode(drum, w.pull, taut, w.length, w.target, w.demand)
    if drum.acceleration > 0.0:
        return BRAKING_OUT if way > 0.0 else BRAKING_IN
    back = way * speed_at_bound(_tension_bound(drum, way), w.pull)
    if back <= 0.0:
        return STUCK
    return SLIPPING_OUT if way > 0.0 else SLIPPING_IN


@kernel
def stop_at_end(drum, mode, l0):
    """Mode of a drum that has reached an end."""
    if mode == PRESCRIBED:
        return EMPTY if drum.longest - l0 < l0 - drum.shortest else FULL
    return EMPTY if _payout_sign(mode) > 0.0 else FULL
