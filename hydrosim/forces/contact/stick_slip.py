"""Stick-slip friction with a contact node, in the plane of contact.

A node u2 without mass sits between a spring K2 with damper C2 (to the body's point u1) and the
plane; s = u1 - u2 is the stretch, v1 = u1' relative to the plane, N the normal force.

    T = K2 s + C2 v1          the traction that the node would carry at rest
    stick   v2 = 0                                            until |T| = mu_s N
    slip    v2 = (|T| - mu_k N) / (C2 + C3) d,  d = T / |T|   until |T| = mu_k N
    open    K2 s + C2 s' = 0                                  while N = 0
    s' = v1 - v2,    force on the body  f = -(K2 s + C2 s')

so |f| <= mu_s N in stick and |f| = mu_k N + C3 |v2| in slip. Stored energy K2 s^2 / 2; dissipation
C2 s'^2 + (mu_k N + C3 |v2|) |v2|.

Rate-free limit C2 + C3 = 0: at break-away the node jumps to the kinetic cone, K2 |s| = mu_k N, the
energy of the jump is lost, and in slip it stays on it, so that with d = s / |s|

    slip    v2 = lambda d,  lambda = d v1 - mu_k N' / K2                until lambda = 0

which needs N' and so no normal damping. With C2 = 0 an open node is where the body's point is.
After Plasterk (2017), chapters 5 and 6, extended from one axis to the plane.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import hypot
from typing import NamedTuple

from hydrosim.forces.contact.modes import OPEN, SLIP, STICK
from hydrosim.kernels import kernel

REVERSED = 10.0  # 1 / cos(84 deg)


@dataclass(frozen=True)
class StickSlip:
    """Per contact point: ``static`` mu_s >= ``kinetic`` mu_k, ``stiffness`` K2 [N/m], ``damping``
    C2 and ``slip_damping`` C3 [N s/m]."""

    static: float
    kinetic: float
    stiffness: float
    damping: float
    slip_damping: float = 0.0


class Friction(NamedTuple):
    """What a friction law says: ``force`` (2,) on the body, ``stretch_rate`` s' (2,), the node's
    ``slip_speed`` |v2|, the ``dissipation`` [W]."""

    force: tuple[float, float]
    stretch_rate: tuple[float, float]
    slip_speed: float
    dissipation: float


@kernel
def friction(mode, N, dN, v1, s, p):
    """Stick-slip friction of a contact point in ``mode``; ``dN`` is N'."""
    K2, C2, C3 = p.stiffness, p.damping, p.slip_damping
    if mode == STICK:
        ds, v2 = v1, 0.0
    elif mode == SLIP:
        d, v2 = slip(N, dN, v1, s, p)
        ds = (v1[0] - v2 * d[0], v1[1] - v2 * d[1])
    else:
        relaxation = K2 / C2 if C2 > 0.0 else 0.0
        ds, v2 = (-relaxation * s[0], -relaxation * s[1]), 0.0
    lost = C2 * (ds[0] * ds[0] + ds[1] * ds[1]) + (p.kinetic * N + C3 * v2) * v2
    if mode == OPEN:
        return Friction((0.0, 0.0), ds, 0.0, lost)
    force = (-(K2 * s[0] + C2 * ds[0]), -(K2 * s[1] + C2 * ds[1]))
    return Friction(force, ds, v2, lost)


@kernel
def slip(N, dN, v1, s, p):
    """Direction d (2,) and speed of the node's slip."""
    T = traction(v1, s, p)
    size = hypot(T[0], T[1])
    if p.damping + p.slip_damping > 0.0:
        return _unit(T), (size - p.kinetic * N) / (p.damping + p.slip_damping)
    d = _unit(T) if size > 0.0 else _unit(v1)  # contact that begins in slip has no stretch yet
    return d, d[0] * v1[0] + d[1] * v1[1] - p.kinetic * dN / p.stiffness


@kernel
def _unit(a):
    size = hypot(a[0], a[1])
    return (a[0] / size, a[1] / size) if size > 0.0 else (0.0, 0.0)


@kernel
def break_away(N, s, p):
    """Stretch (2,) after break-away, and the energy lost in it: a jump in the rate-free limit."""
    size = hypot(s[0], s[1])
    if p.damping + p.slip_damping > 0.0 or size == 0.0:
        return s, 0.0
    scale = p.kinetic * N / (p.stiffness * size)
    kept = (scale * s[0], scale * s[1])
    return kept, stored_energy(s, p) - stored_energy(kept, p)


@kernel
def traction(v1, s, p):
    """T = K2 s + C2 v1."""
    K2, C2 = p.stiffness, p.damping
    return (K2 * s[0] + C2 * v1[0], K2 * s[1] + C2 * v1[1])


@kernel
def margin(mode, N, dN, v1, s, heading, p):
    """How far the traction is from ending the ``mode`` [N], in the rate-free limit the speed of
    slip [m/s]; negative past its end, and where the traction has turned round from its ``heading``
    (2,) at the start of the step."""
    T = traction(v1, s, p)
    if mode == STICK:
        return p.static * N - hypot(T[0], T[1])
    if p.damping + p.slip_damping > 0.0:
        return size_along(T, heading) - p.kinetic * N
    return slip(N, dN, v1, s, p)[1]


@kernel
def stored_energy(s, p):
    """K2 s^2 / 2."""
    return 0.5 * p.stiffness * (s[0] * s[0] + s[1] * s[1])


@kernel
def size_along(a, heading):
    """|a|, but negative where ``a`` has turned round from the unit vector ``heading``; smooth for
    turns below 84 deg."""
    along = a[0] * heading[0] + a[1] * heading[1]
    return min(hypot(a[0], a[1]), REVERSED * along)
