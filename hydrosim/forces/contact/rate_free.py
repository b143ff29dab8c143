"""Slip of a contact node without dampers: its traction stays on the kinetic cone.

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

from hydrosim.forces.contact.law import AT_REST, direction
from hydrosim.jit.kernels import kernel
from hydrosim.rigid.vectors import length

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
def node_stretch(load, v1, s, p):
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
