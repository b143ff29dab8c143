"""The elastic line in its vertical plane: profiles, the room to kinks between them, and its pull.

Equations in `hydrosim.elements.line.hang` (Jonkman 2007, with several segments). Profiles of a
line:

* it hangs all along, also below its anchor, as a U;
* it comes to lie on the bed and its anchor is on the bed too, with friction along the bed;
* it rests on the bed between two hanging parts; friction is neglected there;
* it is slack, H = 0, and hangs straight down to the bed.

H and V are found by Newton's method from a guess; where that fails, by a bracketed search
(`hydrosim.elements.line.search`). Without friction the forces are the gradient of the stored
energy.

Limits: quasi-static, no bending; friction across the line is neglected. A line that would lie on
the bed, then float off it and come down to it again is refused (`REASONS`).

Smooth profiles of a line, and the room to their kinks.

Between kinks the pull is smooth. At a kink its second or third derivative jumps, where

* the line comes to lie, or leaves the bed, at an end of a piece or at a clump: V there is zero;
* it hangs free, as its anchor begins to carry V or as its sag leaves the bed;
* friction begins to take all tension: H = CB times the weight that lies;
* it becomes slack: x is the distance that it reaches without H;
* the tension at an end of a piece, or the least in it, passes a corner of its curve.

A profile is a number: its kind, whether it is slack, whether friction takes all, where both hanging
parts end (twice the number of the piece, plus one if at its lower end), and how many corners are
passed.
"""

from __future__ import annotations

from math import inf, isfinite, nan, sqrt
from typing import NamedTuple

from hydrosim.elements.line import hang
from hydrosim.elements.line.search import (
    ON_BED,
    ZERO_DISTANCE,
    balance_at_pull,
    is_on_bed,
    is_slack,
    length_rates,
    line_frame,
    line_reach,
    resting_ends,
    search,
    stiffness,
    stored_energy,
)
from hydrosim.jit.kernels import kernel, root_giving

HANGS, LIES, RESTS = range(3)
SLACK_CODE = 4
DEAD_CODE = 8
PLACE_CODE = 16
PLACE_CODES = 256
CORNER_CODE = PLACE_CODE * PLACE_CODES * PLACE_CODES
MAX_SLACK_PULL = 0.02  # of the weight: a larger H is far from none


@kernel
def find_profile(line, pull):
    """Number of the smooth profile of a line with its ``pull``."""
    f = line_frame(line)
    slack = SLACK_CODE if is_slack(f, pull) else 0
    if f.curved:
        passed, _ = find_corners(line, pull)
        slack += CORNER_CODE * passed
    if pull.touch >= f.length:
        return HANGS + slack
    touch = hang.find_touchdown(line, 1, pull.V)
    place = PLACE_CODE * place_of(line, touch, 1)
    if is_on_bed(line, f):
        return LIES + slack + (DEAD_CODE if pull.dead > 0.0 else 0) + place
    touch = hang.find_touchdown(line, -1, -pull.anchor_V)
    return RESTS + slack + place + PLACE_CODE * PLACE_CODES * place_of(line, touch, -1)


@kernel
def place_of(line, touch, step):
    """Where a hanging part ends: 2 i in piece i, 2 i + 1 at the lower end of piece i."""
    inside = 2 * (touch.piece - line.first)
    return inside if touch.part < line.pieces[touch.piece].length else inside + step


@root_giving(float)
def kink_room(line, pull, profile):
    """Least margin of a line to the kinks of a ``profile``, in parts of its length or weight.
    It is positive inside and falls through zero at a kink."""
    f = line_frame(line)
    load = f.load if f.load > 0.0 else line.pieces[line.first].stiffness
    kind = profile % SLACK_CODE
    place = profile // PLACE_CODE % PLACE_CODES
    least = inf
    if f.curved:
        passed, least = find_corners(line, pull)
        if passed != profile // CORNER_CODE:
            least = -least
    if kind == HANGS:
        return min(least, hanging_room(line, f, pull, load))
    least = min(least, place_room(line, 1, pull.V, place) / load)
    if kind == RESTS:
        other = profile // (PLACE_CODE * PLACE_CODES) % PLACE_CODES
        least = min(least, place_room(line, -1, -pull.anchor_V, other) / load)
        least = min(least, resting_room(line, f, pull))
    elif line.friction > 0.0:
        left = pull.H / line.friction + pull.V - f.weight
        least = min(least, (-left if profile & DEAD_CODE else left) / load)
    more = 1.0  # far from slack, whose room costs a search
    if pull.H / load < MAX_SLACK_PULL:
        more = slack_room(line, f, kind == RESTS, pull)
    return min(least, -more if profile & SLACK_CODE else more)


@root_giving(int, float)
def find_corners(line, pull):
    """How many corners the tension of a line has passed, and by how much of it the next corner is
    off. It is counted at both ends of each piece and where its tension is least."""
    f = line_frame(line)
    H = max(pull.H, f.least)
    V = pull.V
    touch = hang.hanging_touchdown(line, 1, V)
    back = hang.Touchdown(line.last, 0.0, 0.0, 0.0, False)
    friction = 0.0
    carried = f.weight - V + pull.anchor_V
    if is_on_bed(line, f):
        friction = line.friction
        touch = hang.find_touchdown(line, 1, V)
    elif pull.touch < f.length:
        touch = hang.find_touchdown(line, 1, V)
        back = hang.find_touchdown(line, -1, -pull.anchor_V)
    passed = 0
    room = inf
    for i in range(line.first, line.last):
        piece = line.pieces[i]
        low = V - piece.weight * piece.length
        falls = touch.hangs or i < touch.piece
        falls |= i == touch.piece and touch.part >= piece.length
        rises = i > back.piece or (i == back.piece and back.part >= piece.length)
        shift = carried if rises else 0.0
        top = max(H + friction * V, 0.0)
        least = top
        if falls or rises or i == touch.piece:
            top = sqrt(H * H + (V + shift) * (V + shift))
            least = H
        end = max(H + friction * low, 0.0)
        if falls or i >= back.piece:
            shift = 0.0 if falls else carried
            end = sqrt(H * H + (low + shift) * (low + shift))
        if (falls or rises) and (V + shift) * (low + shift) >= 0.0:
            least = min(top, end)
        for k in range(piece.corners):
            for T in (top, least, end):
                passed += 1 if piece.corner[k] <= T else 0
                room = min(room, abs(T / piece.corner[k] - 1.0))
        V = low - piece.hung
    return passed, room


@kernel
def hanging_room(line, f, pull, load):
    """Margin of a line that hangs all along."""
    if f.weight == 0.0 and f.heavy:
        return -f.short / f.length if pull.H > 0.0 else f.short / f.length
    if is_on_bed(line, f):
        return (pull.V - f.weight) / load
    return -resting_room(line, f, pull) if isfinite(line.bed) else inf


@kernel
def resting_room(line, f, pull):
    """What the bed carries between two hanging parts, in parts of the weight, or less the height of
    the sag above the bed, in parts of the length."""
    if pull.touch < f.length:
        return (f.weight - pull.V + pull.anchor_V) / f.weight
    low = lowest_height(line, f.z, max(pull.H, f.least), pull.V)
    return (line.bed - low) / f.length


@kernel
def place_room(line, step, V, place):
    """How far V [N] at the end where the way of ``step`` starts is from where its hanging part ends
    elsewhere than at ``place``."""
    if step > 0:
        piece = line.first + place // 2
    else:
        piece = line.first + (place + 1) // 2
    i, _ = hang.first_and_stop(line, step)
    while i != piece:
        piece_weight = line.pieces[i].weight * line.pieces[i].length
        V -= piece_weight + hang.weight_after_piece(line, i, step)
        i += step
    low = V - line.pieces[piece].weight * line.pieces[piece].length
    if place % 2 == 0:
        return min(V, -low)
    return min(low, hang.weight_after_piece(line, piece, step) - low)


@kernel
def slack_room(line, f, rests, pull):
    """By how much the ends are farther apart than the line reaches without a pull, in parts of its
    length."""
    if line.last == line.first + 1 and not f.curved:
        piece = line.pieces[line.first]
        reached = f.length - hanging_down(piece, f.z - min(line.bed, 0.0) if rests else f.z)
        if rests:
            reached -= hanging_down(piece, -line.bed)
        return (f.x - reached) / f.length
    return -reach_of_slack(line, f, rests, pull.V) / f.length


@kernel
def hanging_down(piece, depth):
    """Unstretched length of a piece that hangs straight down, without load at its lower end."""
    depth = max(depth, 0.0)
    return 2.0 * depth / (1.0 + sqrt(1.0 + 2.0 * piece.weight * depth / piece.stiffness))


@root_giving(float)
def reach_of_slack(line, f, rests, V):
    """The distance that a line reaches without pull, less x [m]."""
    smooth = hang.SuspendedLine(
        line.pieces, line.first, line.last, line.x, line.z, line.bed, friction=0.0
    )
    off, _, _, _ = balance_at_pull(smooth, f, not rests, rests, f.least, V, 0.0)
    return off


@kernel
def lowest_height(line, z, H, V):
    """Height above the anchor of the lowest place between the ends of a line that hangs; inf if
    there is none lower than its neighbours."""
    height = z
    least = inf
    for i in range(line.first, line.last):
        piece = line.pieces[i]
        low = V - piece.weight * piece.length
        if V > 0.0 and low < 0.0:
            part = V / piece.weight
            s = hang.stretch_span(line.pieces, i, H, V, part, 1.0, 0.0)
            least = min(least, height - s.across)
        s = hang.stretch_span(line.pieces, i, H, V, piece.length, 1.0, 0.0)
        height -= s.across
        V = low
        if i + 1 < line.last:
            V -= piece.hung
            if low >= 0.0 and V < 0.0:
                least = min(least, height)
    return least


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
def solve(line, H, V):
    """The `LinePull` of a `SuspendedLine`. H and V are a guess; there is none if H is nan or
    negative."""
    f = line_frame(line)
    near = ON_BED * f.length
    if line.bed > near:
        return no_solution(BURIED)
    if line.z < line.bed - near:
        return no_solution(BELOW)
    lies = is_on_bed(line, f)
    if not (H >= 0.0 and isfinite(V)):
        H = -1.0
        V = max(f.weight, 0.0)
    if lies or not isfinite(line.bed):
        return hang_or_lie(line, f, lies, H, V)
    if (
        f.heavy
        and H > 0.0
        and V + guess_vertical_pull(line.pieces[line.last - 1], H, -line.bed) < f.weight
    ):
        p = rest_on_bed(line, f, H, V)
        if p.V - p.anchor_V <= f.weight:
            return p
    p = hang_or_lie(line, f, False, H, V)
    loose = p.H == 0.0 and line.x > 0.0 and f.load > 0.0
    if not p.converged:
        return p
    if not loose and lowest_height(line, line.z, max(p.H, f.least), p.V) >= line.bed:
        return p
    if not f.heavy:
        return no_solution(TWICE)
    q = rest_on_bed(line, f, p.H, p.V)
    return no_solution(LOOSE) if loose and q.V - q.anchor_V > f.weight else q


@kernel
def rebuild_pull(line, H, V):
    """The `LinePull` of a line that `solve` has given H and V between these ends. It has not
    converged if they do not say enough, as for a line that may rest on the bed between two hanging
    parts."""
    f = line_frame(line)
    lies = is_on_bed(line, f)
    if not (H >= 0.0 and f.heavy) or (isfinite(line.bed) and not lies):
        return no_solution(NO_PULL_FOUND)
    return pull_of(line, f, lies, H, V)


@kernel
def hang_or_lie(line, f, lies, H, V):
    """The `LinePull` of a line that hangs all along or ``lies`` from some place on to its anchor.

    Of a line of which a part floats, several places to lie may balance. One at most is on the bed
    all along and nowhere below it. So what does not fit is searched again, also as if there were no
    bed."""
    has_converged = False
    reason = NO_PULL_FOUND if f.heavy else FLOATS
    if H > 0.0:
        H1, V1, has_converged = newton_pull(line, f, lies, H, V)
        if has_converged and lies and not f.heavy:
            reason = refusal_code(line, f, H1, V1)
            has_converged = reason == SOLVED
    if not has_converged:
        H1, V1, has_converged = search_pull(line, f, lies, H, V)
        if has_converged and lies and not f.heavy:
            reason = refusal_code(line, f, H1, V1)
            has_converged = reason == SOLVED
    if not has_converged and lies and not f.heavy:
        H1, V1, has_converged = search_pull(line, f, False, H, V)
        has_converged &= hang.hanging_touchdown(line, 1, V1).hangs
        has_converged = has_converged and refusal_code(line, f, H1, V1) == SOLVED
    if not has_converged:
        return no_solution(reason)
    return pull_of(line, f, lies, H1, V1)


@kernel
def search_pull(line, f, lies, H, V):
    """H and V by a search from a guess, refined by Newton's method, and whether they were found."""
    H, V, _, has_converged = search(line, f, lies, False, H, V, 0.0)
    if not has_converged:
        return H, V, False
    H1, V1, better = newton_pull(line, f, lies, H, V)
    if better:
        return H1, V1, True
    if H == 0.0 and abs(V) <= 1e3 * f.least:  # slack and weightless
        V = 0.0
    return H, V, True


@kernel
def pull_of(line, f, lies, H, V):
    """The `LinePull` of a line that hangs or ``lies`` from some place on, with H and V."""
    if not lies or f.load == 0.0:
        end = hang.hanging_touchdown(line, 1, V)
        return LinePull(H, V, end.V, H, f.length, 0.0, True, SOLVED)
    touch = hang.find_touchdown(line, 1, V)
    if touch.hangs:
        return LinePull(H, V, touch.V, H, f.length, 0.0, True, SOLVED)
    behind = hang.pull_at_touchdown(line, V, touch)
    _, _, _, _, tension, dead = hang.lying_part(line, H, behind, touch)
    return LinePull(H, V, 0.0, tension, touch.arc, dead, True, SOLVED)


@kernel
def rest_on_bed(line, f, H, V):
    """The `LinePull` of a line that rests on the bed between two hanging parts."""
    Va = guess_vertical_pull(line.pieces[line.last - 1], H, -line.bed)
    has_converged = False
    if H > 0.0:
        H, V, Va, has_converged = iterate_resting(line, f, H, V, Va)
    if not has_converged:
        H, V, Va, has_converged = search(line, f, True, True, H, V, Va)
        if not has_converged:
            return no_solution(NO_PULL_FOUND)
    touch = hang.find_touchdown(line, 1, V)
    return LinePull(H, V, -Va, H, touch.arc, 0.0, True, SOLVED)


@kernel
def newton_pull(line, f, lies, H, V):
    """H and V by Newton's method, and whether it converged. A step that passes a corner may leave
    an error of the first order, so a line that is ``curved`` needs two small ones."""
    sure = not f.curved
    for _ in range(MAX_WARM_STEPS):
        r = line_reach(line, H, V, lies, f.ex, f.ez)
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
        if same and sure:
            return H, V, True
        sure = not f.curved or same
    return H, V, False


@kernel
def guess_vertical_pull(piece, H, depth):
    """V at the upper end of a single piece that comes to lie at ``depth`` below it."""
    H = max(H, 0.0)
    energy = piece.weight * depth
    T = H + H * H / (2.0 * piece.stiffness) + energy
    T *= 2.0 / (1.0 + sqrt(1.0 + 2.0 * T / piece.stiffness))
    return sqrt(energy / (1.0 + 0.5 * (T + H) / piece.stiffness) * (T + H))


@kernel
def iterate_resting(line, f, H, V, Va):
    """H, V and Va by Newton's method, and whether it converged."""
    sure = not f.curved
    for _ in range(MAX_WARM_STEPS):
        a, b, flat = resting_ends(line, H, V, Va)
        x = f.length - f.x + a.along + b.along + flat.soft * H + flat.stretch
        z = a.across - (f.z - line.bed)
        za = b.across + line.bed
        slope = a.xH + b.xH + flat.soft - a.zH * a.zH / a.zV - b.zH * b.zH / b.zV
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
        if same and sure:
            return H, V, Va, True
        sure = not f.curved or same
    return H, V, Va, False


@kernel
def refusal_code(line, f, H, V):
    """Why a line of which something floats cannot lie as found: a key of `REASONS`, or 0."""
    touch = hang.find_touchdown(line, 1, V)
    r = hang.hanging_reach(line, 1, max(H, f.least), V, touch, 1.0, 0.0)
    if abs(r.across - f.z) > ZERO_DISTANCE * f.length:
        return FLOATS
    for i in range(touch.piece, line.last):
        lying = touch.part < line.pieces[i].length if i == touch.piece else True
        if not touch.hangs and lying and line.pieces[i].weight < 0.0:
            return FLOATS
        if not touch.hangs and i + 1 < line.last and line.pieces[i].hung < 0.0:
            return FLOATS
    height = f.z
    H = max(H, f.least)
    for i in range(line.first, touch.piece):
        piece = line.pieces[i]
        low = V - piece.weight * piece.length
        if V > 0.0 and low < 0.0:
            s = hang.stretch_span(line.pieces, i, H, V, V / piece.weight, 1.0, 0.0)
            if height - s.across < 0.0:
                return TWICE
        s = hang.stretch_span(line.pieces, i, H, V, piece.length, 1.0, 0.0)
        height -= s.across
        if height < 0.0:
            return TWICE
        V = low - piece.hung
    return SOLVED
