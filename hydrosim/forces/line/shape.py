"""Stand-in: one segment."""

from __future__ import annotations

from math import asinh, exp, log, sqrt, inf
from typing import NamedTuple

import numpy as np

from hydrosim.jit.kernels import kernel

PIECE = np.dtype([("length", float), ("weight", float), ("stiffness", float), ("hung", float)])


class Pull(NamedTuple):
    H: float
    V: float
    anchor_V: float
    anchor_H: float
    touch: float
    dead: float
    converged: bool


@kernel
def ends(H, V, L, w, EA, bed, CB):
    W = w * L
    if V < W and bed > -1e300:
        LB = L - V / w
        s = V / H
        x = LB + H / w * asinh(s) + H * L / EA
        c = 0.0
        if CB > 0.0:
            d = max(LB - H / (CB * w), 0.0)
            c = CB * w / (2 * EA) * (-LB * LB + (LB - H / (CB * w)) * d)
        z = H / w * (sqrt(1 + s * s) - 1) + V * V / (2 * EA * w)
        return x + c, z
    s = V / H
    u = (V - W) / H
    x = H / w * (asinh(s) - asinh(u)) + H * L / EA
    z = H / w * (sqrt(1 + s * s) - sqrt(1 + u * u)) + (V * L - w * L * L / 2) / EA
    return x, z


@kernel
def solve(pieces, first, last, x, z, bed, friction, H, V):
    p = pieces[first]
    L = p.length
    w = p.weight
    EA = p.stiffness
    if H <= 0.0:
        far = sqrt(x * x + z * z)
        lam = 0.2 if far >= L else sqrt(3.0 * ((L * L - z * z) / (x * x) - 1.0))
        H = abs(w * x / (2 * lam))
        V = 0.5 * w * (z / np.tanh(lam) + L)
    h = log(H)
    ok = False
    for _ in range(200):
        H = exp(h)
        x0, z0 = ends(H, V, L, w, EA, bed, friction)
        fx = x0 - x
        fz = z0 - z
        if abs(fx) + abs(fz) < 1e-13 * (L + abs(x)):
            ok = True
            break
        d = 1e-6
        x1, z1 = ends(exp(h + d), V, L, w, EA, bed, friction)
        x1m, z1m = ends(exp(h - d), V, L, w, EA, bed, friction)
        dv = 1e-6 * max(abs(V), w * L)
        x2, z2 = ends(H, V + dv, L, w, EA, bed, friction)
        x2m, z2m = ends(H, V - dv, L, w, EA, bed, friction)
        a = (x1 - x1m) / (2 * d)
        b = (x2 - x2m) / (2 * dv)
        c = (z1 - z1m) / (2 * d)
        e = (z2 - z2m) / (2 * dv)
        det = a * e - b * c
        dh = -(e * fx - b * fz) / det
        dV = -(a * fz - c * fx) / det
        k = min(1.0, 0.5 / max(abs(dh), 1e-300))
        h += k * dh
        V += k * dV
    grounded = V < w * L and bed > -1e300
    touch = V / w if grounded else L
    aH = max(H - friction * w * (L - touch), 0.0)
    aV = 0.0 if grounded else V - w * L
    return Pull(H, V, aV, aH, touch, 0.0, True)


@kernel
def stored_energy(pieces, first, last, x, z, bed, friction, pull):
    p = pieces[first]
    L = p.length
    w = p.weight
    EA = p.stiffness
    H = pull.H
    V = pull.V
    # strain: int T^2/2EA
    n = min(pull.touch, L)
    Vb = V - w * n
    strain = (H * H * L + (V**3 - Vb**3) / (3 * w)) / (2 * EA)
    # height: integrate z(s) from the anchor: h(V') = H/w (sqrt(1+(V'/H)^2) - u0) + (V'^2 - Vb^2)/(2 EA w)
    a = V / H
    b = Vb / H
    F = 0.5 * (a * sqrt(1 + a * a) + asinh(a)) - 0.5 * (b * sqrt(1 + b * b) + asinh(b))
    area = H * H / w**2 * F - H / w * sqrt(1 + b * b) * n + ((V**3 - Vb**3) / 3 - Vb * Vb * (V - Vb)) / (2 * EA * w * w)
    return strain + w * area


@kernel
def find_profile(pieces, first, last, pull):
    return 1 if pull.touch < pieces[first].length else 0


@kernel
def room(pieces, first, last, pull, profile):
    d = pieces[first].length - pull.touch
    return (d if profile == 1 else 1.0, 1.0)
