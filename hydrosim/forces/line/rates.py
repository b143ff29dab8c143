"""How the pull of a line changes with its ends and its lengths, and the energy that it stores.

The flexibility d(x, z)/d(H, V) is a sum over stretches; the stiffness is its inverse. A length rate
is the change of (x, z) by a length at constant (H, V), brought back by the stiffness. The energy
follows from the principle of virtual work along what hangs:

    elastic + gravity = H x + V z - integral of (T + T^2/(2 EA)) ds
"""

from __future__ import annotations

from math import sqrt

from hydrosim.forces.line.hang import (
    Touchdown,
    find_touchdown,
    hanging_reach,
    hanging_touchdown,
    lying_part,
    pull_at_touchdown,
    weight_after_piece,
)
from hydrosim.forces.line.search import ON_BED, line_frame, line_reach, resting_ends
from hydrosim.forces.line.stretch import rest_energy, stretch_span
from hydrosim.jit.kernels import kernel


@kernel
def is_slack(f, pull):
    """Whether the line has no horizontal pull although its ends are apart."""
    return pull.H == 0.0 and (pull.touch < f.length or f.x > 0.0)


@kernel
def is_on_bed(f, bed):
    """Whether the anchor lies on the bed."""
    return bed > -ON_BED * f.length


@kernel
def flexibility(pieces, first, last, f, bed, friction, pull):
    """dx/dH, dx/dV, dz/dH, dz/dV [m/N]."""
    H = max(pull.H, f.least)
    lies = is_on_bed(f, bed)
    if lies or pull.touch >= f.length:
        r = line_reach(pieces, first, last, H, pull.V, lies, friction, 1.0, 0.0)
        return r.xH, r.xV, r.zH, r.zV
    a, b = resting_ends(pieces, first, last, H, pull.V, -pull.anchor_V)
    xH = a.xH + b.xH + f.soft - a.soft - b.soft
    if b.zV > 0.0:
        xH -= b.zH * b.zH / b.zV
    return xH, a.xV, a.zH, a.zV


@kernel
def stiffness(pieces, first, last, x, z, bed, friction, pull):
    """dH/dx, dH/dz, dV/dx, dV/dz [N/m] of a line with its ``pull``."""
    f = line_frame(pieces, first, last, x, z)
    return stiffness_from_flexibility(
        is_slack(f, pull), *flexibility(pieces, first, last, f, bed, friction, pull)
    )


@kernel
def stiffness_from_flexibility(slack, xH, xV, zH, zV):
    """The stiffness of a flexibility. A slack line resists vertical motion alone."""
    if slack:
        return 0.0, 0.0, 0.0, 1.0 / zV if zV > 0.0 else 0.0
    det = xH * zV - xV * zH
    if det == 0.0:  # the fairlead lies on the bed
        return 1.0 / xH, 0.0, 0.0, 0.0
    return zV / det, -xV / det, -zH / det, xH / det


@kernel
def length_rates(pieces, first, last, x, z, bed, friction, pull, k):
    """dH/dL, dV/dL [N/m] by the unstretched length of piece ``k`` of ``pieces``."""
    f = line_frame(pieces, first, last, x, z)
    H = max(pull.H, f.least)
    lies = is_on_bed(f, bed)
    flexible = flexibility(pieces, first, last, f, bed, friction, pull)
    Hx, Hz, Vx, Vz = stiffness_from_flexibility(is_slack(f, pull), *flexible)
    if lies or pull.touch >= f.length:
        dx, dz = shift_by_length(pieces, first, last, H, pull.V, lies, friction, k)
    else:
        dx, dz = lengthen_resting(pieces, first, last, H, pull, k)
    return -(Hx * dx + Hz * dz), -(Vx * dx + Vz * dz)


@kernel
def hangs_whole(pieces, touch, step, k):
    """Whether piece k hangs all along, above ``touch`` on the way of ``step``."""
    if k == touch.piece:
        return touch.part >= pieces[k].length
    return (touch.piece - k) * step > 0


@kernel
def lengthen_hanging(pieces, start, step, H, V, touch, k):
    """dx/dL, dz/dL of a hanging part at constant H and V, by the length of a piece that ``hangs
    whole``: what is inserted below it, and what lies deeper with less V."""
    end = touch.piece + step
    dx = dz = 0.0
    below = False
    i = start
    while i != end:
        piece = pieces[i]
        length = touch.part if i == touch.piece else piece.length
        if below:
            s = stretch_span(H, V, piece.weight, length, piece.stiffness, 1.0, 0.0)
            dx -= pieces[k].weight * s.zH
            dz -= pieces[k].weight * s.zV
        V -= piece.weight * length
        if i == k:
            T = sqrt(H * H + V * V)
            dx += H / T + H / piece.stiffness
            dz += V / T + V / piece.stiffness
            below = True
        if i != touch.piece:
            V -= weight_after_piece(pieces, i, step)
        i += step
    return dx, dz


@kernel
def shift_by_length(pieces, first, last, H, V, lies, friction, k):
    """dx/dL, dz/dL at constant H and V of a line that hangs or lies up to its anchor."""
    if lies:
        touch = find_touchdown(pieces, first, last, 1, V)
    else:
        touch = hanging_touchdown(pieces, first, last, 1, V)
    dx = dz = 0.0
    if hangs_whole(pieces, touch, 1, k):
        dx, dz = lengthen_hanging(pieces, first, 1, H, V, touch, k)
        if not touch.hangs:
            behind = pull_at_touchdown(pieces, first, V, touch)
            _, _, _, live, _, _ = lying_part(pieces, last, H, behind, touch, friction)
            dx -= pieces[k].weight * friction * live
        return dx, dz
    low = V
    for i in range(first, k):
        low -= pieces[i].weight * pieces[i].length + pieces[i].hung
    low -= pieces[k].weight * pieces[k].length
    dx = 1.0 + max(H + friction * low, 0.0) / pieces[k].stiffness
    if k + 1 < last:
        rest = Touchdown(k + 1, 0.0, 0.0, 0.0, False)
        _, _, _, live, _, _ = lying_part(pieces, last, H, low - pieces[k].hung, rest, friction)
        dx -= pieces[k].weight * friction * live
    return dx, dz


@kernel
def lengthen_resting(pieces, first, last, H, pull, k):
    """The same of a line that rests on the bed between two hanging parts."""
    touch = find_touchdown(pieces, first, last, 1, pull.V)
    if hangs_whole(pieces, touch, 1, k):
        return lengthen_hanging(pieces, first, 1, H, pull.V, touch, k)
    touch = find_touchdown(pieces, last - 1, first - 1, -1, -pull.anchor_V)
    if not hangs_whole(pieces, touch, -1, k):
        return 1.0 + H / pieces[k].stiffness, 0.0
    dx, dz = lengthen_hanging(pieces, last - 1, -1, H, -pull.anchor_V, touch, k)
    b = hanging_reach(pieces, last - 1, -1, H, -pull.anchor_V, touch, 1.0, 0.0)
    return dx - b.zH * dz / b.zV, 0.0


@kernel
def hanging_energy(pieces, start, step, H, V, touch, depth):
    """Elastic energy and gravity of a hanging part [J], from its lower end up by ``depth``."""
    r = hanging_reach(pieces, start, step, H, V, touch, 1.0, 0.0)
    energy = H * (r.along + touch.arc) + V * depth
    end = touch.piece + step
    i = start
    while i != end:
        piece = pieces[i]
        length = touch.part if i == touch.piece else piece.length
        energy -= rest_energy(H, V, piece.weight, length, piece.stiffness)
        V -= piece.weight * length
        if i != touch.piece:
            V -= weight_after_piece(pieces, i, step)
        i += step
    return energy


@kernel
def stored_energy(pieces, first, last, x, z, bed, friction, pull):
    """Elastic energy and gravity [J] above the height of the anchor. Without friction its gradient
    by (x, z) is (H, V)."""
    f = line_frame(pieces, first, last, x, z)
    H = max(pull.H, f.least)
    V = pull.V
    lies = is_on_bed(f, bed)
    if not lies and pull.touch >= f.length:
        touch = hanging_touchdown(pieces, first, last, 1, V)
        return hanging_energy(pieces, first, 1, H, V, touch, z)
    touch = find_touchdown(pieces, first, last, 1, V)
    if lies:
        energy = hanging_energy(pieces, first, 1, H, V, touch, z)
        if touch.hangs:
            return energy
        behind = pull_at_touchdown(pieces, first, V, touch)
        _, _, elastic, _, _, _ = lying_part(pieces, last, H, behind, touch, friction)
        return energy + elastic
    energy = f.weight * bed + hanging_energy(pieces, first, 1, H, V, touch, z - bed)
    a, b = resting_ends(pieces, first, last, H, V, -pull.anchor_V)
    touch = find_touchdown(pieces, last - 1, first - 1, -1, -pull.anchor_V)
    energy += hanging_energy(pieces, last - 1, -1, H, -pull.anchor_V, touch, -bed)
    return energy + 0.5 * H * H * (f.soft - a.soft - b.soft)
