"""Smooth profiles of a line, and the room to their kinks.

Between kinks the pull is smooth. At a kink its second or third derivative jumps, where

* the line comes to lie, or leaves the bed, at an end of a piece or at a clump: V there is zero;
* it hangs free, as its anchor begins to carry V or as its sag leaves the bed;
* friction begins to take all tension: H = CB times the weight that lies;
* it becomes slack: x is the distance that it reaches without H.

A profile is a number: its kind, whether it is slack, whether friction takes all, and where both
hanging parts end (twice the number of the piece, plus one if at its lower end).
"""

from __future__ import annotations

from math import inf, isfinite, sqrt

from hydrosim.forces.line.hang import find_touchdown, weight_after_piece
from hydrosim.forces.line.rates import is_on_bed, is_slack
from hydrosim.forces.line.search import balance_at_pull, line_frame
from hydrosim.forces.line.stretch import stretch_span
from hydrosim.jit.kernels import kernel, root_giving

HANGS, LIES, RESTS = range(3)
SLACK_CODE = 4
DEAD_CODE = 8
PLACE_CODE = 16
PLACE_CODES = 256
MAX_SLACK_PULL = 0.02  # of the weight: a larger H is far from none


@kernel
def find_profile(pieces, first, last, x, z, bed, friction, pull):
    """Number of the smooth profile of a line with its ``pull``."""
    f = line_frame(pieces, first, last, x, z)
    slack = SLACK_CODE if is_slack(f, pull) else 0
    if pull.touch >= f.length:
        return HANGS + slack
    touch = find_touchdown(pieces, first, last, 1, pull.V)
    place = PLACE_CODE * place_of(pieces, first, touch, 1)
    if is_on_bed(f, bed):
        return LIES + slack + (DEAD_CODE if pull.dead > 0.0 else 0) + place
    touch = find_touchdown(pieces, last - 1, first - 1, -1, -pull.anchor_V)
    return RESTS + slack + place + PLACE_CODE * PLACE_CODES * place_of(pieces, first, touch, -1)


@kernel
def place_of(pieces, first, touch, step):
    """Where a hanging part ends: 2 i in piece i, 2 i + 1 at the lower end of piece i."""
    inside = 2 * (touch.piece - first)
    return inside if touch.part < pieces[touch.piece].length else inside + step


@kernel
def kink_room(pieces, first, last, x, z, bed, friction, pull, profile):
    """Least margin of a line to the kinks of a ``profile``, in parts of its length or weight.
    It is positive inside and falls through zero at a kink."""
    f = line_frame(pieces, first, last, x, z)
    load = f.load if f.load > 0.0 else pieces[first].stiffness
    kind = profile % SLACK_CODE
    place = profile // PLACE_CODE % PLACE_CODES
    if kind == HANGS:
        return hanging_room(pieces, first, last, f, bed, pull, load)
    least = place_room(pieces, first, first, 1, pull.V, place) / load
    if kind == RESTS:
        other = profile // (PLACE_CODE * PLACE_CODES)
        least = min(least, place_room(pieces, first, last - 1, -1, -pull.anchor_V, other) / load)
        least = min(least, resting_room(pieces, first, last, f, bed, pull))
    elif friction > 0.0:
        left = pull.H / friction + pull.V - f.weight
        least = min(least, (-left if profile & DEAD_CODE else left) / load)
    more = 1.0  # far from slack, whose room costs a search
    if pull.H / load < MAX_SLACK_PULL:
        more = slack_room(pieces, first, last, f, bed, kind == RESTS, pull)
    return min(least, -more if profile & SLACK_CODE else more)


@kernel
def hanging_room(pieces, first, last, f, bed, pull, load):
    """Margin of a line that hangs all along."""
    if f.weight == 0.0 and f.heavy:
        return -f.short / f.length if pull.H > 0.0 else f.short / f.length
    if is_on_bed(f, bed):
        return (pull.V - f.weight) / load
    return -resting_room(pieces, first, last, f, bed, pull) if isfinite(bed) else inf


@kernel
def resting_room(pieces, first, last, f, bed, pull):
    """What the bed carries between two hanging parts, in parts of the weight, or less the height of
    the sag above the bed, in parts of the length."""
    if pull.touch < f.length:
        return (f.weight - pull.V + pull.anchor_V) / f.weight
    low = lowest_height(pieces, first, last, f.z, max(pull.H, f.least), pull.V)
    return (bed - low) / f.length


@kernel
def place_room(pieces, first, start, step, V, place):
    """How far V at the end ``start`` [N] is from where its hanging part ends elsewhere than at
    ``place``."""
    if step > 0:
        piece = first + place // 2
    else:
        piece = first + (place + 1) // 2
    i = start
    while i != piece:
        V -= pieces[i].weight * pieces[i].length + weight_after_piece(pieces, i, step)
        i += step
    low = V - pieces[piece].weight * pieces[piece].length
    if place % 2 == 0:
        return min(V, -low)
    return min(low, weight_after_piece(pieces, piece, step) - low)


@kernel
def slack_room(pieces, first, last, f, bed, rests, pull):
    """By how much the ends are farther apart than the line reaches without a pull, in parts of its
    length."""
    if last == first + 1:
        piece = pieces[first]
        reached = f.length - hanging_down(piece, f.z - min(bed, 0.0) if rests else f.z)
        if rests:
            reached -= hanging_down(piece, -bed)
        return (f.x - reached) / f.length
    return -reach_of_slack(pieces, first, last, f, bed, rests, pull.V) / f.length


@kernel
def hanging_down(piece, depth):
    """Unstretched length of a piece that hangs straight down, without load at its lower end."""
    depth = max(depth, 0.0)
    return 2.0 * depth / (1.0 + sqrt(1.0 + 2.0 * piece.weight * depth / piece.stiffness))


@root_giving(float)
def reach_of_slack(pieces, first, last, f, bed, rests, V):
    """The distance that a line reaches without pull, less x [m]."""
    lies = not rests
    off, _, _, _ = balance_at_pull(pieces, first, last, f, bed, lies, rests, 0.0, f.least, V, 0.0)
    return off


@kernel
def lowest_height(pieces, first, last, z, H, V):
    """Height above the anchor of the lowest place between the ends of a line that hangs; inf if
    there is none lower than its neighbours."""
    height = z
    least = inf
    for i in range(first, last):
        piece = pieces[i]
        low = V - piece.weight * piece.length
        if V > 0.0 and low < 0.0:
            part = V / piece.weight
            s = stretch_span(H, V, piece.weight, part, piece.stiffness, 1.0, 0.0)
            least = min(least, height - s.across)
        s = stretch_span(H, V, piece.weight, piece.length, piece.stiffness, 1.0, 0.0)
        height -= s.across
        V = low
        if i + 1 < last:
            V -= piece.hung
            if low >= 0.0 and V < 0.0:
                least = min(least, height)
    return least
