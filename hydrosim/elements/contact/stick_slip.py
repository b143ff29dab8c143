"""Stick-slip friction with a contact node, in the plane of contact.

A node u2 without mass sits between a spring K2 with damper C2 (to the body's point u1) and the
plane; S is the spring's traction, v1 = u1' relative to the plane, N the normal force.

    T = S + C2 v1             the traction that the node would carry at rest
    stick   v2 = 0                                            until |T| = mu_s N
    slip    v2 = (|T| - mu_k N) / (C2 + C3) d,  d = T / |T|   until |T| = mu_k N
    open    S + C2 (v1 - v2) = 0                              while N = 0
    S' = K2 (v1 - v2),    force on the body  f = -(S + C2 (v1 - v2))

so |f| <= mu_s N in stick and |f| = mu_k N + C3 |v2| in slip. Stored energy S^2 / (2 K2);
dissipation C2 |v1 - v2|^2 + (mu_k N + C3 |v2|) |v2|.

K2, C2 and C3 may scale with powers of x = e + (1 - e) N_e / N_0. N_e is the elastic normal force
(the normal curve without its damping), N_0 its reference, and e = 0.001 keeps x' / x finite where
contact begins and ends. The spring is then incremental, and S shrinks with K2 while N_e falls,

    S' = K2 (v1 - v2) + S min(K2', 0) / K2

Otherwise a spring that is stretched at a small N_e and released at a large one would create energy.
The energy taken by changes of K2, S^2 |K2'| / (2 K2^2), is lost (Thornton & Randall 1988). That
rate has no bound where K2 tends to zero with a power below 1. So the integral of the power into the
spring, S (v1 - v2), is kept instead; the loss is its part that is no longer stored.

Rate-free limit C2 + C3 = 0: at break-away the node jumps to the kinetic cone, |S| = mu_k N, and the
energy of the jump is lost. In slip the node stays on the cone (`rate_free_stretch`). This needs N',
and so no normal damping, and constant coefficients. If C2 = 0, or K2 is zero without load, an open
node coincides with the body's point. After Plasterk (2017), chapters 5 and 6, extended from one
axis to the plane.

The state is the stretch s: S = K2 s. While N_e rises, and K2 with it, S = K s with K of the
reference load instead. So s is smooth, also from the first touch on, and the same where K2 is
constant. In slip in the rate-free limit the state is the heading of the stretch.

Slip of a contact node without dampers: its traction stays on the kinetic cone.

    S = mu_k N d,   v2 = lambda d,   lambda = d v1 - mu_k N' / K2     until lambda = 0

The node follows the body's point like a trailer, on a drawbar of the length r = mu_k N / K2 that
points along d (a tractrix). With u = v1 / |v1|,

    d' = |v1| / r (u - (d u) d)

A short drawbar turns faster than any step. So the state is a heading x that turns at the rate |v1|
/ w instead. Here w = (r^4 + q^4)^(1/4), with q the distance that the point moves in one step of an
explicit method. Direction d lies between x and u, in the ratio of r to w, so that it deviates from
u by the correct amount:

    x' = |v1| / w (u - (x u) x),   d = r / w x + (1 - r / w) u, made a unit vector

x lags by w / |v1|, and so d lags by r / |v1|. If steps are shorter than r / |v1|, x and d differ by
(q / r)^4: the order of a method is kept. If they are longer, the error of d is about r / |v1| times
the change of the turning rate in a step, which is zero on a straight path.

Methods that choose their steps have q = 0, except for 1e-6 of a usual stretch, so that contact can
begin and end. Direction d is then wrong only where N, and so the force, is this small a fraction of
the usual one. Steps end at about that fraction of a usual turn.
"""

from __future__ import annotations

from math import sqrt
from typing import NamedTuple

import numpy as np

from hydrosim.elements.contact.law import (
    AT_REST,
    OPEN,
    SLIP,
    STICK,
    Constants,
    Friction,
    direction,
    size_along,
)
from hydrosim.jit.kernels import kernel
from hydrosim.multibody.vectors import length
from hydrosim.scene.contacts import StickSlip

MIN_DRAWBAR = 1e-6  # of a usual stretch: a shorter drawbar need not be resolved


@kernel
def slip_motion(load, v1, s, p):
    """Direction d (2,) of slip, its speed lambda, and the rate (2,) of the heading ``s``, which may
    have any length."""
    size, speed = length(s), length(v1)
    x = (s[0] / size, s[1] / size)
    u, r = direction(v1, x, AT_REST), p.kinetic * load.N / p.stiffness
    q = speed * p.lag + MIN_DRAWBAR * p.reach
    w = sqrt(sqrt(r * r * r * r + q * q * q * q))
    part, along, rate = r / w, x[0] * v1[0] + x[1] * v1[1], size / w
    d = unit_vector((part * x[0] + (1.0 - part) * u[0], part * x[1] + (1.0 - part) * u[1]))
    turn = (rate * (v1[0] - along * x[0]), rate * (v1[1] - along * x[1]))
    return d, d[0] * v1[0] + d[1] * v1[1] - p.kinetic * load.rate / p.stiffness, turn


@kernel
def rate_free_stretch(load, v1, s, p):
    """S / K2 (2,), in slip."""
    d, r = slip_motion(load, v1, s, p)[0], p.kinetic * load.N / p.stiffness
    return (r * d[0], r * d[1])


@kernel
def first_slip_direction(s, v1, p):
    """The heading (2,) at which slip begins from the stretch ``s``, or along ``v1`` without one."""
    along = unit_vector(s if s[0] != 0.0 or s[1] != 0.0 else v1)
    return (p.reach * along[0], p.reach * along[1])


@kernel
def unit_vector(a):
    """a / |a|, or zero."""
    size = length(a)
    return (a[0] / size, a[1] / size) if size > 0.0 else (0.0, 0.0)


MIN_LOAD_FACTOR = 1e-3  # e: x without load
BREAK_AWAY_RATIO = 1.0 + 1e-12
"""Factor on mu_s N that still holds. A node that comes to stick at mu_k N = mu_s N is then not
released again by the rounding of its traction."""


class FrictionCoefficients(NamedTuple):
    """``K2``, ``C2``, ``C3`` at a load, and ``K``, the traction per stretch."""

    K2: float
    C2: float
    C3: float
    K: float


def constants(law: StickSlip) -> Constants:
    """Constants of the law; the node relaxes in (C2 + C3) / K2."""
    damping = law.damping, law.slip_damping
    relaxation = (law.damping + law.slip_damping) / law.stiffness
    load = law.load
    powers = (
        (load.reference, load.stiffness, load.damping, load.slip_damping) if load else (0.0,) * 4
    )
    return Constants(law.static, law.kinetic, law.stiffness, *damping, relaxation, *powers, True)


@kernel
def coefficients(load, p):
    """K2, C2, C3 and K at a `NormalLoad` ``load``."""
    if p.reference == 0.0:
        return FrictionCoefficients(p.stiffness, p.damping, p.slip_damping, p.stiffness)
    x = _load_factor(load.elastic, p)
    K2 = p.stiffness * x**p.stiffness_power
    C2, C3 = p.damping * x**p.damping_power, p.slip_damping * x**p.slip_damping_power
    return FrictionCoefficients(K2, C2, C3, p.stiffness if load.rising else K2)


@kernel
def _load_factor(elastic, p):
    """x; stages of a step that ends contact may lie just outside contact."""
    return MIN_LOAD_FACTOR + (1.0 - MIN_LOAD_FACTOR) * max(elastic / p.reference, 0.0)


@kernel
def friction(mode, load, v1, s, p):
    """Stick-slip friction of a contact point in ``mode`` under a `NormalLoad` ``load``."""
    if mode == SLIP and p.relaxation == 0.0:
        return _friction_on_cone(load, v1, s, p)
    c = coefficients(load, p)
    if mode == STICK:
        dv, v2 = v1, 0.0
    elif mode == SLIP:
        d, v2 = _slip_friction(load, v1, s, c, p)
        dv = (v1[0] - v2 * d[0], v1[1] - v2 * d[1])
    else:
        relaxation = p.stiffness / p.damping if p.damping > 0.0 else 0.0
        dv, v2 = (-relaxation * s[0], -relaxation * s[1]), 0.0
    damped, slip_damped = c.C2 * (dv[0] * dv[0] + dv[1] * dv[1]), c.C3 * v2 * v2
    if mode == OPEN:
        return Friction((0.0, 0.0), dv, 0.0, damped, damped, 0.0)
    lost = damped + slip_damped + p.kinetic * load.N * v2
    if p.reference > 0.0:
        lost += c.K * (s[0] * dv[0] + s[1] * dv[1])
    force = (-(c.K * s[0] + c.C2 * dv[0]), -(c.K * s[1] + c.C2 * dv[1]))
    share = c.K2 / c.K
    return Friction(force, (share * dv[0], share * dv[1]), v2, lost, damped, slip_damped)


@kernel
def _slip_friction(load, v1, s, c, p):
    """Direction d (2,) and speed of slip of a node with dampers, whose coefficients are ``c``."""
    T = _traction(v1, s, c)
    return unit_vector(T), (length(T) - p.kinetic * load.N) / (c.C2 + c.C3)


@kernel
def _friction_on_cone(load, v1, s, p):
    """Friction of a node that slips in the rate-free limit."""
    d, v2, turn = slip_motion(load, v1, s, p)
    size = p.kinetic * load.N
    return Friction((-size * d[0], -size * d[1]), turn, v2, size * v2, 0.0, 0.0)


@kernel
def break_away(load, v1, s, p):
    """Slip begins. In the rate-free limit the node jumps, and the energy of the jump is lost."""
    if p.relaxation > 0.0:
        return s, 0.0, 0.0
    elastic_slip = p.kinetic * load.N / p.stiffness
    lost = 0.5 * p.stiffness * (s[0] * s[0] + s[1] * s[1] - elastic_slip * elastic_slip)
    return first_slip_direction(s, v1, p), length(s) - elastic_slip, lost


@kernel
def end_slip(load, v1, s, p):
    """Slip ends: mode and stretch."""
    return STICK, node_spring(SLIP, load, v1, s, p)


@kernel
def begin_contact(load, v1, s, p):
    """Contact begins in the mode whose margin is positive."""
    if margin(STICK, load, v1, s, (0.0, 0.0), p) >= 0.0:
        return STICK, s
    return SLIP, (s if p.relaxation > 0.0 else first_slip_direction(s, v1, p))


@kernel
def end_contact(mode, load, v1, s, p):
    """Contact ends. A node without a damper or a stiffness springs back at once and loses its
    stretch."""
    if p.damping > 0.0 and p.reference == 0.0:
        return s, 0.0
    return (0.0, 0.0), stored_energy(mode, load, v1, s, p) - recoverable_loss(mode, load, v1, s, p)


def break_away_stretch(law: StickSlip, N: float) -> float:
    """The stretch [m] at which a point breaks away under ``N`` [N], at least that under 1 N."""
    return max(law.static * N, 1.0) / law.stiffness


def steady_slip_stretch(N: float, p: np.void) -> tuple[float, float]:
    """The stretch at which a point breaks away under ``N`` [N], the same in both directions."""
    stretch = p["static"] * max(N, 1.0) / p["stiffness"]
    return stretch / np.sqrt(2.0), stretch / np.sqrt(2.0)


@kernel
def slip_traction(load, v, s, p):
    """The traction T = S + C2 v1; the node slips along it."""
    return _traction(v, s, coefficients(load, p))


@kernel
def _traction(v1, s, c):
    return (c.K * s[0] + c.C2 * v1[0], c.K * s[1] + c.C2 * v1[1])


@kernel
def margin(mode, load, v1, s, heading, p):
    """Distance of the traction from the end of the ``mode`` [N]; in the rate-free limit the speed
    of slip [m/s]. Negative past its end, and where the traction has reversed relative to its
    ``heading`` (2,) at the start of the step."""
    c = coefficients(load, p)
    T = _traction(v1, s, c)
    if mode == STICK:
        return p.static * load.N * BREAK_AWAY_RATIO - length(T)
    if c.C2 + c.C3 > 0.0:
        return size_along(T, heading) - p.kinetic * load.N
    return slip_motion(load, v1, s, p)[1]


@kernel
def node_spring(mode, load, v1, s, p):
    """The stretch (2,) of the state, or of its heading."""
    if mode == SLIP and p.relaxation == 0.0:
        return rate_free_stretch(load, v1, s, p)
    return s


@kernel
def stored_energy(mode, load, v1, s, p):
    """S^2 / (2 K2)."""
    c, s = coefficients(load, p), node_spring(mode, load, v1, s, p)
    return 0.5 * c.K * c.K / c.K2 * (s[0] * s[0] + s[1] * s[1])


@kernel
def recoverable_loss(mode, load, v1, s, p):
    """Part of the integrated dissipation that is still stored."""
    return stored_energy(mode, load, v1, s, p) if p.reference > 0.0 else 0.0


@kernel
def reverse_load(load, s, p):
    """The stretch (2,) for the same traction, when the load begins to fall, or to rise again."""
    K2 = coefficients(load, p).K2
    scale = p.stiffness / K2 if load.rising else K2 / p.stiffness
    return (scale * s[0], scale * s[1])


@kernel
def node_stretch(mode, load, v1, s, p):
    """S / K2 (2,)."""
    c, s = coefficients(load, p), node_spring(mode, load, v1, s, p)
    return (c.K / c.K2 * s[0], c.K / c.K2 * s[1])
