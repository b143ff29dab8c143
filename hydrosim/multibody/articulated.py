"""Accelerations of trees of joints in a time that grows with their number.

A body has the acceleration alpha + b, with the bias b of `multibody.tree`. From its parent to
itself

    alpha = X alpha_parent + sum_j s_j u_j',   X: v += omega x r

s_j: the column of coordinate j at the body's centre of gravity, r: from the parent's centre of
gravity to the body's. From the leaves to the roots each coordinate is eliminated:

    I alpha = F,   U = I s,   D = s U,   I -= U U^T / D,   F -= U (s F) / D

and what is left of both is added to the parent, X^T I X and X^T F. I begins as mass and added mass
of the body, F as its wrench less I b. Then from the roots to the leaves u_j' = (s F - U alpha) / D,
with the values of its elimination (Featherstone 2008, chapter 7).

Limits: no added mass between bodies, exact rotations, no constraints. Other scenes use the whole
matrix (`multibody.tree.add_inertia`).
"""

from __future__ import annotations

from math import nan

from hydrosim.jit.kernels import clear, kernel, root
from hydrosim.multibody.tree import NO_BODY, carry_acceleration, carry_wrench, coordinate_count
from hydrosim.multibody.vectors import add, cross, dot, matvec, scale, sub, vector

TRANSLATION, COUPLING, ROTATION = 0, 3, 6
"""First rows of the blocks of I: forces by translations and by rotations, moments by rotations."""


@root
def accelerate_articulated(bodies, contents, headings, added_mass, motion, F, x):
    """Accelerations ``x`` (n,) of the free coordinates under the wrenches ``F`` (6 nb,), from which
    gyroscopic moments have been subtracted; ``added_mass`` (6 nb, 6 nb) is in heading axes."""
    tree = bodies.tree
    growth = motion.growth
    _fill_inertia(bodies, contents, headings, added_mass, motion)
    for b in range(bodies.each.size):
        _begin_load(b, F, motion)
    for k in range(tree.branches.size - 1, -1, -1):
        branch = tree.branches[k]
        for m in range(branch.last - 1, branch.first - 1, -1):
            move = tree.moves[m]
            for a in range(coordinate_count(move) - 1, -1, -1):
                _eliminate(move.coordinate + a, branch.child, growth)
        if branch.parent != NO_BODY:
            _pass_to_parent(branch.child, branch.parent, vector(growth.arm[k], 0), growth)
    roots = bodies.active.size - tree.coordinates
    for j in range(roots - 1, -1, -1):
        _eliminate(j, bodies.active[j] // 6, growth)
    clear(growth.carried)
    for j in range(roots):
        _solve(j, bodies.active[j] // 6, growth, x)
    for k in range(tree.branches.size):
        branch = tree.branches[k]
        if branch.parent != NO_BODY:
            arm = vector(growth.arm[k], 0)
            carry_acceleration(branch.parent, branch.child, arm, growth.carried)
        for m in range(branch.first, branch.last):
            move = tree.moves[m]
            for a in range(coordinate_count(move)):
                _solve(move.coordinate + a, branch.child, growth, x)


@kernel
def _fill_inertia(bodies, contents, headings, added_mass, motion):
    """I of every body alone: its mass about its origin, m [c x], R I R^T, and its added mass."""
    inertia = motion.growth.inertia
    for b in range(bodies.each.size):
        k = 6 * b
        for i in range(3):
            for j in range(3):
                inertia[b, TRANSLATION + i, j] = added_mass[k + i, k + j]
                inertia[b, COUPLING + i, j] = added_mass[k + i, k + 3 + j]
                inertia[b, ROTATION + i, j] = added_mass[k + 3 + i, k + 3 + j]
    for b in headings.turned:
        _turn_blocks(motion.rate_map[b], inertia[b])
    for b in range(bodies.each.size):
        R = motion.rotation[b]
        own_inertia = contents.inertia[b]
        for i in range(3):
            inertia[b, TRANSLATION + i, i] += contents.moving_mass[b]
            column = matvec(R, matvec(own_inertia, (R[i, 0], R[i, 1], R[i, 2])))
            for j in range(3):
                inertia[b, ROTATION + j, i] += column[j]
        moment = vector(contents.moving_moment[b], 0)
        if moment[0] != 0.0 or moment[1] != 0.0 or moment[2] != 0.0:
            moment = matvec(R, moment)
            for i in range(3):
                j = (i + 1) % 3
                h = (i + 2) % 3
                inertia[b, COUPLING + i, j] += moment[h]
                inertia[b, COUPLING + i, h] -= moment[j]


@kernel
def _turn_blocks(E, blocks):
    """Turn the ``blocks`` (9, 3) of a body from its heading axes into the earth's."""
    c = E[1, 1]
    s = -E[0, 1]
    for k in (TRANSLATION, COUPLING, ROTATION):
        for i in range(3):
            first, second = blocks[k, i], blocks[k + 1, i]
            blocks[k, i] = c * first - s * second
            blocks[k + 1, i] = s * first + c * second
        for i in range(k, k + 3):
            first, second = blocks[i, 0], blocks[i, 1]
            blocks[i, 0] = c * first - s * second
            blocks[i, 1] = s * first + c * second


@kernel
def _multiply(blocks, v, w):
    """I times (v, w)."""
    force = (
        dot(vector(blocks[0], 0), v) + dot(vector(blocks[3], 0), w),
        dot(vector(blocks[1], 0), v) + dot(vector(blocks[4], 0), w),
        dot(vector(blocks[2], 0), v) + dot(vector(blocks[5], 0), w),
    )
    moment = add(
        add(scale(v[0], vector(blocks[3], 0)), scale(v[1], vector(blocks[4], 0))),
        scale(v[2], vector(blocks[5], 0)),
    )
    turning = (
        dot(vector(blocks[6], 0), w),
        dot(vector(blocks[7], 0), w),
        dot(vector(blocks[8], 0), w),
    )
    return force, add(moment, turning)


@kernel
def _begin_load(b, F, motion):
    """F less I b of body ``b``."""
    k = 6 * b
    bias = vector(motion.bias, k), vector(motion.bias, k + 3)
    force, moment = _multiply(motion.growth.inertia[b], bias[0], bias[1])
    _put(sub(vector(F, k), force), motion.growth.carried, k)
    _put(sub(vector(F, k + 3), moment), motion.growth.carried, k + 3)


@kernel
def _put(value, target, k):
    target[k], target[k + 1], target[k + 2] = value


@kernel
def _eliminate(j, b, growth):
    """Eliminate coordinate ``j`` from I and F of body ``b``."""
    blocks = growth.inertia[b]
    k = 6 * b
    v = vector(growth.columns[j], 0)
    w = vector(growth.columns[j], 3)
    force, moment = _multiply(blocks, v, w)
    F = vector(growth.carried, k)
    M = vector(growth.carried, k + 3)
    push = dot(v, F) + dot(w, M)
    D = dot(v, force) + dot(w, moment)
    inverse = 1.0 / D if D > 0.0 else nan
    _put(force, growth.pulls[j], 0)
    _put(moment, growth.pulls[j], 3)
    growth.pushes[j] = push
    growth.pivots[j] = inverse
    share = push * inverse
    _put(sub(F, scale(share, force)), growth.carried, k)
    _put(sub(M, scale(share, moment)), growth.carried, k + 3)
    for i in range(3):
        by_force = inverse * force[i]
        by_moment = inverse * moment[i]
        for a in range(3):
            blocks[TRANSLATION + i, a] -= by_force * force[a]
            blocks[COUPLING + i, a] -= by_force * moment[a]
            blocks[ROTATION + i, a] -= by_moment * moment[a]


@kernel
def _pass_to_parent(child, parent, r, growth):
    """Add what is left of I and F of the ``child`` to its parent, whose centre of gravity is at -r
    from its own."""
    own = growth.inertia[child]
    base = growth.inertia[parent]
    B = (
        add(vector(own[3], 0), cross(r, vector(own[0], 0))),
        add(vector(own[4], 0), cross(r, vector(own[1], 0))),
        add(vector(own[5], 0), cross(r, vector(own[2], 0))),
    )
    lifted = (
        sub(scale(r[1], B[2]), scale(r[2], B[1])),
        sub(scale(r[2], B[0]), scale(r[0], B[2])),
        sub(scale(r[0], B[1]), scale(r[1], B[0])),
    )
    for i in range(3):
        turned = add(cross(r, (own[3, i], own[4, i], own[5, i])), lifted[i])
        for a in range(3):
            base[TRANSLATION + i, a] += own[TRANSLATION + i, a]
            base[COUPLING + i, a] += B[i][a]
            base[ROTATION + i, a] += own[ROTATION + i, a] + turned[a]
    carry_wrench(child, parent, r, growth.carried)


@kernel
def _solve(j, b, growth, x):
    """The acceleration of coordinate ``j``, added to alpha of body ``b``."""
    k = 6 * b
    v = vector(growth.carried, k)
    w = vector(growth.carried, k + 3)
    felt = dot(vector(growth.pulls[j], 0), v) + dot(vector(growth.pulls[j], 3), w)
    x[j] = (growth.pushes[j] - felt) * growth.pivots[j]
    _put(add(v, scale(x[j], vector(growth.columns[j], 0))), growth.carried, k)
    _put(add(w, scale(x[j], vector(growth.columns[j], 3))), growth.carried, k + 3)
