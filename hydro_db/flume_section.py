"""Database of the section in the wave flume: two-dimensional flow, by boundary elements.

The model fills the flume from wall to wall, so that its flow is that of a plane. Capytaine has
bodies in three dimensions alone: its prism has ends, and long panels. Here the potential is
constant on each of the straight elements round the water. These are the section, the free surface,
the bed, and two vertical ends where waves leave (Newman 1977, Marine Hydrodynamics, chapter 6).
With r from an element to the middle of another,

    pi phi = int phi d(ln r)/dn - int ln r dphi/dn,    n out of the water,

    dphi/dn = w^2/g phi on the surface, 0 on the bed, -i k phi at the ends, given on the section.

Time factor exp(+i w t); waves go to +y. All is in SI, per length of the section until it is stored.
The first frequency is nearly zero, because heave has damping there: a plane flow needs it for its
memory.

    python hydro_db/flume_section.py       # flume_section.nc
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from hydrosim.database import HydroDatabase, netcdf

FILE = Path(__file__).with_name("flume_section.nc")
GRAVITY = 9.81
DENSITY = 1000.0
WATER_DEPTH = 1.0
LENGTH = 0.586  # of the model along the crests
BEAM = 0.4
DRAUGHT = 0.2
BILGE_RADIUS = 0.0512
CENTRE_OF_GRAVITY = 0.106 - DRAUGHT  # measured
RADIUS_OF_GYRATION = 0.144
FREQUENCIES = np.concatenate([[1e-3], np.arange(1, 49) * 0.25, np.arange(25, 49) * 0.5])
ELEMENTS_PER_WAVE = 50
SIDE_ELEMENTS, BILGE_ELEMENTS, BOTTOM_ELEMENTS = 21, 12, 36
GROWTH = 1.15  # of elements of the surface with the distance from the section
LONGEST_ELEMENT = 0.06
PLANE_DOFS = np.array([1, 2, 3])
"""Sway, heave and roll: the others are zero in the database."""
SURFACE, SECTION, BED, END_BEHIND, END_AHEAD = range(5)


class Elements(NamedTuple):
    """Straight elements round the water, the water at their left: ends (n, 2) in y and z, and
    which boundary each is part of."""

    start: np.ndarray
    stop: np.ndarray
    part: np.ndarray

    @property
    def middle(self) -> np.ndarray:
        """Middles (n, 2)."""
        return (self.start + self.stop) / 2

    @property
    def length(self) -> np.ndarray:
        """Lengths (n,)."""
        return np.hypot(*(self.stop - self.start).T)

    @property
    def normal(self) -> np.ndarray:
        """Unit normals (n, 2) out of the water."""
        along = (self.stop - self.start) / self.length[:, None]
        return np.column_stack([along[:, 1], -along[:, 0]])


class Flow(NamedTuple):
    """What follows from a frequency: added mass and damping (3, 3) and loads per unit amplitude
    (3,) in sway, heave and roll; waves far behind and far ahead of unit motions and, last, of the
    held section (4,), as elevations at y = 0."""

    wavenumber: float
    added_mass: np.ndarray
    damping: np.ndarray
    excitation: np.ndarray
    froude_krylov: np.ndarray
    behind: np.ndarray
    ahead: np.ndarray


def solve(frequency: float) -> Flow:
    """Radiation and diffraction at a ``frequency`` [rad/s]."""
    k = wavenumber(frequency)
    elements = elements_round_the_water(2.0 * np.pi / k)
    section = elements.part == SECTION
    modes = normal_modes(elements)
    incident = 1j * GRAVITY / frequency * depth_function(k, elements.middle[:, 1])
    incident = incident * np.exp(-1j * k * elements.middle[:, 0])
    flux = incident_flux(k, elements, incident)
    given = np.column_stack([1j * frequency * modes, -flux[section]])
    phi = potentials(elements, frequency, k, given)
    to_load = -1j * frequency * DENSITY * (modes * elements.length[section, None]).T
    radiated = to_load @ phi[section, :3]
    froude_krylov = to_load @ incident[section]
    behind, ahead = (
        far_waves(elements, phi, part, frequency, k) for part in (END_BEHIND, END_AHEAD)
    )
    return Flow(
        k,
        symmetric_part(radiated.real) / frequency**2,
        symmetric_part(-radiated.imag) / frequency,
        froude_krylov + to_load @ phi[section, 3],
        froude_krylov,
        behind,
        ahead,
    )


def infinite_added_mass() -> np.ndarray:
    """Added mass (3, 3) at infinite frequency, where the potential of the surface is zero."""
    elements = elements_round_the_water(1.0)
    section, surface = elements.part == SECTION, elements.part == SURFACE
    modes = normal_modes(elements)
    single, double = influences(elements)
    unknown = np.pi * np.eye(len(single)) - double
    unknown[:, surface] = single[:, surface]
    phi = np.linalg.solve(unknown, -single[:, section] @ modes)[section]
    return symmetric_part(DENSITY * (modes * elements.length[section, None]).T @ phi)


def wavenumber(frequency: float) -> float:
    """Wavenumber [1/m] in the water's depth."""
    deep = frequency**2 / GRAVITY
    return float(brentq(lambda k: k * np.tanh(k * WATER_DEPTH) - deep, 1e-9, deep + 20.0))


def group_share(k: float) -> float:
    """Group speed over phase speed."""
    return float(0.5 + k * WATER_DEPTH / np.sinh(2.0 * k * WATER_DEPTH))


def depth_function(k: float, z: np.ndarray) -> np.ndarray:
    """Potential of a wave at ``z`` over that at the surface."""
    return np.asarray(np.cosh(k * (z + WATER_DEPTH)) / np.cosh(k * WATER_DEPTH))


def elements_round_the_water(wavelength: float) -> Elements:
    """Elements counter-clockwise, as fine as waves of this length [m] need."""
    size = min(wavelength / ELEMENTS_PER_WAVE, LONGEST_ELEMENT)
    reach = BEAM / 2 + 2.0 * min(wavelength, 8.0 * WATER_DEPTH) + 2.0 * WATER_DEPTH
    ahead = surface_places(reach, size)
    down = np.linspace(0.0, -WATER_DEPTH, 2 + int(WATER_DEPTH / size))
    bed = np.linspace(-reach, reach, 2 + int(2.0 * reach / LONGEST_ELEMENT))
    lines = [
        (SURFACE, np.column_stack([ahead[::-1], 0.0 * ahead])),
        (SECTION, outline()),
        (SURFACE, np.column_stack([-ahead, 0.0 * ahead])),
        (END_BEHIND, np.column_stack([0.0 * down - reach, down])),
        (BED, np.column_stack([bed, 0.0 * bed - WATER_DEPTH])),
        (END_AHEAD, np.column_stack([0.0 * down + reach, down[::-1]])),
    ]
    part = np.concatenate([np.full(len(points) - 1, name) for name, points in lines])
    start = np.concatenate([points[:-1] for _, points in lines])
    stop = np.concatenate([points[1:] for _, points in lines])
    return Elements(start, stop, part)


def outline() -> np.ndarray:
    """Points (n, 2) of the section from the waterline at +y round the keel to that at -y."""
    flat, wall = BEAM / 2 - BILGE_RADIUS, DRAUGHT - BILGE_RADIUS
    side = -wall * np.linspace(0.0, 1.0, SIDE_ELEMENTS + 1)
    angle = np.linspace(0.0, np.pi / 2, BILGE_ELEMENTS + 1)[1:]
    bottom = np.linspace(flat, -flat, BOTTOM_ELEMENTS + 1)[1:-1]
    bilge_y, bilge_z = flat + BILGE_RADIUS * np.cos(angle), -wall - BILGE_RADIUS * np.sin(angle)
    half = np.column_stack([[*(0.0 * side + BEAM / 2), *bilge_y], [*side, *bilge_z]])
    keel = np.column_stack([bottom, 0.0 * bottom - DRAUGHT])
    return np.concatenate([half, keel, half[::-1] * [-1.0, 1.0]])


def surface_places(reach: float, size: float) -> np.ndarray:
    """Ends of the surface's elements from the section to ``reach``, which grow up to ``size``."""
    shortest = (DRAUGHT - BILGE_RADIUS) / SIDE_ELEMENTS
    count = 1 + int(max(0.0, np.log(size / shortest) / np.log(GROWTH)))
    lengths = np.minimum(shortest * GROWTH ** np.arange(count), size)
    span = reach - BEAM / 2
    lengths = np.concatenate([lengths, np.full(max(1, int((span - lengths.sum()) / size)), size)])
    places = np.concatenate([[0.0], np.cumsum(lengths)])
    return np.asarray(BEAM / 2 + span * places / places[-1])


def normal_modes(elements: Elements) -> np.ndarray:
    """Normal velocities (n, 3) of the section's elements in sway, heave and roll of unit speed."""
    section = elements.part == SECTION
    y, z = elements.middle[section].T
    normal_y, normal_z = elements.normal[section].T
    roll = y * normal_z - (z - CENTRE_OF_GRAVITY) * normal_y
    return np.column_stack([normal_y, normal_z, roll])


def incident_flux(k: float, elements: Elements, incident: np.ndarray) -> np.ndarray:
    """Normal derivative (n,) of the ``incident`` potential."""
    normal_y, normal_z = elements.normal.T
    upward = k * np.tanh(k * (elements.middle[:, 1] + WATER_DEPTH))
    return np.asarray(incident * (-1j * k * normal_y + upward * normal_z))


def potentials(elements: Elements, frequency: float, k: float, given: np.ndarray) -> np.ndarray:
    """Potentials (n, m) of flows whose normal derivative is ``given`` (section's elements, m)."""
    single, double = influences(elements)
    slope = np.zeros(len(single), complex)
    slope[elements.part == SURFACE] = frequency**2 / GRAVITY
    slope[(elements.part == END_BEHIND) | (elements.part == END_AHEAD)] = -1j * k
    matrix = np.pi * np.eye(len(single)) - double + single * slope
    return np.linalg.solve(matrix, -single[:, elements.part == SECTION] @ given)


def influences(elements: Elements) -> tuple[np.ndarray, np.ndarray]:
    """Integrals of ln r and of its normal derivative over each element (columns), seen from the
    middle of each (rows)."""
    apart = elements.middle[:, None] - elements.start
    along = (elements.stop - elements.start) / elements.length[:, None]
    x = np.einsum("ijk,jk->ij", apart, along)
    y = np.einsum("ijk,jk->ij", apart, elements.normal)
    rest = x - elements.length
    angle = np.arctan2(elements.length * y, y**2 + x * rest)
    np.fill_diagonal(angle, 0.0)
    single = x * np.log(np.hypot(x, y)) - rest * np.log(np.hypot(rest, y)) - elements.length
    return single + y * angle, -angle


def far_waves(
    elements: Elements, phi: np.ndarray, part: int, frequency: float, k: float
) -> np.ndarray:
    """Elevations (m,) of the waves that leave by an end, as if at y = 0."""
    end = elements.part == part
    shape = depth_function(k, elements.middle[end, 1]) * elements.length[end]
    norm = shape @ depth_function(k, elements.middle[end, 1])
    distance = abs(elements.middle[end, 0][0])
    return -1j * frequency / GRAVITY * (shape @ phi[end]) / norm * np.exp(1j * k * distance)


def mean_drift(flow: Flow, motion: np.ndarray) -> float:
    """Mean force along the waves per amplitude squared [N/m^2] (Longuet-Higgins 1977), of the
    section that moves with ``motion`` (3,). Energy that the elements lose is shared out."""
    moved = np.append(motion, 1.0)
    reflected = abs(flow.behind @ moved) ** 2
    passed = abs(1.0 + flow.ahead @ moved) ** 2
    share = reflected / (reflected + passed)
    return float(DENSITY * GRAVITY * group_share(flow.wavenumber) * share)


def free_motion(flow: Flow, frequency: float) -> np.ndarray:
    """Motions (3,) per amplitude of the section that floats freely, without the rig."""
    area = section_area()
    mass = DENSITY * area * np.diag([1.0, 1.0, RADIUS_OF_GYRATION**2])
    impedance = stiffness() - frequency**2 * (mass + flow.added_mass)
    return np.linalg.solve(impedance + 1j * frequency * flow.damping, flow.excitation)


def stiffness() -> np.ndarray:
    """Hydrostatic stiffness (3, 3) about the centre of gravity."""
    righting = BEAM**3 / 12.0 + section_area() * (centre_of_buoyancy() - CENTRE_OF_GRAVITY)
    return np.asarray(DENSITY * GRAVITY * np.diag([0.0, BEAM, righting]))


def section_area() -> float:
    """Area of the section below the water."""
    return BEAM * DRAUGHT - 2.0 * (1.0 - np.pi / 4) * BILGE_RADIUS**2


def centre_of_buoyancy() -> float:
    """Height of the middle of that area over the still water."""
    corner = (1.0 - np.pi / 4) * BILGE_RADIUS**2
    depth = DRAUGHT - BILGE_RADIUS * (10.0 - 3.0 * np.pi) / (12.0 - 3.0 * np.pi)
    moment = BEAM * DRAUGHT * DRAUGHT / 2 - 2.0 * corner * depth
    return -moment / section_area()


def symmetric_part(matrix: np.ndarray) -> np.ndarray:
    """Mean of a matrix and its transpose."""
    return np.asarray((matrix + matrix.T) / 2)


def database() -> HydroDatabase:
    """Coefficients of the model's length at all frequencies, for waves to +y."""
    flows = [solve(float(frequency)) for frequency in FREQUENCIES]
    motions = [free_motion(flow, w) for flow, w in zip(flows, FREQUENCIES, strict=True)]
    free = [mean_drift(flow, motion) for flow, motion in zip(flows, motions, strict=True)]
    held = [mean_drift(flow, np.zeros(3)) for flow in flows]
    area = section_area()
    radii = np.array([RADIUS_OF_GYRATION, LENGTH / 12**0.5, LENGTH / 12**0.5])
    inertia = DENSITY * area * LENGTH * np.diag([1.0, 1.0, 1.0, *radii**2])
    centre = np.array([[0.0, 0.0, CENTRE_OF_GRAVITY]])
    restoring = square(stiffness())
    restoring[4, 4] = pitch_stiffness()
    return HydroDatabase(
        source="computed",
        frequency=FREQUENCIES,
        heading=np.array([np.pi / 2]),
        added_mass=np.array([square(flow.added_mass) for flow in flows]),
        radiation_damping=np.array([square(flow.damping) for flow in flows]),
        added_mass_infinite=square(infinite_added_mass()),
        excitation=np.array([loads(flow.excitation) for flow in flows]),
        froude_krylov=np.array([loads(flow.froude_krylov) for flow in flows]),
        mean_drift=np.array([loads(np.array([drift, 0.0, 0.0])) for drift in free]),
        mean_drift_held=np.array([loads(np.array([drift, 0.0, 0.0])) for drift in held]),
        hydrostatic_stiffness=restoring,
        inertia_matrix=inertia,
        volume=np.array([area * LENGTH]),
        centre_of_buoyancy=np.array([[0.0, 0.0, centre_of_buoyancy()]]),
        centre_of_gravity=centre,
        reference_point=centre,
        water_depth=WATER_DEPTH,
        water_density=DENSITY,
        gravity=GRAVITY,
        port_starboard_symmetric=True,
        attributes=ATTRIBUTES,
    )


def square(plane: np.ndarray) -> np.ndarray:
    """Matrix (6, 6) of the model's length from one (3, 3) per length."""
    whole = np.zeros((6, 6))
    whole[np.ix_(PLANE_DOFS, PLANE_DOFS)] = LENGTH * plane
    return whole


def loads(plane: np.ndarray) -> np.ndarray:
    """Loads (1 heading, 6) of the model's length from those (3,) per length."""
    whole = np.zeros((1, 6), plane.dtype)
    whole[0, PLANE_DOFS] = LENGTH * plane
    return whole


def pitch_stiffness() -> float:
    """Hydrostatic stiffness in pitch [N m]. Nothing uses it; without it the model would capsize."""
    lever = section_area() * LENGTH * (centre_of_buoyancy() - CENTRE_OF_GRAVITY)
    return DENSITY * GRAVITY * (BEAM * LENGTH**3 / 12.0 + lever)


ATTRIBUTES = {
    "title": "Section in a wave flume: 0.4 m x 0.2 m, 0.586 m long, in 1 m of water",
    "solver": "two-dimensional boundary elements, hydro_db/flume_section.py",
    "mean_drift_of": "without viscous damping; from the waves reflected and passed",
    "degrees_of_freedom": "sway, heave and roll; surge, pitch and yaw are zero",
    "licence": "Apache-2.0",
}

if __name__ == "__main__":
    netcdf.write(database(), FILE)
