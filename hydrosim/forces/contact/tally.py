"""Impulses, works and displacements of contact points by mode: integrals in y, if asked for.

For each point and each of its modes (open, stick, slip), in the earth frame:

    time, N, N n, f                 impulses of the normal force and of friction f on the body
    w                               displacement of the point along the plane
    f w by axis, N n w              works of friction and of the normal force

with the velocity w of the point relative to the plane. In slip also, with its direction d = -f /
|f|: d, N d, C3 |v2| d, the node's |v2| d, and for three of them the part towards positive axes,
max(d, 0). So in slip, with the mean E and the duration T,

    int f dt = -mu_k int N d dt - int C3 |v2| d dt,     int N d dt = T (E[N] E[d] + Cov(N, d))
"""

from __future__ import annotations

from hydrosim.forces.contact import geometry, laws
from hydrosim.forces.contact.fender import CONTACT_STATES, normal_load_of
from hydrosim.forces.contact.laws import COULOMB
from hydrosim.forces.contact.modes import SLIP, STICK
from hydrosim.jit.kernels import clear, kernel
from hydrosim.modes import MODE
from hydrosim.rigid.vectors import add, length, scale

MODES = ("open", "stick", "slip")
TALLIES_OF_MODES = (  # for each mode: name and number of entries
    *(("time", 1), ("impulse", 1), ("press", 3), ("friction", 3)),
    *(("moved", 3), ("friction_work", 3), ("press_work", 1)),
)
TALLIES_OF_SLIP = (  # in slip also
    *(("slip_direction", 3), ("slip_load", 3), ("slip_damping", 3), ("slip_moved", 3)),
    *(("slip_direction_ahead", 3), ("slip_load_ahead", 3), ("slip_moved_ahead", 3)),
)
MODE_TALLIES = sum(count for _, count in TALLIES_OF_MODES)
POINT_TALLIES = len(MODES) * MODE_TALLIES + sum(count for _, count in TALLIES_OF_SLIP)


@kernel
def add_tallies(t, y, modes, motion, bodies, p, reactions, rates):
    """Rates of the integrals of all points, `POINT_TALLIES` for each, with the ``reactions`` (nf,
    2) of rigid friction."""
    clear(rates[: POINT_TALLIES * p.points.size])
    for i in range(p.points.size):
        point, mode, k = p.points[i], modes[p.mode + i, MODE], p.state + CONTACT_STATES * i
        c = geometry.contact_kinematics(point, bodies, motion)
        load = normal_load_of(i, t, y, modes, c, p)
        law = laws.friction(mode, load, c.velocity, (y[k], y[k + 1]), point)
        f = law.force
        if point.law == COULOMB and mode == STICK:
            f = (reactions[i, 0], reactions[i, 1])
        first = POINT_TALLIES * i + MODE_TALLIES * mode
        _add_mode_tallies(load.N, f, c, rates[first : first + MODE_TALLIES])
        if mode == SLIP and length(f) > 0.0:
            last = POINT_TALLIES * (i + 1)
            _add_slip_tallies(
                load.N, f, law, c, rates[POINT_TALLIES * i + len(MODES) * MODE_TALLIES : last]
            )


@kernel
def _add_mode_tallies(N, f, c, out):
    """The rates of `TALLIES_OF_MODES`."""
    force, press = _earth_vector(f, c), scale(N, c.normal)
    w = _earth_vector(c.velocity, c)
    out[0], out[1], out[MODE_TALLIES - 1] = 1.0, N, -N * c.rate
    for a in range(3):
        out[2 + a], out[5 + a], out[8 + a] = press[a], force[a], w[a]
        out[11 + a] = force[a] * w[a]


@kernel
def _add_slip_tallies(N, f, law, c, out):
    """The rates of `TALLIES_OF_SLIP`."""
    size, v2 = length(f), law.slip_speed
    d = _earth_vector((-f[0] / size, -f[1] / size), c)
    damping = law.slip_damped / v2 if v2 != 0.0 else 0.0
    for a in range(3):
        ahead = max(d[a], 0.0)
        out[a], out[3 + a], out[6 + a], out[9 + a] = d[a], N * d[a], damping * d[a], v2 * d[a]
        out[12 + a], out[15 + a], out[18 + a] = ahead, N * ahead, v2 * ahead


@kernel
def _earth_vector(u, c):
    """A vector (2,) in the plane, turned into the earth frame."""
    return add(scale(u[0], c.tangent1), scale(u[1], c.tangent2))
