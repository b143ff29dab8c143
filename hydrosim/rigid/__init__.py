"""Rigid bodies without fluids: vectors, rotations, kinematics, mass. Kernels only."""

from hydrosim.rigid.added_mass import add_turning, stream_energy
from hydrosim.rigid.contents import Contents, new_contents
from hydrosim.rigid.heading import (
    Headings,
    HeadingScratch,
    accelerations_along,
    all_to_earth,
    all_to_heading,
    find_flow,
    heading,
    motion_along,
    new_heading_scratch,
    new_headings,
    translations_to_earth,
)
from hydrosim.rigid.inertia import (
    Inertia,
    Turning,
    accelerate_freely,
    constant_inertia,
    new_turning,
)
from hydrosim.rigid.kinematics import (
    BODY,
    Bodies,
    Motion,
    acceleration_map,
    accelerations,
    add_wrench,
    attachment,
    generalised_force,
    new_motion,
    place_bodies,
    place_bodies_inline,
    point_velocity,
    wrench_of_coordinates,
)
from hydrosim.rigid.mass import cholesky, cholesky_solve, kinetic_energy, mass_matrix
from hydrosim.rigid.stiffness import spring_energy, spring_force
