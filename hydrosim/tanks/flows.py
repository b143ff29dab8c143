"""Flow between tanks and the sea, and its force on the body.

v, w: velocities of body and axes; M: the 6 x 6 matrix of the body with its contents, about its
origin; M'_in, M'_out, M'_between: its rates of change by inflow from the sea, outflow to the sea
and flow between tanks. The momentum inside a surface around the body changes by the forces and by
the flow through the surface,

    d/dt (M v + p) = F + M'_out v + M'_in u,   M' = M'_in + M'_out + M'_between.

Outflow has the velocity of the body at its outlet and gives no force. Inflow has the velocity of
the sea, u: the current. Between tanks the fluid flows along a straight line, with the momentum
relative to the body

    p = q (r_2 - r_1),   l = q r_1 x r_2   (about the origin),

q: mass per time; r: centroids of the surfaces, S'(V) of `surface`. So the force of the flow is

    F = -M'_in (v - u) - M'_between v - p' - (0, v x p),

p' in earth axes. When a flow between tanks begins or ends, p jumps, and the impulse -p makes the
velocity jump: the momentum of body and fluid is conserved. (Cveticanin 2015, Dynamics of Bodies
with Time-Variable Mass, chapter 3.)

Energy: kinetic energy is v M v / 2. Its change by flow, v F + v M' v / 2, and the change of the
weight's potential are booked as work.
"""

from __future__ import annotations

from hydrosim.jit.kernels import kernel, piece_of, root
from hydrosim.multibody.kinematics import vertical_in_body
from hydrosim.multibody.vectors import add, cross, dot, matvec, scale, sub, vector
from hydrosim.tanks.pumping import SEA_INDEX, rate_of
from hydrosim.tanks.surface import FIRST_MOMENT, SECOND_MOMENT, SURFACE_MOMENT, bend, slope


@kernel
def surface_of(k, y, p):
    """Centroid r (3,) of the surface of tank ``k``, the derivative of r by V, and P' about the
    origin, in the body frame."""
    tank = p.each[k]
    piece = p.pieces[piece_of(y[p.state + k], tank.first, tank.last, p.pieces)]
    x = y[p.state + k] - piece.start
    r = (
        slope(piece, FIRST_MOMENT, x),
        slope(piece, FIRST_MOMENT + 1, x),
        slope(piece, FIRST_MOMENT + 2, x),
    )
    dr = (
        bend(piece, FIRST_MOMENT, x),
        bend(piece, FIRST_MOMENT + 1, x),
        bend(piece, FIRST_MOMENT + 2, x),
    )
    square = (
        slope(piece, SECOND_MOMENT, x),
        slope(piece, SECOND_MOMENT + 1, x),
        slope(piece, SECOND_MOMENT + 2, x),
    )
    mixed = (
        slope(piece, SECOND_MOMENT + 3, x),
        slope(piece, SECOND_MOMENT + 4, x),
        slope(piece, SECOND_MOMENT + 5, x),
    )
    return r, dr, square, mixed


@kernel
def turning(square, mixed, w):
    """(tr P - P) w."""
    trace = square[0] + square[1] + square[2]
    return (
        (trace - square[0]) * w[0] - mixed[0] * w[1] - mixed[1] * w[2],
        (trace - square[1]) * w[1] - mixed[0] * w[0] - mixed[2] * w[2],
        (trace - square[2]) * w[2] - mixed[1] * w[0] - mixed[2] * w[1],
    )


@root
def add_force(t, y, modes, motion, bodies, p, heights, wrench, rate, dy):
    """Add rates of the volumes to ``dy``, and the force of all flows to its row of ``wrench``.
    Their effects on kinetic and potential energy go to the entries of flow and weight in ``rate``.
    ``heights`` (nl,) are the heights of level surfaces above the origins of their bodies."""
    for k in range(p.each.size):
        dy[p.state + k] = 0.0
    for i in range(p.flows.size):
        flow, q = p.flows[i], rate_of(i, modes, p)
        if flow.source != SEA_INDEX:
            dy[p.state + flow.source] -= q / p.each[flow.source].density
        if flow.target != SEA_INDEX:
            dy[p.state + flow.target] += q / p.each[flow.target].density
    for i in range(p.flows.size):
        q = rate_of(i, modes, p)
        if q != 0.0 and p.flows[i].inertial:
            _add_flow_force(i, q, y, motion, bodies, p, wrench, rate, dy)
    for k in range(p.each.size):
        gained = p.each[k].density * dy[p.state + k]
        if gained != 0.0:
            rate[p.weight] += gained * p.gravity * _lift_height(k, y, motion, bodies, p, heights)


@kernel
def _body_velocities(b, motion, bodies, current):
    """Velocity of body ``b`` relative to the earth and to the current, and its angular velocity, in
    its own axes; in the axes at rest in linear kinematics."""
    v, w = vector(motion.velocity, 6 * b), vector(motion.velocity, 6 * b + 3)
    u = (v[0] - current[b, 0], v[1] - current[b, 1], v[2])
    if not bodies.exact:
        return v, u, w
    T = motion.rotation[b].T
    return matvec(T, v), matvec(T, u), matvec(T, w)


@kernel
def _add_flow_force(i, q, y, motion, bodies, p, wrench, rate, dy):
    """Force of flow ``i``, and its effect on kinetic energy."""
    flow = p.flows[i]
    v, u, w = _body_velocities(flow.body, motion, bodies, p.current)
    force, moment = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    grown = 0.0
    if flow.source != SEA_INDEX and flow.target != SEA_INDEX:
        force, moment = _flow_load(flow, q, w, bodies.exact, y, p, dy)
    elif q > 0.0 and flow.target != SEA_INDEX:
        r, _, square, mixed = surface_of(flow.target, y, p)
        force = scale(-q, add(u, cross(w, r)))
        moment = scale(-q, add(cross(r, u), turning(square, mixed, w)))
    if flow.source != SEA_INDEX:
        grown -= _inertia_rate(flow.source, v, w, y, p)
    if flow.target != SEA_INDEX:
        grown += _inertia_rate(flow.target, v, w, y, p)
    rate[p.row] += dot(force, v) + dot(moment, w) + 0.5 * q * grown
    if bodies.exact:
        R = motion.rotation[flow.body]
        force, moment = matvec(R, force), matvec(R, moment)
    for j in range(3):
        wrench[p.row, 6 * flow.body + j] += force[j]
        wrench[p.row, 6 * flow.body + 3 + j] += moment[j]


@kernel
def _flow_load(flow, q, w, exact, y, p, dy):
    """Force and moment of a flow between tanks, in body axes."""
    a, da, square_a, mixed_a = surface_of(flow.source, y, p)
    b, db, square_b, mixed_b = surface_of(flow.target, y, p)
    da, db = scale(dy[p.state + flow.source], da), scale(dy[p.state + flow.target], db)
    along, around = scale(q, sub(b, a)), scale(q, cross(a, b))
    force = scale(-q, sub(db, da))
    moment = scale(-q, add(cross(da, b), cross(a, db)))
    turned = sub(turning(square_b, mixed_b, w), turning(square_a, mixed_a, w))
    force, moment = sub(force, cross(w, along)), sub(moment, scale(q, turned))
    if exact:
        force, moment = sub(force, cross(w, along)), sub(moment, cross(w, around))
    return force, moment


@kernel
def _inertia_rate(k, v, w, y, p):
    """(v, w) M' (v, w) for a unit of mass in tank ``k``, in body axes."""
    r, _, square, mixed = surface_of(k, y, p)
    return dot(v, v) + 2.0 * dot(v, cross(w, r)) + dot(w, turning(square, mixed, w))


@kernel
def _lift_height(k, y, motion, bodies, p, heights):
    """dU/dm / g for mass that enters tank ``k``: its height above the still water plus the change
    of the free surface term. For a level surface (`hydrosim.tanks.surface`) it is the height of the
    surface."""
    tank, b = p.each[k], p.each[k].body
    height = bodies.each[b].origin[2] + motion.coordinates[6 * b + 2]
    if tank.liquid >= 0:
        return height + heights[tank.liquid]
    piece = p.pieces[piece_of(y[p.state + k], tank.first, tank.last, p.pieces)]
    x, n = y[p.state + k] - piece.start, vertical_in_body(b, motion, bodies)
    r, _, _, _ = surface_of(k, y, p)
    xx, xy = slope(piece, SURFACE_MOMENT, x), slope(piece, SURFACE_MOMENT + 1, x)
    square = (
        xx * n[0] * n[0]
        + 2.0 * xy * n[0] * n[1]
        + slope(piece, SURFACE_MOMENT + 2, x) * n[1] * n[1]
    )
    if bodies.exact:
        return height + dot(n, r) - square / (2.0 * n[2])
    lowered = r[2] * (1.0 - 0.5 * (n[0] * n[0] + n[1] * n[1]))
    return height + n[0] * r[0] + n[1] * r[1] + lowered - 0.5 * square


@root
def add_momentum(factor, y, modes, motion, bodies, p, wrench):
    """Add ``factor`` times the momentum of the flows between tanks, relative to their bodies, to
    ``wrench`` (6 nb,)."""
    for i in range(p.flows.size):
        flow, q = p.flows[i], factor * rate_of(i, modes, p)
        if q == 0.0 or flow.source == SEA_INDEX or flow.target == SEA_INDEX or not flow.inertial:
            continue
        a, _, _, _ = surface_of(flow.source, y, p)
        b, _, _, _ = surface_of(flow.target, y, p)
        along, around = scale(q, sub(b, a)), scale(q, cross(a, b))
        if bodies.exact:
            R = motion.rotation[flow.body]
            along, around = matvec(R, along), matvec(R, around)
        for j in range(3):
            wrench[6 * flow.body + j] += along[j]
            wrench[6 * flow.body + 3 + j] += around[j]
