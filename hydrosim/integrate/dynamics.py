"""The equation of motion.

    v = S u,   S^T (M + A) S u' = S^T (F - F_gyroscopic + F_turning - (M + A) S' u),   q' = N u

    F = F_hydrostatic + F_radiation + F_wave1 + F_wave2 + F_elements + F_weight

q: free coordinates of all bodies and joints; u: their rates, N is the identity except for ball
joints (`multibody.tree`); v: velocities of the centres of gravity and angular velocities in
the earth frame; M: mass, m and R I R^T; A: added mass at infinite frequency; F_gyroscopic = omega x
(R I R^T omega). (Cummins 1962; Ogilvie 1964.)

If the contents of a body change (`tanks`), M is about the body's origin. It then has m [c x], where
c is the displacement of the centre of gravity from the origin. F_gyroscopic has m omega x (omega x
c), and F includes the forces of flow.

A and the retardation functions are constant in axes that turn with the yaw of each body;
F_turning is the resulting force (`multibody.heading`). Constraints, such as rigid friction, add J
u' = c, with J^T lambda on the right.

The state is y = (q, u, radiation states, contact points, energies, impulses). The energies are
integrals: for every row of forces its work (waves, applied forces) or its dissipation (all others),
and the integral of |wave power|. If requested, the impulses of every row, its works by coordinate,
and the integrals of contact points (`elements.contact.kind`) follow.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hydrosim import elements
from hydrosim.elements import Elements, add_element_energies, add_elements, events
from hydrosim.elements.hydrostatics import MeshHulls as Displacement
from hydrosim.elements.hydrostatics import (
    Weights,
    add_displacement,
    add_displacement_energy,
    add_hydrostatic_energy,
    add_hydrostatics,
    add_weight,
    add_weight_energy,
)
from hydrosim.elements.joint import load_friction
from hydrosim.elements.joint.rows import Holds, new_holds
from hydrosim.elements.kind import RADIATION, WAVE_FIRST_ORDER, WAVE_SECOND_ORDER
from hydrosim.integrate.draught_interpolation import (
    Blend,
    DraughtFamilies,
    add_forces_of_members,
    added_mass_rate_force,
    blend_draughts,
    draught_rates,
    new_blend,
    velocities_of_members,
)
from hydrosim.integrate.methods import Filters
from hydrosim.jit.kernels import assign, clear, kernel, root, root_giving
from hydrosim.multibody.articulated import accelerate_articulated
from hydrosim.multibody.constraints import (
    Constraints,
    eliminate,
    find_forces,
    new_constraints,
    reduce_load,
    restore_pivots,
    solve_for_pivots,
)
from hydrosim.multibody.heading import (
    Headings,
    HeadingScratch,
    add_turning,
    all_to_earth,
    all_to_heading,
    find_flow,
    motion_along,
    new_heading_scratch,
    stream_energy,
    translations_to_earth,
)
from hydrosim.multibody.kinematics import (
    Bodies,
    Motion,
    acceleration_map,
    generalised_force,
    new_motion,
    place_bodies,
    place_bodies_inline,
)
from hydrosim.multibody.mass import (
    Contents,
    Inertia,
    Turning,
    accelerate_freely,
    cholesky,
    cholesky_solve,
    kinetic_energy,
    mass_matrix,
    new_contents,
    new_turning,
)
from hydrosim.multibody.tree import fill_rates, push_joint, sum_joint_loads
from hydrosim.multibody.vectors import cross, matvec, vector
from hydrosim.tanks import contents, flows
from hydrosim.tanks.contents import Tanks
from hydrosim.tanks.surface import Liquids, level_surfaces
from hydrosim.water.body import turn_moments
from hydrosim.water.displaced_loads import FollowingLoads, Sums, following_loads, new_sums
from hydrosim.water.loads import WaveLoads, any_waves, wave_loads
from hydrosim.water.radiation.convolution import ConvolutionKernel, radiation_memory
from hydrosim.water.radiation.memory import (
    ConstantDamping,
    RadiationStates,
    radiation_damping,
    radiation_states,
)
from hydrosim.water.slow_path_loads import SlowBlock, find_yaws, new_block, slow_loads, slow_rates


class Model(NamedTuple):
    """Constants of a scene, arrays only; n free coordinates, nb bodies, nr rows of forces.

    These fields are the first entries of parts of y: ``radiation``, ``own`` (of elements), ``slow``
    (of slow positions in waves), ``draught`` (slow draughts of families), ``energy`` and
    ``impulse``. y has the length ``size``; it ends at ``impulse`` if no impulses are asked for.
    """

    bodies: Bodies
    headings: Headings
    added_mass: np.ndarray  # (6 nb, 6 nb), A_inf, or A(w) of a body with constant radiation
    inertia: Inertia
    stiffness: np.ndarray  # (nb, 6, 6), hydrostatic; zero for bodies with a hull
    hulls: Displacement
    states: RadiationStates
    convolution: ConvolutionKernel
    damping: ConstantDamping
    waves: WaveLoads
    following: FollowingLoads
    family: DraughtFamilies
    elements: Elements
    tanks: Tanks
    liquids: Liquids
    weights: Weights
    rows: int
    radiation: int
    own: int
    slow: int
    draught: int
    energy: int
    impulse: int
    size: int


class Work(NamedTuple):
    """Scratch of one evaluation of `rhs`; its content is not kept after the call."""

    motion: Motion
    hulls: HeadingScratch
    contents: Contents
    wrench: np.ndarray  # (nr, 6 nb), force of every row
    rate: np.ndarray  # (nr,), work or dissipation of every row
    total: np.ndarray  # (6 nb,)
    mass: np.ndarray  # (6 nb, 6 nb)
    inertia: np.ndarray  # (n, n)
    turning: Turning
    constraints: Constraints
    holds: Holds
    friction: load_friction.LoadFrictionScratch
    sums: Sums  # of `following_loads`
    block: SlowBlock  # of `slow_loads`
    met: np.ndarray  # (nb,), yaw at which waves meet each body
    blend: Blend
    push: np.ndarray  # (6 nb,), impulse of flows that begin or end
    jump: np.ndarray  # (2, n), its effect
    clearances: np.ndarray  # (2, nt, 3), of surfaces in tanks at both ends of a step
    loads_only: np.ndarray  # (1,), set where nothing but loads is asked for; kept


def motion_at(model: Model, y: np.ndarray) -> Motion:
    """Motion of all bodies at the state ``y``, in arrays of its own."""
    n = model.bodies.active.size
    motion = new_work(model).motion
    place_bodies(y[:n], y[n : 2 * n], model.bodies, motion)
    return motion


def new_work(model: Model) -> Work:
    """Scratch for this model."""
    m = 6 * model.bodies.each.size
    n = model.bodies.active.size
    rows = most_constraints(model)
    return Work(
        new_motion(model.bodies, elements.pieces_of_lines(model.elements)),
        new_heading_scratch(model.bodies),
        new_contents(model.bodies, model.liquids.each.size),
        np.zeros((model.rows, m)),
        np.zeros(model.rows),
        np.zeros(m),
        np.zeros((m, m)),
        np.zeros((n, n)),
        new_turning(model.inertia),
        new_constraints(rows, n),
        new_holds(
            events.count_reaction_rows(model.elements),
            rows,
            events.joint_count(model.elements),
            events.drive_count(model.elements),
        ),
        load_friction.new_load_friction(
            model.elements, model.bodies.each.size, model.rows, n, rows
        ),
        new_sums(model.following),
        new_block(model.following),
        np.zeros(model.bodies.each.size),
        new_blend(model.family, model.bodies.each.size),
        np.zeros(m),
        np.zeros((2, n)),
        np.zeros((2, len(model.liquids.solids.corners), 3)),
        np.zeros(1, dtype=np.int64),
    )


def most_constraints(model: Model) -> int:
    """Largest number of rows of `add_constraints`."""
    return events.held_directions(model.elements)


def dynamic_states(model: Model) -> np.ndarray:
    """Entries (m,) of y that act on others: all except slip distances, headings and energies."""
    motion = np.arange(model.own)
    return np.concatenate([motion, elements.coupled_states(model)]).astype(np.int64)


def radiation_filters(model: Model) -> Filters:
    """The radiation states of the model, pole by pole or pair by pair."""
    p = model.states
    x_entries = []
    z_entries = []
    for first, last, real in zip(p.state[:-1], p.state[1:], p.real, strict=True):
        alone = np.arange(first, first + real)
        pairs = np.arange(first + real, last).reshape(2, -1)
        x_entries += [alone, pairs[0]]
        z_entries += [alone, pairs[1]]
    x, z = (
        np.concatenate([np.zeros(0, dtype=np.int64), *indices])
        for indices in (x_entries, z_entries)
    )
    rotation = np.where(x == z, 0.0, p.rotation[x])
    return Filters(model.radiation + x, model.radiation + z, p.decay[x], rotation)


@root
def rhs(t, y, modes, history, model, work, dy):
    """Fill ``dy`` = y'(t) for the contact ``modes`` and the velocity ``history``. Changes scratch
    and ``dy`` only. With ``work.loads_only`` it ends when the forces of all rows and their sum are
    in ``work``."""
    n = model.bodies.active.size
    motion = work.motion
    place_bodies_inline(y[:n], y[n : 2 * n], model.bodies, motion)
    if model.headings.turned.size > 0:
        find_flow(model.headings, motion, work.hulls)
    blends = model.family.body.size > 0
    if blends:
        blend_draughts(y[model.draught :], model.family, model.added_mass, work.blend)
    A = work.blend.added_mass if blends else model.added_mass
    update_contents(y, model, work)
    add_forces(t, y, modes, history, model, work, dy)

    total_force(work.wrench, work.total)
    if work.loads_only[0] != 0:
        return
    acceleration = dy[n : 2 * n]
    assign(dy[:n], y[n : 2 * n])
    if model.bodies.tree.branches.size > 0:
        fill_rates(y[:n], y[n : 2 * n], model.bodies, dy[:n])
    subtract_gyroscopic(model.bodies, work.contents, motion, work.total)
    if model.headings.turning.size > 0:
        add_turning(model.headings, A, model.bodies, motion, work.hulls, work.total)
    steady = model.headings.steady and not blends and model.tanks.each.size == 0
    events.find_driven_motion(t, model.elements, work.holds)
    held = may_hold(modes, model, work)
    if not held and is_articulated(model):
        contents = work.contents
        accelerate_articulated(
            model.bodies, contents, model.headings, A, motion, work.total, acceleration
        )
    elif held or not steady:
        accelerate(y, modes, model, work, acceleration)
    elif model.headings.turned.size > 0:
        accelerate_along(model, work, acceleration)
    else:
        accelerate_freely(
            model.inertia, model.bodies, motion, work.total, work.turning, acceleration
        )
    energies = dy[model.energy :]
    events.add_drive_power(y, model.bodies, model.elements, work.holds, energies)
    events.add_friction_power(y, modes, model.bodies, model.elements, work.holds, energies)
    if model.impulse < model.size:
        add_impulses(t, y, modes, model, work, dy[model.impulse :])


@kernel
def is_articulated(model):
    """True for trees of joints whose bodies have no added mass in common: in the time loop their
    accelerations take no matrix of the whole."""
    tree = model.bodies.tree
    families = model.family.body.size > 0
    return (
        tree.branches.size > 0 and model.bodies.exact and model.inertia.uncoupled and not families
    )


@root
def add_impulses(t, y, modes, model, work, rates):
    """Add to ``rates``: the force of every row, reactions included, its power by coordinate, and
    the integrands of contacts."""
    wrench = work.wrench
    v = work.motion.velocity
    count = model.rows * v.size
    for row in range(model.rows):
        for i in range(v.size):
            rates[row * v.size + i] = wrench[row, i]
            rates[count + row * v.size + i] = wrench[row, i] * v[i]
    reactions = work.holds.reaction
    tallies = rates[2 * count :]
    events.add_tally_rates(
        t, y, modes, work.motion, model.bodies, model.elements, reactions, tallies
    )


@root
def accelerate_along(model, work, x):
    """Accelerations ``x`` (n,) without constraints, computed in heading axes, where inertia is
    steady."""
    headings = model.headings
    along = work.hulls.motion
    motion_along(headings, model.bodies, work.motion, along)
    all_to_heading(headings, work.motion, work.total)
    accelerate_freely(model.inertia, model.bodies, along, work.total, work.turning, x)
    translations_to_earth(headings, work.motion, x)


@root
def accelerate(y, modes, model, work, x):
    """Accelerations ``x`` (n,) with constraints, or with varying added mass. The reactions of
    elements go to ``work.holds`` and to their rows of ``work.wrench``."""
    motion = work.motion
    constraints = work.constraints
    A = work.blend.added_mass if model.family.body.size > 0 else model.added_mass
    find_mass(model, A, work)
    subtract_bias(model.bodies, motion, work.mass, work.total)
    generalised_force(model.bodies, motion, work.total, x)
    acceleration_map(model.bodies, motion, work.mass, work.inertia)
    if events.has_load_friction(model.elements):
        accelerate_with_friction(y, modes, model, work, x)
        return
    add_constraints(y, modes, model, work)
    solve_held(work.inertia, constraints, x)
    events.add_reactions(
        y, modes, motion, model.bodies, model.elements, constraints, work.holds, work.wrench
    )


@root
def accelerate_with_friction(y, modes, model, work, x):
    """`accelerate` with friction by load, which is no part of the forces ``x`` (n,). It is found
    from the solution without it, and those of a unit force in each motion that slides."""
    constraints = work.constraints
    motion = work.motion
    bodies = model.bodies
    friction = work.friction
    p = events.motions_of_joints(model.elements)
    assign(friction.total, work.total)  # scratch of constraints
    add_constraints(y, modes, model, work)
    load_friction.find_directions(modes, p, friction)
    solve_held(work.inertia, constraints, x)
    assign(friction.rates[0], x)
    assign(friction.forces[0], constraints.force)
    _find_bearing_loads(0, y, modes, model, work)
    clear(constraints.bound)
    for k in range(1, 1 + p.loaded.size):
        if friction.direction[k - 1] != 0.0:
            rates = friction.rates[k]
            clear(rates)
            rates[p.each[p.loaded[k - 1]].coordinate] = 1.0
            reduce_load(constraints, rates)
            cholesky_solve(work.inertia, rates)
            find_forces(constraints, rates)
            restore_pivots(constraints, rates)
            assign(friction.forces[k], constraints.force)
            _find_bearing_loads(k, y, modes, model, work)
    load_friction.find_friction(p, friction)
    load_friction.add_solutions(modes, p, friction, x, constraints.force)
    wrench = work.wrench
    holds = work.holds
    events.add_reactions(y, modes, motion, bodies, model.elements, constraints, holds, wrench)
    load_friction.add_friction(modes, motion, bodies, p, friction, holds, wrench)


@root
def _find_bearing_loads(k, y, modes, model, work):
    """Loads of bearings in solution ``k``, from (M + A) v' less its forces and the reactions that
    ``work.constraints`` hold. ``work.mass`` is (M + A) S."""
    friction = work.friction
    wrench = friction.wrench
    missing = friction.missing
    bodies = model.bodies
    motion = work.motion
    p = events.motions_of_joints(model.elements)
    clear(wrench.reshape(wrench.size))
    events.add_reactions(
        y, modes, motion, bodies, model.elements, work.constraints, work.holds, wrench
    )
    if k > 0:
        unit = p.each[p.loaded[k - 1]]
        push_joint(unit.move, unit.axis, 1.0, bodies, motion, wrench[0])
    total_force(wrench, missing)
    for i in range(missing.size):
        missing[i] = -missing[i]
        if k == 0:
            missing[i] -= friction.total[i]
        for j in range(friction.rates.shape[1]):
            missing[i] += work.mass[i, j] * friction.rates[k, j]
    sum_joint_loads(missing, bodies, motion, friction.joint)
    load_friction.find_bearing_loads(k, y, motion, bodies, p, friction)


@kernel
def solve_held(inertia, constraints, x):
    """Solve inertia x = x in place with the ``constraints``."""
    solve_for_pivots(constraints)
    eliminate(constraints, inertia, x)
    cholesky(inertia)
    cholesky_solve(inertia, x)
    find_forces(constraints, x)
    restore_pivots(constraints, x)


@kernel
def update_contents(y, model, work):
    """Fill ``work.contents`` with the contents of tanks, and with their level surfaces at the
    present ``work.motion``."""
    if model.tanks.each.size > 0:
        contents.fill(y, model.tanks, work.contents)
    if model.liquids.each.size > 0:
        liquids = model.liquids
        level_surfaces(y, work.motion, model.bodies, model.tanks, liquids, work.contents)


@kernel
def find_mass(model, A, work):
    """Fill ``work.mass`` with M + A at the present ``work.motion``; ``A`` is in heading axes."""
    mass_matrix(model.bodies, work.contents, model.headings, work.motion, A, work.mass)


@root
def apply_impulse(y, modes, model, work):
    """Change the rates in ``y`` by the impulse ``work.push`` (6 nb,), which is overwritten.
    Positions are those of ``work.motion``. Constraints are respected, and the work of the impulse
    is booked."""
    n = model.bodies.active.size
    push = work.push
    constraints = work.constraints
    update_contents(y, model, work)
    blends = model.family.body.size > 0
    if blends:
        blend_draughts(y[model.draught :], model.family, model.added_mass, work.blend)
    find_mass(model, work.blend.added_mass if blends else model.added_mass, work)
    change = work.jump[0]
    given = work.jump[1]
    if model.impulse < model.size:
        for i in range(push.size):
            y[model.impulse + model.tanks.row * push.size + i] += push[i]
    generalised_force(model.bodies, work.motion, push, change)
    assign(given, change)
    acceleration_map(model.bodies, work.motion, work.mass, work.inertia)
    add_constraints(y, modes, model, work)
    clear(constraints.bound)
    solve_held(work.inertia, constraints, change)
    events.book_drive_impulses(y, model.bodies, model.elements, constraints)
    for i in range(n):
        y[model.energy + model.tanks.row] += given[i] * (y[n + i] + 0.5 * change[i])
        y[n + i] += change[i]


@kernel
def may_hold(modes, model, work):
    """True if constraints may act. If joints that are constraints are all open, and nothing else
    can hold, the scene is solved as if it had none."""
    most = work.constraints.force.size
    return most > 0 and _may_hold(modes, model, work)


@root_giving(bool)
def _may_hold(modes, model, work):
    if events.may_have_constraints(modes, model.elements, work.constraints.force.size):
        return True
    work.constraints.number[0] = 0
    events.clear_joint_reactions(model.elements, work.holds)
    return False


@kernel
def add_constraints(y, modes, model, work):
    """Set up all constraints J q'' = c at the present ``work.motion``."""
    constraints = work.constraints
    constraints.number[0] = 0
    events.add_constraints(
        y, modes, work.motion, model.bodies, model.elements, work.total, constraints, work.holds
    )


@root
def find_inertia(y, model, work):
    """Fill ``work.inertia`` with S^T (M + A) S at the state ``y``."""
    n = model.bodies.active.size
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    update_contents(y, model, work)
    blends = model.family.body.size > 0
    if blends:
        blend_draughts(y[model.draught :], model.family, model.added_mass, work.blend)
    find_mass(model, work.blend.added_mass if blends else model.added_mass, work)
    acceleration_map(model.bodies, work.motion, work.mass, work.inertia)


@root
def project_velocities(y, modes, model, work):
    """Remove from the rates in ``y`` the part that constraints prevent."""
    n = model.bodies.active.size
    constraints = work.constraints
    place_bodies(y[:n], y[n : 2 * n], model.bodies, work.motion)
    add_constraints(y, modes, model, work)
    if constraints.number[0] > 0:
        clear(constraints.bound)
        events.keep_driven_rates(y, model.bodies, model.elements, constraints)
        solve_for_pivots(constraints)
        restore_pivots(constraints, y[n : 2 * n])


@root
def fill_jacobian(t, y, modes, history, model, work, states, shifts, step, scratch, J):
    """Fill columns of the derivative ``J`` (m, m) of y' by y over the entries ``states`` (m,) of y,
    by central differences of size ``step``, with the `Shifts` that say which; ``scratch`` (3, ny).
    """
    shifted = scratch[0]
    ahead = scratch[1]
    behind = scratch[2]
    assign(shifted, y)
    columns, number, part = shifts.columns, shifts.number, shifts.part
    first = 0
    while first < columns.size:
        last = first
        while last < columns.size and number[last] == number[first]:
            k = states[columns[last]]
            shifted[k] = y[k] + step
            last += 1
        rhs(t, shifted, modes, history, model, work, ahead)
        for c in range(first, last):
            k = states[columns[c]]
            shifted[k] = y[k] - step
        rhs(t, shifted, modes, history, model, work, behind)
        for c in range(first, last):
            j = columns[c]
            shifted[states[j]] = y[states[j]]
            for i in range(states.size):
                if part[i] == part[j]:
                    J[i, j] = (ahead[states[i]] - behind[states[i]]) / (2.0 * step)
        first = last


@kernel
def add_forces(t, y, modes, history, model, work, dy):
    """The force of every row into ``work.wrench``; the rates of all states except motion into
    dy."""
    motion = work.motion
    wrench = work.wrench
    rate = work.rate
    v = work.motion.velocity
    u = work.hulls.velocity if model.headings.turned.size > 0 else v
    clear(wrench.reshape(wrench.size))
    clear(rate)
    add_hydrostatics(motion, model.bodies, model.stiffness, wrench)
    if model.hulls.body.size > 0:
        add_displacement(motion, model.bodies, model.hulls, wrench)
    clear(dy[model.slow : model.energy])
    if model.family.body.size > 0:
        add_blended(t, y, u, history, model, work, dy)
    else:
        first = wrench[WAVE_FIRST_ORDER]
        second = wrench[WAVE_SECOND_ORDER]
        add_water(t, y, u, history, model, work, wrench[RADIATION], first, second, dy)
    all_to_earth(model.headings, motion, wrench[RADIATION])
    if model.waves.turned.size > 0 and model.bodies.exact:
        turn_moments(model.waves.turned, motion.coordinates, work.met, wrench[WAVE_FIRST_ORDER])
    add_elements(t, y, modes, motion, model.bodies, model.elements, wrench, rate, dy)
    if model.tanks.each.size > 0:
        heights = work.contents.height
        flows.add_force(t, y, modes, motion, model.bodies, model.tanks, heights, wrench, rate, dy)
    if model.weights.body.size > 0:
        add_weight(motion, model.bodies, model.weights, work.contents, wrench)

    rate[RADIATION] -= power_of(wrench[RADIATION], v)
    rate[WAVE_FIRST_ORDER] = power_of(wrench[WAVE_FIRST_ORDER], v)
    rate[WAVE_SECOND_ORDER] = power_of(wrench[WAVE_SECOND_ORDER], v)
    assign(dy[model.energy :], rate)
    dy[model.energy + model.rows] = abs(rate[WAVE_FIRST_ORDER] + rate[WAVE_SECOND_ORDER])


@kernel
def add_water(t, y, u, history, model, work, radiated, first, second, dy):
    """Forces of radiated waves, in heading axes, for velocities ``u`` there, and forces of incident
    waves; rates of their states."""
    if model.states.real.size > 0:
        states = y[model.radiation :]
        radiation_states(states, u, model.states, dy[model.radiation :], radiated)
    if model.convolution.row.size > 0:
        radiation_memory(t, u, history, model.convolution, radiated)
    radiation_damping(u, model.damping, radiated)
    if any_waves(model.waves):
        wave_loads(t, model.waves, first, second)
    if model.following.body.size > 0:
        add_path_loads(t, y[model.slow :], model.following, work, first, second, dy[model.slow :])


@root
def add_blended(t, y, u, history, model, work, dy):
    """`add_water` for families of databases, whose roots are known. The change of their added mass
    takes no energy, and is not booked."""
    family = model.family
    every = work.blend
    wrench = work.wrench
    velocities_of_members(u, family, every)
    add_water(
        t, y, every.velocity, history, model, work, every.force, every.first, every.second, dy
    )
    add_forces_of_members(every.force, False, family, every.root, wrench[RADIATION])
    add_forces_of_members(every.first, True, family, every.root, wrench[WAVE_FIRST_ORDER])
    add_forces_of_members(every.second, True, family, every.root, wrench[WAVE_SECOND_ORDER])
    added_mass_rate_force(u, family, every)
    work.rate[RADIATION] -= power_of(every.lag, u)
    for i in range(u.size):
        wrench[RADIATION, i] -= every.lag[i]
    draught_rates(y[model.draught :], work.motion.coordinates, family, dy[model.draught :])


@root
def add_path_loads(t, y, p, work, first, second, dy):
    """Loads of both orders on the bodies that the waves follow; rates ``dy`` of their slow
    positions."""
    coordinates = work.motion.coordinates
    find_yaws(t, y, coordinates, p, work.met)
    following_loads(t, coordinates, p, work.sums, first, second)
    slow_rates(y, coordinates, p, dy)
    slow_loads(t, y, p, work.block, first, second)


@kernel
def total_force(wrench, total):
    """Sum over the rows of ``wrench`` (nr, 6 nb) into ``total``."""
    for i in range(total.size):
        entry = 0.0
        for row in range(wrench.shape[0]):
            entry += wrench[row, i]
        total[i] = entry


@kernel
def power_of(force, v):
    """Power F v."""
    total = 0.0
    for i in range(v.size):
        total += force[i] * v[i]
    return total


@kernel
def subtract_gyroscopic(bodies, contents, motion, total):
    """total -= omega x (R I R^T omega), omega x (omega x m c), which vanish for small angles."""
    for b in range(bodies.each.size if bodies.exact else 0):
        k = 6 * b + 3
        R = motion.rotation[b]
        omega = vector(motion.velocity, k)
        body_omega = matvec(R.T, omega)
        gyroscopic = cross(omega, matvec(R, matvec(contents.inertia[b], body_omega)))
        moment = vector(contents.moving_moment[b], 0)
        for i in range(3):
            total[k + i] -= gyroscopic[i]
        if moment[0] != 0.0 or moment[1] != 0.0 or moment[2] != 0.0:
            centrifugal = cross(omega, cross(omega, matvec(R, moment)))
            for i in range(3):
                total[k - 3 + i] -= centrifugal[i]


@kernel
def subtract_bias(bodies, motion, mass, total):
    """total -= (M + A) S' q', which vanishes for small angles."""
    for i in range(total.size if bodies.exact else 0):
        if motion.bias[i] != 0.0:
            for j in range(total.size):
                total[j] -= mass[j, i] * motion.bias[i]


@kernel
def momentum(work, out):
    """(M + A) v (6 nb,) into ``out``; `stored_energies` must have computed the mass."""
    v = work.motion.velocity
    for i in range(v.size):
        out[i] = 0.0
        for j in range(v.size):
            out[i] += work.mass[i, j] * v[j]


@kernel
def stored_energies(t, y, modes, model, work, stored):
    """Energy stored in every row of forces into ``stored`` (nr,). Returns the kinetic energy v (M +
    A) v / 2, minus the kinetic energy of the current in the added mass."""
    n = model.bodies.active.size
    motion = work.motion
    place_bodies(y[:n], y[n : 2 * n], model.bodies, motion)
    update_contents(y, model, work)
    clear(stored)
    add_hydrostatic_energy(work.motion, model.bodies, model.stiffness, stored)
    if model.hulls.body.size > 0:
        add_displacement_energy(motion, model.bodies, model.hulls, stored)
    add_element_energies(t, y, modes, work.motion, model.bodies, model.elements, stored)
    if model.weights.body.size > 0:
        add_weight_energy(motion, model.bodies, model.weights, work.contents, stored)
    blends = model.family.body.size > 0
    if blends:
        blend_draughts(y[model.draught :], model.family, model.added_mass, work.blend)
    A = work.blend.added_mass if blends else model.added_mass
    find_mass(model, A, work)
    still_there = stream_energy(model.headings, A, motion, work.hulls)
    return kinetic_energy(motion.velocity, work.mass) - still_there
