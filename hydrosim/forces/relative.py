"""Velocity of a body through a stream, in the body's axes, and a wrench given in these axes.

A stream is the flow of water (current) or air (wind) along the horizontal. The current on a body is
the mean over its draught.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hydrosim.jit.kernels import kernel
from hydrosim.rigid.kinematics import add_wrench
from hydrosim.rigid.vectors import matvec, product, sub, vector
from hydrosim.streams.current import current_on_hull

if TYPE_CHECKING:
    from hydrosim.forces.layout import Layout


def current_on(body: str, layout: Layout) -> tuple[float, float]:
    """Mean velocity (2,) [m/s] of the current over the draught of a ``body``. Raises InputError if
    the current varies and the draught is unknown."""
    return current_on_hull(layout.current_profile, layout.draught_of(body), body)


@kernel
def relative_velocity(b, stream, motion):
    """Velocity (6,) of body ``b``'s centre of gravity minus the ``stream`` (2,), and its angular
    velocity, both in its axes, as a tuple."""
    R, v = motion.rotation[b], motion.velocity
    u = matvec(R.T, sub(vector(v, 6 * b), (stream[0], stream[1], 0.0)))
    omega = matvec(R.T, vector(v, 6 * b + 3))
    return (u[0], u[1], u[2], omega[0], omega[1], omega[2])


@kernel
def add_resistance(b, D, u, motion, wrench):
    """Add -D u (6,), in the axes of body ``b``, to ``wrench`` (6 nb,); returns the power taken from
    the body."""
    f = product(D, u, 0)
    R, v = motion.rotation[b], motion.velocity
    force, moment = matvec(R, (-f[0], -f[1], -f[2])), matvec(R, (-f[3], -f[4], -f[5]))
    add_wrench(b, force, moment, wrench)
    lost = 0.0
    for i in range(3):
        lost -= force[i] * v[6 * b + i] + moment[i] * v[6 * b + 3 + i]
    return lost
