"""Pull of a line by a bracketed search, and its stiffness, length rates and stored energy.

The search starts from nothing, and always ends.

For a given H the depth that a line reaches rises with V, and with V found, the distance rises with
H, if nothing floats where the line lies. So V is found inside (`find_vertical_pull`), H outside
(`search`), each by Newton's method within a bracket. A line that ``rests`` on the bed between two
hanging parts has two depths: V at the fairlead and Va at the anchor are found each by itself.

How the pull of a line changes with its ends and its lengths, and the energy that it stores.

The flexibility d(x, z)/d(H, V) is a sum over stretches; the stiffness is its inverse. A length rate
is the change of (x, z) by a length at constant (H, V), brought back by the stiffness. The energy
follows from the principle of virtual work along what hangs:

    elastic + gravity = H x + V z - integral of (T + integral of eps dT) ds
"""

from __future__ import annotations

from math import inf, isfinite, sqrt
from typing import NamedTuple

from hydrosim.elements.line import hang
from hydrosim.jit.kernels import kernel, root_giving

ON_BED = 1e-12  # of the length: an anchor so close to the bed lies on it
NO_PULL = 1e-18  # of the weight, or of EA where nothing has weight: H that is none
LEAST_SLOPE = 1e-12  # the same where a piece without weight has its direction from H and V alone
MAX_SEARCH_STEPS = 200
ZERO_DISTANCE = 1e-9  # of the length: distance of a line from its anchor that is none
STRAIGHT_DOWN = 1e-12  # of the length: distance to which the pull ``least`` brings a hanging line
SPLIT = 134217729.0  # 2^27 + 1


class LineFrame(NamedTuple):
    """A line between its ends: distance ``x`` and height ``z`` [m], the unit vector (``ex``,
    ``ez``) along its chord, ``length`` [m] in all, by how much the chord is ``short`` of it,
    ``weight`` [N], ``load`` [N] the sum of all weights without sign, the pull ``least`` [N] that
    counts as none, and whether the line is ``heavy``, nothing of it floats, and ``curved``, its
    stretch has corners."""

    x: float
    z: float
    ex: float
    ez: float
    length: float
    short: float
    weight: float
    load: float
    least: float
    heavy: bool
    curved: bool


@kernel
def two_product(a, b):
    """a b and its rounding error (Dekker 1971)."""
    c = SPLIT * a
    ah = c - (c - a)
    al = a - ah
    c = SPLIT * b
    bh = c - (c - b)
    bl = b - bh
    p = a * b
    return p, ((ah * bh - p) + ah * bl + al * bh) + al * bl


@kernel
def two_sum(a, b):
    """a + b and its rounding error (Knuth)."""
    s = a + b
    t = s - a
    return s, (a - (s - t)) + (b - t)


@kernel
def chord_short_of(x, z, length):
    """``length`` less the chord, to full digits where they are nearly equal."""
    xx, dx = two_product(x, x)
    zz, dz = two_product(z, z)
    ll, dl = two_product(length, length)
    s, e = two_sum(xx, -ll)
    s, f = two_sum(s, zz)
    return -(s + (e + f + dx + dz - dl)) / (sqrt(x * x + z * z) + length)


@kernel
def line_frame(line):
    """The `LineFrame` of a line."""
    length = weight = load = 0.0
    heavy = True
    curved = False
    share = NO_PULL
    stiffest = inf
    for i in range(line.first, line.last):
        piece = line.pieces[i]
        hung = piece.hung if i + 1 < line.last else 0.0
        length += piece.length
        weight += piece.weight * piece.length + hung
        load += abs(piece.weight) * piece.length + abs(hung)
        stiffest = min(stiffest, piece.stiffness)
        if piece.weight == 0.0:
            share = LEAST_SLOPE
        heavy &= piece.weight >= 0.0 and hung >= 0.0
        curved |= piece.corners > 0
    chord = sqrt(line.x * line.x + line.z * line.z)
    ex = line.x / chord if chord > 0.0 else 1.0
    ez = line.z / chord if chord > 0.0 else 0.0
    short = chord_short_of(line.x, line.z, length)
    least = share * load if load > 0.0 else NO_PULL * stiffest
    return LineFrame(line.x, line.z, ex, ez, length, short, weight, load, least, heavy, curved)


@kernel
def line_reach(line, H, V, lies, ex, ez):
    """Where the line leads from the fairlead: to its other end or, if it ``lies``, to the bed and
    along it."""
    if lies:
        touch = hang.find_touchdown(line, 1, V)
    else:
        touch = hang.hanging_touchdown(line, 1, V)
    r = hang.hanging_reach(line, 1, H, V, touch, ex, ez)
    if touch.hangs:
        return r
    behind = hang.pull_at_touchdown(line, V, touch)
    length, stretch, _, live, _, _ = hang.lying_part(line, H, behind, touch)
    along = r.along - length * ez * ez / (1.0 + ex) + stretch * ex
    across = r.across - (length + stretch) * ez
    xV = r.xV + line.friction * live
    return hang.LineReach(along, across, r.xH + live, xV, r.zH, r.zV)


@kernel
def depth_excess(line, f, step, H, V, depth, whole, lies):
    """By how much a line leads deeper than wanted, and the slope of that by V: a ``whole`` line, or
    the part that hangs from one end down to ``depth``."""
    if whole:
        r = line_reach(line, H, V, lies, f.ex, f.ez)
        return f.ez * (r.along + f.short) + f.ex * r.across, r.zV
    touch = hang.find_touchdown(line, step, V)
    r = hang.hanging_reach(line, step, H, V, touch, 1.0, 0.0)
    return r.across - depth, r.zV


@kernel
def find_vertical_pull(line, f, step, H, V, depth, whole, lies):
    """V at the end where the way of ``step`` starts, with which the line leads to its depth (see
    `depth_excess`), for a given H."""
    low = -inf
    high = inf
    stride = H + abs(V)
    before = inf
    for _ in range(MAX_SEARCH_STEPS):
        off, slope = depth_excess(line, f, step, H, V, depth, whole, lies)
        if off > 0.0:
            high = V
        else:
            low = V
        new = V - off / slope if slope > 0.0 else inf
        good = low < new < high and abs(off) <= 0.5 * before
        before = abs(off)
        if not good:
            if isfinite(low) and isfinite(high):
                new = 0.5 * (low + high)
            else:
                stride *= 2.0
                new = V + stride if off <= 0.0 else V - stride
        if off == 0.0 or abs(new - V) <= 2e-16 * (abs(V) + H) or new in (low, high):
            return V
        V = new
    return V


@kernel
def resting_ends(line, H, V, Va):
    """The `LineReach` of both hanging parts of a line that rests on the bed between them, and the
    `LevelPart` there."""
    touch = hang.find_touchdown(line, 1, V)
    a = hang.hanging_reach(line, 1, H, V, touch, 1.0, 0.0)
    back = hang.find_touchdown(line, -1, Va)
    b = hang.hanging_reach(line, -1, H, Va, back, 1.0, 0.0)
    whole = hang.level_part(line, 1, H, hang.hanging_touchdown(line, 1, V))
    above = hang.level_part(line, 1, H, touch)
    beyond = hang.level_part(line, -1, H, back)
    flat = hang.LevelPart(
        whole.stretch - above.stretch - beyond.stretch,
        whole.soft - above.soft - beyond.soft,
        whole.lack - above.lack - beyond.lack,
    )
    return a, b, flat


@kernel
def balance_at_pull(line, f, lies, rests, H, V, Va):
    """For a given H: the distance reached less x, its slope by H, and V at both ends, from a guess
    of those."""
    if rests:
        V = find_vertical_pull(line, f, 1, H, V, f.z - line.bed, False, True)
        Va = find_vertical_pull(line, f, -1, H, Va, -line.bed, False, True)
        a, b, flat = resting_ends(line, H, V, Va)
        off = (f.length - f.x) + a.along + b.along + flat.soft * H + flat.stretch
        slope = a.xH + b.xH + flat.soft
        if a.zV > 0.0:
            slope -= a.zH * a.zH / a.zV
        if b.zV > 0.0:
            slope -= b.zH * b.zH / b.zV
        return off, slope, V, Va
    V = find_vertical_pull(line, f, 1, H, V, f.z, True, lies)
    r = line_reach(line, H, V, lies, f.ex, f.ez)
    off = f.ex * (r.along + f.short) - f.ez * r.across
    slope = r.xH - r.xV * r.zH / r.zV if r.zV > 0.0 else r.xH
    return off, slope, V, 0.0


@root_giving(float, float, float, bool)
def search(line, f, lies, rests, H, V, Va):
    """H, V and Va of a line, from a guess of them, and whether they were found. H is 0 if the line
    reaches its anchor without a pull."""
    low = 0.0
    high = inf
    before = inf
    H = max(H, f.least)
    for _ in range(MAX_SEARCH_STEPS):
        off, slope, V, Va = balance_at_pull(line, f, lies, rests, H, V, Va)
        if off >= 0.0 and f.least >= H:
            return slack_pull(f, rests, off), V, Va, True
        if off > 0.0:
            high = H
        else:
            low = H
        new = H - off / slope if slope > 0.0 else inf
        good = low < new < high and abs(off) <= 0.5 * before
        before = abs(off)
        if not good:
            new = next_trial(f, low, high)
        if off == 0.0 or abs(new - H) <= 4e-16 * H:
            break
        H = new
    return H, V, Va, abs(off) <= ZERO_DISTANCE * f.length


@kernel
def slack_pull(f, rests, off):
    """H of a line that reaches x + ``off`` with the pull ``f.least``. It is 0, but of a line that
    hangs straight down from close to above its anchor."""
    run = off + f.x
    straight = not rests and 0.0 < run <= STRAIGHT_DOWN * f.length
    return f.least * f.x / run if straight else 0.0


@kernel
def next_trial(f, low, high):
    """A pull within a bracket, in which ``low`` 0 and ``high`` infinite are unknown."""
    if low == 0.0:
        return f.least
    if isfinite(high):
        return sqrt(low) * sqrt(high)
    return max(10.0 * low, f.weight)


@kernel
def is_slack(f, pull):
    """Whether the line has no horizontal pull although its ends are apart."""
    return pull.H == 0.0 and (pull.touch < f.length or f.x > 0.0)


@kernel
def is_on_bed(line, f):
    """Whether the anchor lies on the bed."""
    return line.bed > -ON_BED * f.length


@kernel
def flexibility(line, f, pull):
    """dx/dH, dx/dV, dz/dH, dz/dV [m/N]."""
    H = max(pull.H, f.least)
    lies = is_on_bed(line, f)
    if lies or pull.touch >= f.length:
        r = line_reach(line, H, pull.V, lies, 1.0, 0.0)
        return r.xH, r.xV, r.zH, r.zV
    a, b, flat = resting_ends(line, H, pull.V, -pull.anchor_V)
    xH = a.xH + b.xH + flat.soft
    if b.zV > 0.0:
        xH -= b.zH * b.zH / b.zV
    return xH, a.xV, a.zH, a.zV


@root_giving(float, float, float, float)
def stiffness(line, pull):
    """dH/dx, dH/dz, dV/dx, dV/dz [N/m] of a line with its ``pull``."""
    f = line_frame(line)
    return stiffness_from_flexibility(is_slack(f, pull), *flexibility(line, f, pull))


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
def length_rates(line, pull, k):
    """dH/dL, dV/dL [N/m] by the unstretched length of piece ``k`` of ``pieces``."""
    f = line_frame(line)
    H = max(pull.H, f.least)
    lies = is_on_bed(line, f)
    flexible = flexibility(line, f, pull)
    Hx, Hz, Vx, Vz = stiffness_from_flexibility(is_slack(f, pull), *flexible)
    if lies or pull.touch >= f.length:
        dx, dz = shift_by_length(line, H, pull.V, lies, k)
    else:
        dx, dz = lengthen_resting(line, H, pull, k)
    return -(Hx * dx + Hz * dz), -(Vx * dx + Vz * dz)


@kernel
def hangs_whole(line, touch, step, k):
    """Whether piece k hangs all along, above ``touch`` on the way of ``step``."""
    if k == touch.piece:
        return touch.part >= line.pieces[k].length
    return (touch.piece - k) * step > 0


@kernel
def lengthen_hanging(line, step, H, V, touch, k):
    """dx/dL, dz/dL of a hanging part at constant H and V, by the length of a piece that ``hangs
    whole``: what is inserted below it, and what lies deeper with less V."""
    end = touch.piece + step
    dx = dz = 0.0
    below = False
    i, _ = hang.first_and_stop(line, step)
    while i != end:
        piece = line.pieces[i]
        length = touch.part if i == touch.piece else piece.length
        if below:
            s = hang.stretch_span(line.pieces, i, H, V, length, 1.0, 0.0)
            dx -= line.pieces[k].weight * s.zH
            dz -= line.pieces[k].weight * s.zV
        V -= piece.weight * length
        if i == k:
            T = sqrt(H * H + V * V)
            EA, o, _ = hang.branch_law(piece, hang.branch_at(piece, T))
            dx += (1.0 + o) * H / T + H / EA
            dz += (1.0 + o) * V / T + V / EA
            below = True
        if i != touch.piece:
            V -= hang.weight_after_piece(line, i, step)
        i += step
    return dx, dz


@kernel
def shift_by_length(line, H, V, lies, k):
    """dx/dL, dz/dL at constant H and V of a line that hangs or lies up to its anchor."""
    if lies:
        touch = hang.find_touchdown(line, 1, V)
    else:
        touch = hang.hanging_touchdown(line, 1, V)
    dx = dz = 0.0
    if hangs_whole(line, touch, 1, k):
        dx, dz = lengthen_hanging(line, 1, H, V, touch, k)
        if not touch.hangs:
            behind = hang.pull_at_touchdown(line, V, touch)
            _, _, _, live, _, _ = hang.lying_part(line, H, behind, touch)
            dx -= line.pieces[k].weight * line.friction * live
        return dx, dz
    low = V
    for i in range(line.first, k):
        low -= line.pieces[i].weight * line.pieces[i].length + line.pieces[i].hung
    low -= line.pieces[k].weight * line.pieces[k].length
    dx = 1.0 + hang.strain_at(line.pieces[k], max(H + line.friction * low, 0.0))
    if k + 1 < line.last:
        rest = hang.Touchdown(k + 1, 0.0, 0.0, 0.0, False)
        _, _, _, live, _, _ = hang.lying_part(line, H, low - line.pieces[k].hung, rest)
        dx -= line.pieces[k].weight * line.friction * live
    return dx, dz


@kernel
def lengthen_resting(line, H, pull, k):
    """The same of a line that rests on the bed between two hanging parts."""
    touch = hang.find_touchdown(line, 1, pull.V)
    if hangs_whole(line, touch, 1, k):
        return lengthen_hanging(line, 1, H, pull.V, touch, k)
    touch = hang.find_touchdown(line, -1, -pull.anchor_V)
    if not hangs_whole(line, touch, -1, k):
        return 1.0 + hang.strain_at(line.pieces[k], H), 0.0
    dx, dz = lengthen_hanging(line, -1, H, -pull.anchor_V, touch, k)
    b = hang.hanging_reach(line, -1, H, -pull.anchor_V, touch, 1.0, 0.0)
    return dx - b.zH * dz / b.zV, 0.0


@kernel
def hanging_energy(line, step, H, V, touch, depth):
    """Elastic energy and gravity of a hanging part [J], from its lower end up by ``depth``."""
    r = hang.hanging_reach(line, step, H, V, touch, 1.0, 0.0)
    energy = H * (r.along + touch.arc) + V * depth
    end = touch.piece + step
    i, _ = hang.first_and_stop(line, step)
    while i != end:
        piece = line.pieces[i]
        length = touch.part if i == touch.piece else piece.length
        energy -= hang.rest_energy(line.pieces, i, H, V, length)
        V -= piece.weight * length
        if i != touch.piece:
            V -= hang.weight_after_piece(line, i, step)
        i += step
    return energy


@kernel
def stored_energy(line, pull):
    """Elastic energy and gravity [J] above the height of the anchor. Without friction its gradient
    by (x, z) is (H, V)."""
    f = line_frame(line)
    H = max(pull.H, f.least)
    V = pull.V
    lies = is_on_bed(line, f)
    if not lies and pull.touch >= f.length:
        touch = hang.hanging_touchdown(line, 1, V)
        return hanging_energy(line, 1, H, V, touch, line.z)
    touch = hang.find_touchdown(line, 1, V)
    if lies:
        energy = hanging_energy(line, 1, H, V, touch, line.z)
        if touch.hangs:
            return energy
        behind = hang.pull_at_touchdown(line, V, touch)
        _, _, elastic, _, _, _ = hang.lying_part(line, H, behind, touch)
        return energy + elastic
    energy = f.weight * line.bed + hanging_energy(line, 1, H, V, touch, line.z - line.bed)
    _, _, flat = resting_ends(line, H, V, -pull.anchor_V)
    touch = hang.find_touchdown(line, -1, -pull.anchor_V)
    energy += hanging_energy(line, -1, H, -pull.anchor_V, touch, -line.bed)
    return energy + 0.5 * H * H * flat.soft - flat.lack
