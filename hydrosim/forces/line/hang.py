"""A line under a given pull: the part that hangs, down to where it lies, and the part that lies.

V falls along the line by the weight of its pieces and of what hangs between them. The line lies
from the last place at which V comes down to zero. That is inside a piece, tangent to the bed, or at
a clump that the bed carries in part. Farther on, -V is the weight since that place. The bed carries
it, and friction takes it from the tension:

    T(s) = max(H + CB V(s), 0)

The derivative of x by V at constant H differs from that of z by H only by this friction.
"""

from __future__ import annotations

from typing import NamedTuple

from hydrosim.forces.line.stretch import stretch_span
from hydrosim.jit.kernels import kernel

"""A segment, in order from the fairlead to the anchor: unstretched length [m]; weight in water per
unstretched length [N/m], negative if it floats; EA [N]; the weight in water of what hangs at its
lower end [N], negative for a buoy. What hangs at the last one is the anchor's."""


class Touchdown(NamedTuple):
    """Where a line that hangs from one end comes to lie: in piece ``piece``, after ``part`` [m] of
    it, at the arc length ``arc`` [m] from that end. ``V`` [N] is what is left of V at the other
    end. The line ``hangs`` all along if that is not negative."""

    piece: int
    part: float
    arc: float
    V: float
    hangs: bool


class LineReach(NamedTuple):
    """Where a line leads, as a `hydrosim.forces.line.stretch.StretchSpan`, with the derivative
    ``xV`` of x by V. ``soft`` [m/N] is the sum of l/EA of what hangs, ``arc`` [m] its length."""

    along: float
    across: float
    xH: float
    xV: float
    zH: float
    zV: float
    soft: float
    arc: float


@kernel
def weight_after_piece(pieces, i, step):
    """Weight of what hangs behind piece i, on the way to the anchor (step 1) or back (-1)."""
    return pieces[i].hung if step > 0 else pieces[i - 1].hung


@kernel
def find_touchdown(pieces, start, stop, step, V):
    """The `Touchdown` of a line with V at its end ``start``; ``stop`` lies beyond its other end."""
    touch = Touchdown(start, 0.0, 0.0, V, False)
    arc = 0.0
    i = start
    while i != stop:
        piece = pieces[i]
        low = V - piece.weight * piece.length
        if V > 0.0 and low < 0.0:
            part = V / piece.weight
            touch = Touchdown(i, part, arc + part, 0.0, False)
        elif V > 0.0 or low > 0.0:
            touch = Touchdown(i, piece.length, arc + piece.length, 0.0, False)
        arc += piece.length
        V = low
        i += step
        if i != stop:
            V -= weight_after_piece(pieces, i - step, step)
    hangs = V >= 0.0 and touch.arc >= arc
    return Touchdown(touch.piece, touch.part, touch.arc, V, hangs)


@kernel
def hanging_touchdown(pieces, start, stop, step, V):
    """The `Touchdown` of a line that hangs all along."""
    arc = 0.0
    i = start
    while i != stop:
        V -= pieces[i].weight * pieces[i].length
        arc += pieces[i].length
        i += step
        if i != stop:
            V -= weight_after_piece(pieces, i - step, step)
    return Touchdown(stop - step, pieces[stop - step].length, arc, V, True)


@kernel
def hanging_reach(pieces, start, step, H, V, touch, ex, ez):
    """`LineReach` of the part that hangs, from piece ``start`` to ``touch``."""
    along = across = xH = zH = zV = soft = 0.0
    end = touch.piece + step
    i = start
    while i != end:
        piece = pieces[i]
        length = touch.part if i == touch.piece else piece.length
        s = stretch_span(H, V, piece.weight, length, piece.stiffness, ex, ez)
        along += s.along
        across += s.across
        xH += s.xH
        zH += s.zH
        zV += s.zV
        soft += length / piece.stiffness
        V -= piece.weight * length
        if i != touch.piece:
            V -= weight_after_piece(pieces, i, step)
        i += step
    return LineReach(along, across, xH, zH, zH, zV, soft, touch.arc)


@kernel
def lying_part(pieces, last, H, V, touch, friction):
    """Of the part that lies between ``touch`` and the anchor, with V there if the bed carried
    nothing: its length, its stretch, its elastic energy, the sum of l/EA of what is under tension,
    the tension at the anchor, and the length without tension."""
    length = stretch = energy = live = dead = 0.0
    tension = max(H + friction * V, 0.0)
    for i in range(touch.piece, last):
        piece = pieces[i]
        L = piece.length - touch.part if i == touch.piece else piece.length
        V -= piece.weight * L
        below = H + friction * V
        if below >= 0.0:
            under = L
            stretch += 0.5 * (tension + below) * L / piece.stiffness
            squares = tension * tension + tension * below + below * below
            energy += squares * L / (6.0 * piece.stiffness)
            tension = below
        else:
            under = tension / (friction * piece.weight) if tension > 0.0 else 0.0
            stretch += 0.5 * tension * under / piece.stiffness
            energy += tension * tension * under / (6.0 * piece.stiffness)
            tension = 0.0
        length += L
        live += under / piece.stiffness
        dead += L - under
        if i + 1 < last:
            V -= piece.hung
            tension = max(H + friction * V, 0.0)
    return length, stretch, energy, live, tension, dead


@kernel
def pull_at_touchdown(pieces, first, V, touch):
    """V behind ``touch``: what it would be there if the bed carried nothing."""
    for i in range(first, touch.piece):
        V -= pieces[i].weight * pieces[i].length + pieces[i].hung
    return V - pieces[touch.piece].weight * touch.part
