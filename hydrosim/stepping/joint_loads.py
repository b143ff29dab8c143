"""Loads in the joints of trees, from Newton's law for what each of them carries.

    r = (M + A) v' - F        of every body; F: all forces but the reactions of joints of trees
    load of a joint = sum of r of its child and of all that the child carries

F has the rows of `dynamics.rhs` with the gyroscopic terms and those of the turning added mass.
"""

from __future__ import annotations

from hydrosim.jit.kernels import kernel, root
from hydrosim.rigid.added_mass import add_turning
from hydrosim.rigid.kinematics import accelerations
from hydrosim.rigid.tree import NO_BODY, arm_to_joint
from hydrosim.rigid.vectors import add, cross, sub, vector
from hydrosim.stepping.dynamics import find_mass, subtract_gyroscopic, total_force


@root
def find_joint_loads(x, model, work, out):
    """Write force and moment (6,) about the joint of each branch k to ``out`` from 6 k on: on the
    joint's body, in the earth frame. ``x`` (n,) are the accelerations that `rhs` has just found in
    ``work``."""
    bodies = model.bodies
    motion = work.motion
    tree = bodies.tree
    force = work.total
    _find_missing(x, model, work, force)
    for j in range(tree.branches.size):
        k = tree.branches.size - 1 - j
        branch = tree.branches[k]
        c = 6 * branch.child
        F = vector(force, c)
        moment = sub(vector(force, c + 3), cross(arm_to_joint(k, 0, bodies, motion), F))
        sign = -1.0 if branch.reversed else 1.0
        for i in range(3):
            out[6 * branch.joint + i] = sign * F[i]
            out[6 * branch.joint + 3 + i] = sign * moment[i]
        if branch.parent != NO_BODY:
            p = 6 * branch.parent
            onward = add(moment, cross(arm_to_joint(k, 1, bodies, motion), F))
            for i in range(3):
                force[p + i] += F[i]
                force[p + 3 + i] += onward[i]


@kernel
def _find_missing(x, model, work, missing):
    """(M + A) v' - F (6 nb,), the wrenches that the joints of trees must give."""
    bodies = model.bodies
    motion = work.motion
    A = work.blend.added_mass if model.family.body.size > 0 else model.added_mass
    total_force(work.wrench, missing)
    subtract_gyroscopic(bodies, work.contents, motion, missing)
    if model.headings.turning.size > 0:
        add_turning(model.headings, A, bodies, motion, work.hulls, missing)
    find_mass(model, A, work)
    a = work.push
    accelerations(x, bodies, motion, a)
    for i in range(missing.size):
        missing[i] = -missing[i]
        for j in range(a.size):
            missing[i] += work.mass[i, j] * a[j]
