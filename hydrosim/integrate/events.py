"""Location of the end of a mode inside a step, by margins that are positive while the mode holds.

The owner of a margin knows its physics; here margins are numbers. All margins that are negative at
the end of a step are watched, each in units of the larger of its values at the two ends. The
smallest of them is phi: its first zero is the first event.
"""

from __future__ import annotations

from hydrosim.jit.kernels import kernel


@kernel
def guard_defect(now, before, after):
    """Smallest watched margin of ``now`` in units of its own range over the step."""
    smallest = 1.0
    for i in range(now.size):
        if after[i] < 0.0:
            smallest = min(smallest, linear_value(i, now, before, after))
    return smallest


@kernel
def linear_value(i, now, before, after):
    """Margin ``i`` in units of the larger of its values at the ends of the step."""
    return now[i] / max(abs(before[i]), abs(after[i]))


@kernel
def next_trial(lo, f_lo, hi, f_hi):
    """Next guess for a zero of a function f in [lo, hi], where f(lo) = f_lo >= 0 > f_hi = f(hi).
    It is the zero of the chord, kept 1 % of the bracket away from its ends, so that the bracket
    always shrinks."""
    x = lo + (hi - lo) * f_lo / (f_lo - f_hi)
    guard = 0.01 * (hi - lo)
    return min(max(x, lo + guard), hi - guard)
