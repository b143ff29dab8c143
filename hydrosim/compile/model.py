"""The model of a scene in calm water: constants of its equation of motion."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from hydrosim import elements as forces
from hydrosim.compile import families
from hydrosim.compile.hydrodynamic_groups import (
    HydrodynamicGroup,
    each_alone,
    moving,
    uncoupled_resonance,
)
from hydrosim.compile.hydrostatics import hulls_of, liquids_of
from hydrosim.compile.joints import bodies_of
from hydrosim.compile.restart import initial_headings
from hydrosim.compile.roll_mode import roll_mode
from hydrosim.compile.tanks import tanks_of, weights_of
from hydrosim.database.database import HydroDatabase, require_array
from hydrosim.dofs import about_z
from hydrosim.elements import events, kind
from hydrosim.errors import InputError
from hydrosim.integrate import draught_interpolation
from hydrosim.integrate.dynamics import Model
from hydrosim.multibody.heading import Headings, new_headings
from hydrosim.multibody.kinematics import Bodies
from hydrosim.multibody.mass import constant_inertia
from hydrosim.results.memory import named_points, point_names
from hydrosim.scene import Scene
from hydrosim.tanks.contents import Tanks, tank_names, triggered_pumps
from hydrosim.water import radiation
from hydrosim.water.build import wave_loads_model
from hydrosim.water.current import current_table, currents_on, draught_of
from hydrosim.water.displaced_loads import (
    STATES_PER_FOLLOWED_BODY,
    following_model,
    met_by_waves,
    slow_bodies,
)
from hydrosim.water.radiation.state_space import StateSpace
from hydrosim.water.wind import mean_wind

SAME_STEP = 1e-9  # relative difference of table steps that is rounding


def model_of(
    scene: Scene, wet: Sequence[HydrodynamicGroup], kind_constants: kind.KindConstants | None = None
) -> Model:
    """Model of a scene in calm water; its elements and tanks are compiled unless they are
    ``kind_constants``.

    Raises InputError if radiation or an element does not fit the scene.
    """
    bodies = bodies_of(scene)
    alone = each_alone(wet)
    free = moving(scene.bodies)
    family = families.family_constants(scene, wet)
    size = 6 * (len(scene.bodies) + family.owner.size)
    members = list(families.groups_with_dofs(wet, len(scene.bodies)))
    groups = [fit for dofs, group in members for fit in _compile_groups(group, dofs, free)]
    states = radiation.state_space_model(groups)
    radiating = 2 * bodies.active.size
    own_states = radiating + states.decay.size
    if kind_constants is None:
        tanks = tanks_of(scene)
        elements = forces.compile_elements(
            scene.forces, _compile_layout(scene, bodies, alone, tanks)
        )
        kind_constants = forces.IndexedConstants(elements, tanks)
    elif bodies.tree.moves.size or forces.driven_coordinates(kind_constants.elements).size:
        # numbers of coordinates may differ
        layout = _compile_layout(scene, bodies, alone, kind_constants.tanks)
        kind_constants = forces.renumber_coordinates(kind_constants, scene.forces, layout)
    slow = own_states + forces.state_count(kind_constants, scene)
    draught = slow + STATES_PER_FOLLOWED_BODY * len(slow_bodies(scene, met_by_waves(scene, alone)))
    energy = draught + draught_interpolation.DRAUGHT_STATES * family.body.size
    parts = forces.assign_indices(kind_constants, scene, own_states, energy)
    rows = kind.row_names(scene)
    impulse = energy + len(rows) + 1
    blocks = [(group.dofs, group.added_mass) for group in wet]
    added_mass = _assemble_blocks(6 * len(scene.bodies), blocks)
    return Model(
        bodies=bodies,
        headings=_compile_headings(scene, bodies, alone),
        added_mass=added_mass,
        inertia=constant_inertia(bodies, added_mass),
        stiffness=_compile_stiffness(scene, alone),
        hulls=hulls_of(scene, bodies),
        states=states,
        convolution=_compile_convolution(6 * len(scene.bodies), wet, free),
        damping=radiation.constant_damping(
            _assemble_blocks(size, [(dofs, group.damping) for dofs, group in members])
        ),
        waves=wave_loads_model((), (), 0.0, scene.solver.step, scene.duration),
        following=following_model((), ()),
        family=family,
        elements=events.with_rows_and_outputs(parts.elements, forces.kinds_of(parts)),
        tanks=parts.tanks,
        liquids=liquids_of(scene, bodies),
        weights=weights_of(scene, alone, rows),
        rows=len(rows),
        radiation=radiating,
        own=own_states,
        slow=slow,
        draught=draught,
        energy=energy,
        impulse=impulse,
        size=impulse + (_impulse_count(len(rows), bodies, parts) if scene.output.impulses else 0),
    )


def _impulse_count(rows: int, bodies: Bodies, parts: kind.KindConstants) -> int:
    """Number of integrals of impulses: of forces, of their works, and of units."""
    return 2 * rows * 6 * bodies.each.size + forces.tally_count(parts)


def _compile_headings(scene: Scene, bodies: Bodies, wet: Collection[str]) -> Headings:
    """Heading axes of the bodies, and the current in these axes, at the start of the first run."""
    current = currents_on(scene, wet)
    stream = np.zeros((len(scene.bodies), 6))
    for b, psi in enumerate(initial_headings(scene)):
        stream[b, :3] = about_z(psi).T @ (*current[b], 0.0)
    has_water = np.array([body.name in wet for body in scene.bodies])
    return new_headings(bodies, has_water, current, stream.ravel())


def _compile_groups(wet: HydrodynamicGroup, dofs: np.ndarray, free: np.ndarray) -> list[StateSpace]:
    """State-space models of a database on its own ``dofs``, without DOFs that are zero by
    symmetry."""
    moving = [fit for fit in wet.fits if np.isin(wet.dofs[fit.dofs], free).any()]
    return [replace(fit, dofs=dofs[fit.dofs]) for fit in moving]


def _assemble_blocks(size: int, blocks: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Array (..., size, size) of blocks (..., m, m), each on its own DOFs (m,)."""
    leading = next((block.shape[:-2] for _, block in blocks), ())
    whole = np.zeros((*leading, size, size))
    for dofs, block in blocks:
        whole[..., dofs[:, None], dofs] = block
    return whole


def _compile_stiffness(scene: Scene, alone: Mapping[str, HydroDatabase]) -> np.ndarray:
    none = np.zeros((6, 6))
    rows = [
        require_array(alone[b.name], "hydrostatic_stiffness")
        if b.name in alone and b.hydrostatics is None
        else none
        for b in scene.bodies
    ]
    return np.array(rows)


def _compile_convolution(
    size: int, groups: Sequence[HydrodynamicGroup], free: np.ndarray
) -> radiation.ConvolutionKernel:
    chosen = [wet for wet in groups if wet.convolved]
    if not chosen:
        return radiation.convolution_model(1.0, np.zeros((2, 0, 0)))
    times = [wet.memory.time for wet in chosen]
    steps = [time[1] for time in times]
    if max(steps) - min(steps) > SAME_STEP * min(steps):
        names = ", ".join(name for wet in chosen for name in wet.names)
        raise InputError(
            f"bodies.{names}.radiation: found convolutions with tables of different steps;"
            " expected one step for all. Some of them may be chosen by automatic because no fit"
            " meets the tolerance."
        )
    rows = max(time.size for time in times)
    kernels = _assemble_blocks(
        size, [(wet.dofs, _pad_kernel(_compile_kernel(wet, free), rows)) for wet in chosen]
    )
    return radiation.convolution_model(steps[0], kernels)


def _pad_kernel(kernel: np.ndarray, rows: int) -> np.ndarray:
    """Kernel padded with zeros, because a memory may be shorter than another."""
    return np.pad(kernel, ((0, rows - len(kernel)), (0, 0), (0, 0)))


def _compile_kernel(wet: HydrodynamicGroup, free: np.ndarray) -> np.ndarray:
    """Retardation functions of the convolved groups of DOFs of a database, without groups whose
    DOFs are all locked."""
    kernel = np.zeros_like(wet.memory.kernel)
    for dofs, _ in wet.convolved:
        if np.isin(wet.dofs[dofs], free).any():
            kernel[:, dofs[:, None], dofs] = wet.memory.kernel[:, dofs[:, None], dofs]
    return kernel


def _compile_layout(
    scene: Scene, bodies: Bodies, alone: Mapping[str, HydroDatabase], tanks: Tanks
) -> kind.Layout:
    def of_body(body: int, stiffness: np.ndarray) -> kind.UncoupledResonance:
        return uncoupled_resonance(
            scene.bodies[body], stiffness, alone.get(scene.bodies[body].name)
        )

    def roll_of_body(body: int, stiffness: np.ndarray) -> kind.RollMode:
        return roll_mode(scene.bodies[body], stiffness, alone.get(scene.bodies[body].name))

    rows = {*scene.forces, *kind.acting_joints(scene)}
    return kind.Layout(
        {body.name: i for i, body in enumerate(scene.bodies)},
        {name: i for i, name in enumerate(kind.row_names(scene)) if name in rows},
        current_table(scene.environment),
        mean_wind(scene.environment),
        of_body,
        roll_of_body,
        tuple(body.heading for body in scene.bodies),
        tuple(body.mass * scene.environment.gravity for body in scene.bodies),
        0.0 if scene.solver.method.adapts else scene.solver.step,
        scene.solver.events,
        tanks.row,
        tuple(tank_names(scene)),
        tuple(triggered_pumps(scene)),
        kind.carried_weights(scene),
        scene.joints,
        _joined_bodies(scene, bodies),
        len(kind.row_names(scene)) - 1,
        bodies.tree,
        tuple(bodies.each["origin"]),
        dict(zip(point_names(scene), named_points(scene), strict=True)),
        scene.output.clearances,
        scene.environment.water_depth,
        scene.environment.water_density,
        tuple(draught_of(body) for body in scene.bodies),
        bodies.active,
    )


def _joined_bodies(scene: Scene, bodies: Bodies) -> dict[str, kind.JoinedBodies]:
    """The bodies of all joints that are constraints."""
    bodies_by_name = {
        body.name: kind.BodyAtRest(i, tuple(bodies.each[i]["origin"]), body.heading)
        for i, body in enumerate(scene.bodies)
    }
    return {
        name: kind.JoinedBodies(
            bodies_by_name[joint.body], bodies_by_name[joint.to] if joint.to else None, bodies.exact
        )
        for name, joint in ((name, scene.joints[name]) for name in kind.constraint_names(scene))
    }
