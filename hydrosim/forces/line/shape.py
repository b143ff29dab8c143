"""The elastic line in its vertical plane: pull, stiffness, energy, and the kinks between profiles.

Equations in `hydrosim.forces.line.stretch` and `hydrosim.forces.line.hang` (Jonkman 2007, with
several segments). Profiles of a line:

* it hangs all along, also below its anchor, as a U;
* it comes to lie on the bed and its anchor is on the bed too, with friction along the bed;
* it rests on the bed between two hanging parts; friction is neglected there;
* it is slack, H = 0, and hangs straight down to the bed.

H and V are found by Newton's method from a guess; where that fails, by a bracketed search
(`hydrosim.forces.line.search`). Without friction the forces are the gradient of the stored energy.

Limits: quasi-static, no bending; friction across the line is neglected. A line that would lie on
the bed, then float off it and come down to it again is refused (`REASONS`).
"""

from __future__ import annotations

from math import isfinite, nan, sqrt
from typing import NamedTuple

from hydrosim.forces.line.hang import (
    find_touchdown,
    hanging_reach,
    hanging_touchdown,
    lying_part,
    pull_at_touchdown,
)
from hydrosim.forces.line.profile import find_profile, lowest_height
from hydrosim.forces.line.rates import is_on_bed, length_rates, stiffness, stored_energy
from hydrosim.forces.line.search import (
    ON_BED,
    ZERO_DISTANCE,
    line_frame,
    line_reach,
    resting_ends,
    search,
)
from hydrosim.forces.line.stretch import stretch_span
from hydrosim.jit.kernels import kernel

__all__ = [
    "REASONS",
    "LinePull",
    "find_profile",
    "length_rates",
    "solve",
    "stiffness",
    "stored_energy",
]

PULL_RTOL = 3e-8  # relative change in the last step of Newton's method; the error is its square
MAX_WARM_STEPS = 20
SOLVED, BELOW, FLOATS, TWICE, NO_PULL_FOUND, BURIED, LOOSE = range(7)
REASONS = {
    BELOW: "its fairlead is below the seabed",
    FLOATS: "something that floats would lift a part of it that lies on the seabed",
    TWICE: "it would touch the seabed at several places",
    NO_PULL_FOUND: "no pull was found",
    BURIED: "its anchor is below the seabed",
    LOOSE: "a piece without weight is loose, and what hangs beside it may reach the seabed",
}
"""Why a line has no solution, by `LinePull.reason`."""


class LinePull(NamedTuple):
    """Forces of a line [N] and where it lies [m]. The line pulls the fairlead by ``H`` towards the
    anchor and by ``V`` down. It pulls the anchor by ``anchor_H`` towards the fairlead and by
    ``anchor_V`` up. ``touch`` is the unstretched length from the fairlead to where it first lies on
    the bed, all of it if nowhere. Friction has taken all tension over the length ``dead`` at the
    anchor. ``reason``: a key of `REASONS`, or 0."""

    H: float
    V: float
    anchor_V: float
    anchor_H: float
    touch: float
    dead: float
    converged: bool
    reason: int


@kernel
def no_solution(reason):
    """The `LinePull` of a line without solution."""
    return LinePull(nan, nan, nan, nan, nan, nan, False, reason)


@kernel
def solve(pieces, first, last, x, z, bed, friction, H, V):
    """The `LinePull` of the line of ``pieces`` from ``first`` to before ``last``, in order from the
    fairlead. ``x`` >= 0 is the horizontal distance of its ends, ``z`` the height of the fairlead
    above the anchor [m]. ``bed`` <= 0 is the height of the seabed above the anchor [m], or -inf;
    ``friction`` is its coefficient. H and V are a guess; there is none if H is nan or negative."""
    f = line_frame(pieces, first, last, x, z)
    near = ON_BED * f.length
    if bed > near:
        return no_solution(BURIED)
    if z < bed - near:
        return no_solution(BELOW)
    lies = is_on_bed(f, bed)
    if not (H >= 0.0 and isfinite(V)):
        H = -1.0
        V = max(f.weight, 0.0)
    if lies or not isfinite(bed):
        return hang_or_lie(pieces, first, last, f, lies, friction, H, V)
    if f.heavy and H > 0.0 and V + guess_below(pieces[last - 1], H, -bed) < f.weight:
        p = rest_on_bed(pieces, first, last, f, bed, H, V)
        if p.V - p.anchor_V <= f.weight:
            return p
    p = hang_or_lie(pieces, first, last, f, False, 0.0, H, V)
    loose = p.H == 0.0 and x > 0.0 and f.load > 0.0
    if not p.converged:
        return p
    if not loose and lowest_height(pieces, first, last, z, max(p.H, f.least), p.V) >= bed:
        return p
    if not f.heavy:
        return no_solution(TWICE)
    q = rest_on_bed(pieces, first, last, f, bed, p.H, p.V)
    return no_solution(LOOSE) if loose and q.V - q.anchor_V > f.weight else q


@kernel
def rebuild_pull(pieces, first, last, x, z, bed, friction, H, V):
    """The `LinePull` of a line that `solve` has given H and V between these ends. It has not
    converged if they do not say enough, as for a line that may rest on the bed between two hanging
    parts."""
    f = line_frame(pieces, first, last, x, z)
    lies = is_on_bed(f, bed)
    if not (H >= 0.0 and f.heavy) or (isfinite(bed) and not lies):
        return no_solution(NO_PULL_FOUND)
    return pull_of(pieces, first, last, f, lies, friction, H, V)


@kernel
def hang_or_lie(pieces, first, last, f, lies, friction, H, V):
    """The `LinePull` of a line that hangs all along or ``lies`` from some place on to its anchor.

    Of a line of which a part floats, several places to lie may balance. One at most is on the bed
    all along and nowhere below it. So what does not fit is searched again, also as if there were no
    bed."""
    found = False
    reason = NO_PULL_FOUND if f.heavy else FLOATS
    if H > 0.0:
        H1, V1, found = newton_pull(pieces, first, last, f, lies, friction, H, V)
        if found and lies and not f.heavy:
            reason = refusal_code(pieces, first, last, f, H1, V1)
            found = reason == SOLVED
    if not found:
        H1, V1, found = search_pull(pieces, first, last, f, lies, friction, H, V)
        if found and lies and not f.heavy:
            reason = refusal_code(pieces, first, last, f, H1, V1)
            found = reason == SOLVED
    if not found and lies and not f.heavy:
        H1, V1, found = search_pull(pieces, first, last, f, False, 0.0, H, V)
        found &= hanging_touchdown(pieces, first, last, 1, V1).hangs
        found = found and refusal_code(pieces, first, last, f, H1, V1) == SOLVED
    if not found:
        return no_solution(reason)
    return pull_of(pieces, first, last, f, lies, friction, H1, V1)


@kernel
def search_pull(pieces, first, last, f, lies, friction, H, V):
    """H and V by a search from a guess, refined by Newton's method, and whether they were found."""
    H, V, _, found = search(pieces, first, last, f, 0.0, lies, False, friction, H, V, 0.0)
    if not found:
        return H, V, False
    H1, V1, better = newton_pull(pieces, first, last, f, lies, friction, H, V)
    if better:
        return H1, V1, True
    if H == 0.0 and abs(V) <= 1e3 * f.least:  # slack and weightless
        V = 0.0
    return H, V, True


@kernel
def pull_of(pieces, first, last, f, lies, friction, H, V):
    """The `LinePull` of a line that hangs or ``lies`` from some place on, with H and V."""
    if not lies or f.load == 0.0:
        end = hanging_touchdown(pieces, first, last, 1, V)
        return LinePull(H, V, end.V, H, f.length, 0.0, True, SOLVED)
    touch = find_touchdown(pieces, first, last, 1, V)
    if touch.hangs:
        return LinePull(H, V, touch.V, H, f.length, 0.0, True, SOLVED)
    behind = pull_at_touchdown(pieces, first, V, touch)
    _, _, _, _, tension, dead = lying_part(pieces, last, H, behind, touch, friction)
    return LinePull(H, V, 0.0, tension, touch.arc, dead, True, SOLVED)


@kernel
def rest_on_bed(pieces, first, last, f, bed, H, V):
    """The `LinePull` of a line that rests on the bed between two hanging parts."""
    Va = guess_below(pieces[last - 1], H, -bed)
    found = False
    if H > 0.0:
        H, V, Va, found = iterate_resting(pieces, first, last, f, bed, H, V, Va)
    if not found:
        H, V, Va, found = search(pieces, first, last, f, bed, True, True, 0.0, H, V, Va)
        if not found:
            return no_solution(NO_PULL_FOUND)
    touch = find_touchdown(pieces, first, last, 1, V)
    return LinePull(H, V, -Va, H, touch.arc, 0.0, True, SOLVED)


@kernel
def newton_pull(pieces, first, last, f, lies, friction, H, V):
    """H and V by Newton's method, and whether it converged."""
    for _ in range(MAX_WARM_STEPS):
        r = line_reach(pieces, first, last, H, V, lies, friction, f.ex, f.ez)
        along = r.along + f.short
        x = f.ex * along - f.ez * r.across
        z = f.ez * along + f.ex * r.across
        det = r.xH * r.zV - r.xV * r.zH
        dH = (r.xV * z - r.zV * x) / det
        dV = (r.zH * x - r.xH * z) / det
        if not (isfinite(dH) and isfinite(dV)) or f.least > H:
            return H, V, False
        same = abs(dH) <= PULL_RTOL * H and abs(dV) <= PULL_RTOL * max(abs(V), H)
        step = min(1.0, -0.9 * H / dH) if dH < 0.0 else 1.0
        H += step * dH
        V += step * dV
        if lies and f.heavy and V < 0.0:
            return H, V, False
        if same:
            return H, V, True
    return H, V, False


@kernel
def guess_below(piece, H, depth):
    """V at the upper end of a single piece that comes to lie at ``depth`` below it."""
    H = max(H, 0.0)
    energy = piece.weight * depth
    T = H + H * H / (2.0 * piece.stiffness) + energy
    T *= 2.0 / (1.0 + sqrt(1.0 + 2.0 * T / piece.stiffness))
    return sqrt(energy / (1.0 + 0.5 * (T + H) / piece.stiffness) * (T + H))


@kernel
def iterate_resting(pieces, first, last, f, bed, H, V, Va):
    """H, V and Va by Newton's method, and whether it converged."""
    for _ in range(MAX_WARM_STEPS):
        a, b = resting_ends(pieces, first, last, H, V, Va)
        flat = f.soft - a.soft - b.soft
        x = f.length - f.x + a.along + b.along + flat * H
        z = a.across - (f.z - bed)
        za = b.across + bed
        slope = a.xH + b.xH + flat - a.zH * a.zH / a.zV - b.zH * b.zH / b.zV
        dH = -(x - a.zH * z / a.zV - b.zH * za / b.zV) / slope
        dV = -(z + a.zH * dH) / a.zV
        dVa = -(za + b.zH * dH) / b.zV
        if not isfinite(dH + dV + dVa) or f.least > H:
            return H, V, Va, False
        same = abs(dH) <= PULL_RTOL * H
        same &= abs(dV) <= PULL_RTOL * max(V, H) and abs(dVa) <= PULL_RTOL * max(Va, H)
        step = min(1.0, -0.9 * H / dH) if dH < 0.0 else 1.0
        H += step * dH
        V += step * dV
        Va += step * dVa
        if V < 0.0 or Va < 0.0:
            return H, V, Va, False
        if same:
            return H, V, Va, True
    return H, V, Va, False


@kernel
def refusal_code(pieces, first, last, f, H, V):
    """Why a line of which something floats cannot lie as found: a key of `REASONS`, or 0."""
    touch = find_touchdown(pieces, first, last, 1, V)
    r = hanging_reach(pieces, first, 1, max(H, f.least), V, touch, 1.0, 0.0)
    if abs(r.across - f.z) > ZERO_DISTANCE * f.length:
        return FLOATS
    for i in range(touch.piece, last):
        lying = touch.part < pieces[i].length if i == touch.piece else True
        if not touch.hangs and lying and pieces[i].weight < 0.0:
            return FLOATS
        if not touch.hangs and i + 1 < last and pieces[i].hung < 0.0:
            return FLOATS
    height = f.z
    H = max(H, f.least)
    for i in range(first, touch.piece):
        piece = pieces[i]
        low = V - piece.weight * piece.length
        if V > 0.0 and low < 0.0:
            s = stretch_span(H, V, piece.weight, V / piece.weight, piece.stiffness, 1.0, 0.0)
            if height - s.across < 0.0:
                return TWICE
        s = stretch_span(H, V, piece.weight, piece.length, piece.stiffness, 1.0, 0.0)
        height -= s.across
        if height < 0.0:
            return TWICE
        V = low - piece.hung
    return SOLVED
