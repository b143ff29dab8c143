"""Interface of friction laws. A law is one file with

    a frozen dataclass          its coefficients, for scenes
    constants(law)              `Constants` of a point
    friction(mode, load, v, s, p)                        `Friction` in a mode
    margin(mode, load, v, s, heading, reaction, p)       positive while the mode lasts

and its transitions, where they differ from the defaults in `laws`:

    heading(load, v, s, p)                  along which a point slips
    break_away(load, v, s, reaction, p)     slip begins: state, jump of the node, energy lost
    grip(size, load, v, s, p)               slip ends: mode and state
    close(load, v, s, p)                    contact begins: mode and state
    release(mode, load, v, s, p)            contact ends: state, energy lost
    sliding(N, v, p)                        state of steady slip, to linearise about

load: `NormalLoad`; v: velocity (2,) relative to the plane; s: state (2,) of the point, the stretch
of its node or the heading of its slip; p: the point's constants, of `fender.CONTACT_POINT`.
"""

from __future__ import annotations

from typing import NamedTuple

from hydrosim.jit.kernels import kernel
from hydrosim.multibody.vectors import length

# Modes of a contact point, CF flag values of `fender_mode`.

OPEN, STICK, SLIP = range(3)
PASSED, ABSENT = 2, 3
"""Values of the column `RISING` for an open point: it is behind its plane, beyond the plane's edge;
or it does not exist at present."""


REVERSED = 10.0  # 1 / cos(84 deg)
AT_REST = 1e-6
"""m/s: below this speed the last direction of slip is kept.

The direction of slip without a node follows that of the forces at the rate mu g / speed. Above this
speed explicit steps and the differences of a Jacobian must resolve this rate: a hundred steps of
1e-6 s as slip begins. The error of positions is this speed times the duration of such slow slip,
1e-6 to 1e-4 s, so 1e-10 m at most.
"""


class Constants(NamedTuple):
    """Constants of a point's friction: ``static`` and ``kinetic`` coefficients; K2 or none, C2 or a
    slope, C3, and the relaxation time (C2 + C3) / K2 of a node; a reference load, and the powers of
    the load with which K2, C2, C3 scale. ``node`` is true if the state is the stretch of a contact
    node."""

    static: float = 0.0
    kinetic: float = 0.0
    stiffness: float = 0.0
    damping: float = 0.0
    slip_damping: float = 0.0
    relaxation: float = 0.0
    reference: float = 0.0
    stiffness_power: float = 0.0
    damping_power: float = 0.0
    slip_damping_power: float = 0.0
    node: bool = False


class NormalLoad(NamedTuple):
    """Normal force ``N``, its ``elastic`` part N_e and the ``rate`` N_e'; ``rising`` is true if the
    stretch is that of a rising load."""

    N: float
    elastic: float
    rate: float
    rising: bool


class Friction(NamedTuple):
    """Result of a friction law: ``force`` (2,) on the body, ``stretch_rate`` s' (2,), the node's
    ``slip_speed`` |v2|, and the ``dissipation`` [W] including energy lent to the spring. ``damped``
    by C2 and ``slip_damped`` by C3 are parts of the dissipation."""

    force: tuple[float, float]
    stretch_rate: tuple[float, float]
    slip_speed: float
    dissipation: float
    damped: float
    slip_damped: float


@kernel
def size_along(a, heading):
    """|a|, negative if ``a`` has reversed relative to the unit vector ``heading``; smooth for turns
    below 84 deg."""
    along = a[0] * heading[0] + a[1] * heading[1]
    return min(length(a), REVERSED * along)


@kernel
def direction(v, heading, rest):
    """v / |v| turned into the half plane of the unit vector ``heading`` (2,). It equals the heading
    at speeds far below ``rest`` [m/s].

    Near rest it changes smoothly into the heading. A point that was held has a velocity of rounding
    only, and slip that is driven sideways would turn ever faster as it stops.
    """
    side = -1.0 if v[0] * heading[0] + v[1] * heading[1] < 0.0 else 1.0
    a, b = side * v[0] + rest * heading[0], side * v[1] + rest * heading[1]
    size = length((a, b))
    return (a / size, b / size) if size > 0.0 else heading
