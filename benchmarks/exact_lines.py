"""Lines in extended precision: catenaries by their textbook equations (Irvine 1981, Jonkman 2007),
with mpmath at 50 digits. Nothing here is taken from `hydrosim.forces.line`.

The profile follows from conditions that do not ask a solver. A line is slack if its ends are
closer than it reaches without a pull. It lies where V would be negative, if its anchor is on the
bed. It rests between two hanging parts if the bed carries weight there; otherwise it hangs, and
its sag must be above the bed. Forces come from Newton's
method with differences, from a start that need not be good.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from mpmath import asinh, inf, lu_solve, matrix, mp, mpf, sqrt

mp.dps = 50
STEP = mpf(10) ** -25
SAME = mpf(10) ** -30
Row = tuple[float, float, float, float]
Numbers = Sequence[mpf]


class Line(NamedTuple):
    """Pieces (length, weight, EA, hung) from the fairlead to the anchor; distance and height of the
    fairlead from the anchor; height of the bed; friction."""

    rows: Sequence[Row]
    x: float
    z: float
    bed: float
    friction: float


def exact_pull(line: Line, H: float, V: float) -> tuple[mpf, mpf]:
    """H and V at the fairlead [N], from a start."""
    rows = [tuple(map(mpf, row)) for row in line.rows]
    x, z, bed, CB = mpf(line.x), mpf(line.z), mpf(line.bed), mpf(line.friction)
    if not any(row[1] or row[3] for row in rows[:-1]) and not rows[-1][1]:
        return _spring(rows, x, z)
    heavy = all(row[1] >= 0 and row[3] >= 0 for row in rows)
    lies = bed == 0 and heavy
    if bed > -inf and heavy:
        slack = _slack(rows, x, z, bed)
        if slack is not None:
            return mpf(0), slack
    if x == 0:
        return mpf(0), _hanging_straight(rows, z)
    start = [mpf(H), mpf(V)]

    def miss(at: Numbers) -> list[mpf]:
        found = _reach(rows, at[0], at[1], lies or bed == 0, CB)
        return [found[0] - x, found[1] - z]

    if -inf < bed < 0 and heavy:
        try:
            pull = _resting(rows, x, z, bed, start)
        except ArithmeticError:
            pull = [mpf(0), mpf(inf), mpf(0)]
        if pull[1] + pull[2] <= sum(row[0] * row[1] + row[3] for row in rows) - rows[-1][3]:
            return pull[0], pull[1]
    pull = _newton(miss, start)
    if -inf < bed < 0 and _sag(rows, z, *pull) < bed:
        raise ArithmeticError("a line that hangs below the bed")
    return pull[0], pull[1]


def exact_stiffness(line: Line, H: float, V: float) -> list[mpf]:
    """dH/dx, dH/dz, dV/dx, dV/dz [N/m] by differences; nan for ends one above the other."""
    if line.x == 0:
        return [mpf("nan")] * 4
    h = mpf(10) ** -15 * sum(row[0] for row in line.rows)
    x = mpf(line.x)
    z = mpf(line.z)
    sides = [
        [exact_pull(line._replace(x=a, z=b), H, V) for a, b in pair]
        for pair in (((x + h, z), (x - h, z)), ((x, z + h), (x, z - h)))
    ]
    return [(up[i] - down[i]) / (2 * h) for i in (0, 1) for up, down in sides]


def misses(line: Line, H: float, V: float, hangs: bool) -> float:
    """How far a line with these forces ends from its anchor, in parts of its length, if it
    ``hangs`` all along or lies from where V is zero."""
    rows = [tuple(map(mpf, row)) for row in line.rows]
    x, z, _, _ = _reach(rows, mpf(H), mpf(V), not hangs, mpf(line.friction))
    return float(max(abs(x - line.x), abs(z - line.z)) / sum(row[0] for row in rows))


def misses_resting(line: Line, H: float, V: float, Va: float) -> float:
    """The same of a line that rests on the bed between two hanging parts, with V at both ends."""
    rows = [tuple(map(mpf, row)) for row in line.rows]
    length = sum(row[0] for row in rows)
    found = _miss_resting(rows, mpf(line.x), mpf(line.z), mpf(line.bed), [mpf(H), mpf(V), mpf(Va)])
    return float(max(map(abs, found)) / length)


def _spring(rows: Sequence[Numbers], x: mpf, z: mpf) -> tuple[mpf, mpf]:
    """A weightless line."""
    length = sum(row[0] for row in rows)
    chord = sqrt(x * x + z * z)
    tension = max(chord - length, mpf(0)) / sum(row[0] / row[2] for row in rows)
    return tension * x / chord, tension * z / chord


def _drop(rows: Sequence[Numbers], depth: mpf) -> tuple[mpf, mpf] | None:
    """Length and weight that hang straight down to a depth; None if all of it is too short."""
    for i, row in enumerate(rows):
        above = rows[:i]
        if _depth(above, row, row[0]) < depth:
            continue
        if _depth(above, row, mpf(0)) > depth:
            return _drop_to_clump(above, depth)
        low, high = mpf(0), row[0]
        for _ in range(170):
            middle = (low + high) / 2
            deep = _depth(above, row, middle) > depth
            low, high = (low, middle) if deep else (middle, high)
        weight = row[1] * high + sum(a[0] * a[1] + a[3] for a in above)
        return sum((a[0] for a in above), high), weight
    return None


def _depth(above: Sequence[Numbers], row: Numbers, part: mpf) -> mpf:
    """How deep whole pieces and a part of the next one hang straight down."""
    load = row[1] * part
    total = part + load * part / (2 * row[2])
    for L, w, EA, hung in reversed(above):
        load += hung
        total += L + (load + w * L / 2) * L / EA
        load += w * L
    return total


def _drop_to_clump(above: Sequence[Numbers], depth: mpf) -> tuple[mpf, mpf]:
    """Length and load if the bed carries a part of the lowest clump."""
    length = sum(row[0] for row in above)
    soft = sum(row[0] / row[2] for row in above)
    own = mpf(0)
    load = mpf(0)
    for i, (L, w, EA, hung) in reversed(list(enumerate(above))):
        load += hung if i + 1 < len(above) else 0
        own += (load + w * L / 2) * L / EA
        load += w * L
    carried = (depth - length - own) / soft
    return length, load + carried


def _slack(rows: Sequence[Numbers], x: mpf, z: mpf, bed: mpf) -> mpf | None:
    """V of a line whose ends are closer than it reaches without a pull, or None."""
    fore = _drop(rows, z - bed)
    aft = (mpf(0), mpf(0)) if bed == 0 else _drop(_turned(rows), -bed)
    if fore is None or aft is None:
        return None
    spare = sum(row[0] for row in rows) - fore[0] - aft[0] - x
    return fore[1] if spare >= 0 else None


def _hanging_straight(rows: Sequence[Numbers], z: mpf) -> mpf:
    """V of a line that hangs straight down from above its anchor, with a bight or without."""

    def reached(V: mpf) -> mpf:
        total = mpf(0)
        v = V
        for L, w, EA, hung in rows:
            low = v - w * L
            total += (v + low) / 2 * L / EA
            if w == 0 or v * low >= 0:
                total += L if v + low > 0 else -L
            else:
                total += (abs(v) - abs(low)) / w
            v = low - hung
        return total

    span = sum(abs(row[1]) * row[0] + abs(row[3]) for row in rows)
    span += abs(z) / sum(row[0] / row[2] for row in rows)
    low, high = -span, span
    for _ in range(220):
        middle = (low + high) / 2
        low, high = (low, middle) if reached(middle) > z else (middle, high)
    return high


def _reach(
    rows: Sequence[Numbers], H: mpf, V: mpf, lies: bool, CB: mpf
) -> tuple[mpf, mpf, mpf, mpf]:
    """Distance and depth that the line leads to; depth of its lowest sag; length that hangs."""
    tops = []
    v = V
    for L, w, _, hung in rows:
        tops.append((v, v - w * L))
        v -= w * L + hung
    lies = lies and tops[-1][1] < 0
    hangs = max((i for i, (a, b) in enumerate(tops) if a > 0 or b > 0), default=-1)
    x = z = arc = mpf(0)
    sag = -mpf(inf)
    for i, (L, w, EA, _) in enumerate(rows):
        a, b = tops[i]
        if lies and (i > hangs or (i == hangs and b < 0)):
            part = a / w if i == hangs else mpf(0)
            if part:
                x += H / w * asinh(a / H) + H * part / EA
                z += (sqrt(H * H + a * a) - H) / w + a * a / (2 * w * EA)
            lying = L - part
            first = max(H + CB * min(a, mpf(0)), mpf(0))
            last = max(H + CB * b, mpf(0))
            under = lying if last > 0 or CB * w == 0 else first / (CB * w)
            x += lying + (first + last) / 2 * under / EA
            arc += part
            continue
        if w == 0:
            T = sqrt(H * H + a * a)
            x += H * L * (1 / T + 1 / EA)
            z += a * L * (1 / T + 1 / EA)
        else:
            if a > 0 > b:
                fall = (sqrt(H * H + a * a) - H) / w + a * a / (2 * w * EA)
                sag = max(sag, z + fall)
            x += H / w * (asinh(a / H) - asinh(b / H)) + H * L / EA
            z += (sqrt(H * H + a * a) - sqrt(H * H + b * b)) / w + (a * a - b * b) / (2 * w * EA)
        if b >= 0 and i + 1 < len(rows) and tops[i + 1][0] < 0:
            sag = max(sag, z)
        arc += L
    return x, z, sag, arc


def _sag(rows: Sequence[Numbers], z: mpf, H: mpf, V: mpf) -> mpf:
    return z - _reach(rows, H, V, False, mpf(0))[2]


def _hanging_part(rows: Sequence[Numbers], H: mpf, V: mpf) -> tuple[mpf, mpf, mpf, mpf]:
    """Distance, depth, length and l/EA of what hangs from one end, down to the bed."""
    whole = _reach(rows, H, V, True, mpf(0))
    lying = sum(row[0] for row in rows) - whole[3]
    soft = mpf(0)
    left = whole[3]
    for L, _, EA, _ in rows:
        soft += min(left, L) / EA
        left -= min(left, L)
    flat = sum(row[0] / row[2] for row in rows) - soft
    return whole[0] - lying - H * flat, whole[1], whole[3], soft


def _resting(rows: Sequence[Numbers], x: mpf, z: mpf, bed: mpf, start: Numbers) -> list[mpf]:
    """H, V, and V at the anchor, of a line that rests on the bed between two hanging parts."""
    turned = _turned(rows)

    def upper(H: mpf, part: Sequence[Numbers], depth: mpf) -> mpf:
        w = max(row[1] for row in part)
        loads = sum(row[0] * row[1] + row[3] for row in part[:-1])
        low, high = mpf(0), sqrt((H + w * depth) ** 2 * 4) + loads + H
        for _ in range(180):
            middle = (low + high) / 2
            deep = _hanging_part(part, H, middle)[1]
            low, high = (low, middle) if deep > depth else (middle, high)
        return high

    def miss(at: Numbers) -> list[mpf]:
        return _miss_resting(rows, x, z, bed, at)

    H, V = start
    return _newton(miss, [H, V, upper(H, turned, -bed)])


def _miss_resting(rows: Sequence[Numbers], x: mpf, z: mpf, bed: mpf, at: Numbers) -> list[mpf]:
    """What a line lacks in distance and in both depths."""
    H, V, Va = at
    length = sum(row[0] for row in rows)
    soft = sum(row[0] / row[2] for row in rows)
    fore, aft = _hanging_part(rows, H, V), _hanging_part(_turned(rows), H, Va)
    flat = length - fore[2] - aft[2] + (soft - fore[3] - aft[3]) * H
    return [fore[0] + aft[0] + flat - x, fore[1] - z + bed, aft[1] + bed]


def _turned(rows: Sequence[Numbers]) -> list[Numbers]:
    """The same line from its other end."""
    return [
        (*row[:3], rows[i - 1][3] if i else mpf(0)) for i, row in reversed(list(enumerate(rows)))
    ]


def _newton(miss: Callable[[Numbers], list[mpf]], start: Numbers) -> list[mpf]:
    """Root by Newton's method with differences. Raises ArithmeticError if there is none."""
    at = list(start)
    for _ in range(60):
        here = miss(at)
        n = len(at)
        slopes = matrix(n, n)
        for j in range(n):
            beside = list(at)
            h = STEP * max(abs(at[j]), abs(at[0]))
            beside[j] += h
            there = miss(beside)
            for i in range(n):
                slopes[i, j] = (there[i] - here[i]) / h
        step = lu_solve(slopes, -matrix(here))
        share = mpf(1)
        if step[0] < 0:
            share = min(share, -at[0] / step[0] * mpf("0.9"))
        at = [a + share * step[i] for i, a in enumerate(at)]
        if share == 1 and all(
            abs(step[i]) <= SAME * max(abs(a), abs(at[0])) for i, a in enumerate(at)
        ):
            return at
    raise ArithmeticError("no root in extended precision")
