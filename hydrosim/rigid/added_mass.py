"""Added mass that turns with the heading of each body (Kirchhoff's equations in earth axes).

The water that a body sets in motion has the kinetic energy

    T = w^T A(psi) w / 2,   A(psi) = P A P^T,   w = v - U

P: from the heading axes of each body to the earth's (`heading`); U: the current on each body.
Lagrange's equations in w give the force on the bodies: force p', moment G' - omega x G, and
-dT/dpsi on psi. (Lamb 1932, art. 124 has them for axes fixed in a body.) With the momentum
(p, G) = A(psi) w,

    F = -p',   M = -G' + omega x G + E^-T (0, 0, dT/dpsi),
    dT/dpsi = w^T J A(psi) w = -e_z . (w_t x p + omega x G)

The last term is Munk's moment. For a jointed body it acts on all joints that turn its heading
(`rigid.tree`). The part -A(psi) v' is inertia; `add_turning` adds the rest. The
rest does no net work but conserves momentum: the work of F is -dT/dt. Body and water together keep
their linear impulse, and their angular impulse about a vertical through any fixed point.
"""

from __future__ import annotations

from hydrosim.jit.kernels import clear, kernel, root
from hydrosim.rigid.heading import all_to_earth, all_to_heading, heading_rate
from hydrosim.rigid.tree import add_heading_moment
from hydrosim.rigid.vectors import cross, vector


@root
def add_turning(p, A, bodies, motion, hulls, total):
    """Add to ``total`` (6 nb,) the force of the water without -A(psi) v'; ``hulls.flow`` must be
    filled.

    With z = psi' J P^T w of each turning body, the force is P (A z - psi' J A P^T w), with the
    moments above.
    """
    turn, momentum, force = hulls.turn, hulls.momentum, hulls.force
    clear(turn)
    for b in p.turning:
        _add_turned(heading_rate(b, motion), 6 * b, hulls.flow, turn)
    multiply(A, hulls.flow, momentum)
    multiply(A, turn, force)
    for b in p.turning:
        _add_turned(-heading_rate(b, motion), 6 * b, momentum, force)
        _add_spin(6 * b, hulls.flow, momentum, force)
    all_to_earth(p, motion, force)
    for b in p.turning:
        moment = _heading_moment(6 * b, hulls.flow, momentum)
        add_heading_moment(b, moment, bodies, motion, force)
    for i in range(total.size):
        total[i] += force[i]


@kernel
def _add_turned(rate, k, x, out):
    """Add ``rate`` times J x for the body whose entries begin at k."""
    for i in (k, k + 3):
        out[i] -= rate * x[i + 1]
        out[i + 1] += rate * x[i]


@kernel
def _add_spin(k, w, momentum, force):
    """Add omega x G, in heading axes."""
    spin = cross(vector(w, k + 3), vector(momentum, k + 3))
    for i in range(3):
        force[k + 3 + i] += spin[i]


@kernel
def _heading_moment(k, w, momentum):
    """dT/dpsi of one body."""
    spin = cross(vector(w, k + 3), vector(momentum, k + 3))
    munk = cross(vector(w, k), vector(momentum, k))
    return -munk[2] - spin[2]


@kernel
def multiply(A, x, out):
    """``out`` = A x."""
    for i in range(out.size):
        entry = 0.0
        for j in range(x.size):
            entry += A[i, j] * x[j]
        out[i] = entry


@kernel
def stream_energy(p, A, motion, hulls):
    """Energy U^T A(psi) U / 2 of the current. Subtract it from v^T A(psi) v / 2, so that the work
    of -d/dt(A(psi) w) on v equals that of -dT/dt."""
    if p.turning.size == 0:
        return 0.0
    U, energy = hulls.turn, 0.0
    clear(U)
    for b in range(U.size // 6):
        U[6 * b], U[6 * b + 1] = p.current[b, 0], p.current[b, 1]
    all_to_heading(p, motion, U)
    for i in range(U.size):
        for j in range(U.size):
            energy += 0.5 * U[i] * A[i, j] * U[j]
    return energy
