"""Case files: `load_case` to a validated case, and estimates from main particulars for a new one.

Estimates for a barge from its main particulars, to begin a case with.

The hull counts as a box of the same beam, draught and displacement: its length is the block
coefficient times the length of the hull. Axes: x forward, y to port, z up.

    displacement  V = Cb L B T                    KB = T / 2
    BM = B^2 / (12 T),  BML = (Cb L)^2 / (12 T)   GM = KB + BM - KG
    heave k = rho g V / T,  roll k = rho g V GM,  pitch k = rho g V GML

Added mass, for the first estimate of periods alone. Beside the water line the hull and its image
are one body (J.N. Newman, Marine Hydrodynamics, 1977, section 4.13 and table 4.3):

    heave  half of a plate of the beam,  rho pi B^2 / 8 a metre
    roll   half of a turning plate,      rho pi B^4 / 256 a metre
    sway   half of a rectangle 2 T high and B wide, C rho pi T^2 / 2 a metre, C of DNV-RP-C205,
           table D-1
    pitch, yaw  those of heave and sway, by strips

Surge and all ratios of damping are about those of the two barges in ``hydro_db``, at their own
frequencies. Against these databases, added mass is 0.56 to 1.41 times that of panels, and natural
periods are off by a fifth at most.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import hypot, log, pi, sqrt
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from yaml.nodes import Node

from hydrosim.case.checks import check, recorded_series
from hydrosim.case.schema import CaseFile
from hydrosim.dofs import DOFS
from hydrosim.errors import InputError
from hydrosim.files.display_units import Units, chosen_units
from hydrosim.files.document import Document
from hydrosim.files.layers import apply_setting, read_case, settings_of, yaml_text
from hydrosim.files.messages import validate_document
from hydrosim.files.outputs import files_named, settings_text
from hydrosim.files.units import units_written
from hydrosim.files.yaml_nodes import SETTING, Places, places_of, source_context
from hydrosim.scene import Scene

SURGE = 0.08
"""Added mass in surge over the mass: 0.06 of H-851, 0.10 of the box of 100 x 20 x 5 m."""
DAMPING_RATIOS = {"heave": 0.14, "roll": 0.03, "pitch": 0.15}
"""Damping over the critical one. Radiation alone gives roll 0.01 to 0.03."""
RADII = 0.35, 0.25, 0.26
"""Radii of gyration: in roll over the beam, in pitch and yaw over the length; usual of barges."""
SIDES = 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0
"""Side across the flow over the side along it."""
RECTANGLE_ADDED_MASS = 2.23, 1.98, 1.70, 1.51, 1.36, 1.21, 1.14
"""Added mass of rectangles with these ``SIDES``, over that of a plate."""


@dataclass(frozen=True)
class Particulars:
    """Main particulars [m]; ``block`` is the block coefficient, ``kg`` the height of the centre of
    gravity above the keel. Density [kg/m^3] and gravity [m/s^2] are those of sea water."""

    length: float
    beam: float
    draught: float
    block: float
    kg: float
    density: float = 1025.0
    gravity: float = 9.81

    @property
    def mass(self) -> float:
        """Displaced mass [kg]."""
        return self.density * self.box_length * self.beam * self.draught

    @property
    def box_length(self) -> float:
        """Length of the box with this displacement [m]."""
        return self.block * self.length

    @property
    def radii(self) -> tuple[float, float, float]:
        """Radii of gyration in roll, pitch and yaw [m]. No moment of inertia is above the sum of
        the others, so a slender hull has that of pitch in yaw."""
        roll = RADII[0] * self.beam
        pitch = RADII[1] * self.length
        yaw = RADII[2] * self.length
        return roll, pitch, yaw if yaw < hypot(roll, pitch) else pitch

    @property
    def metacentric_height(self) -> float:
        """Transverse GM [m]."""
        return self._metacentric_height(self.beam)

    @property
    def longitudinal_metacentric_height(self) -> float:
        """Longitudinal GM [m]."""
        return self._metacentric_height(self.box_length)

    def _metacentric_height(self, side: float) -> float:
        return self.draught / 2 + side**2 / (12 * self.draught) - self.kg

    def stiffness(self) -> dict[str, float]:
        """Hydrostatic stiffness about the centre of gravity [N/m, N m/rad]."""
        weight = self.mass * self.gravity
        return {
            "heave": weight / self.draught,
            "roll": weight * self.metacentric_height,
            "pitch": weight * self.longitudinal_metacentric_height,
        }

    def inertia(self) -> dict[str, float]:
        """Mass and moments of inertia [kg, kg m^2] by direction."""
        turning = [self.mass * radius**2 for radius in self.radii]
        return dict(zip(DOFS, [self.mass] * 3 + turning, strict=True))

    def added_mass(self) -> dict[str, float]:
        """Estimates of added mass [kg, kg m^2] by direction."""
        heave = self.density * pi * self.beam**2 / 8
        roll = self.density * pi * self.beam**4 / 256
        sway = self._rectangle() * self.density * pi * self.draught**2 / 2
        strips = self.box_length**3 / 12
        return {
            "surge": SURGE * self.mass,
            "sway": sway * self.box_length,
            "heave": heave * self.box_length,
            "roll": roll * self.box_length,
            "pitch": heave * strips,
            "yaw": sway * strips,
        }

    def _rectangle(self) -> float:
        """Coefficient of a rectangle of twice the draught by the beam, in flow across."""
        sides = [log(side) for side in SIDES]
        return float(np.interp(log(2 * self.draught / self.beam), sides, RECTANGLE_ADDED_MASS))

    def damping(self) -> dict[str, float]:
        """Estimates of damping [N s/m, N m s/rad] of what has a stiffness."""
        stiffness, moving = self.stiffness(), self._moving()
        return {
            dof: 2 * ratio * sqrt(stiffness[dof] * moving[dof])
            for dof, ratio in DAMPING_RATIOS.items()
        }

    def periods(self) -> dict[str, float]:
        """Natural periods [s] in heave, roll and pitch, without moorings."""
        moving = self._moving()
        return {dof: 2 * pi * sqrt(moving[dof] / k) for dof, k in self.stiffness().items()}

    def _moving(self) -> dict[str, float]:
        """Inertia with added mass."""
        added = self.added_mass()
        return {dof: inertia + added[dof] for dof, inertia in self.inertia().items()}


@dataclass(frozen=True)
class Case:
    """A validated case: the file's ``path``, its whole ``text`` in YAML (with what it extends and
    the settings laid over it), its ``data`` in SI and radians, the ``units`` that it is read in by
    SI unit. ``places`` are file and line of its keys."""

    path: Path
    text: str
    data: CaseFile
    units: Mapping[str, str] = field(default_factory=dict)
    places: Places = field(default_factory=dict, repr=False, compare=False)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> None:
            raise AttributeError(
                f"a case has no {name!r}; its values are in case.data, as case.data.forces, and"
                " hs.load_case(path, {key: value}) changes them"
            )

    def scene(self) -> Scene:
        """The scene to simulate; databases are files in it, not yet read."""
        from hydrosim.case.build import build_scene  # the force elements load numba

        with source_context(self.places):
            scene = build_scene(self.data, self.path, self.text, self.units)
        return replace(scene, places=self.places)

    def __repr__(self) -> str:
        data = self.data
        held = f"bodies: {', '.join(data.bodies)}; forces: {', '.join(data.forces)}"
        return f"<case {self.path}: {data.title}, {data.duration:g} s; {held}>"

    def _repr_html_(self) -> str:
        return self.document()._repr_html_()

    def document(self) -> Document:
        """Its title, and its surroundings, bodies and elements."""
        from hydrosim.case.build import resolved_case_text
        from hydrosim.case.tables import case_tables, plain

        data = self.data
        lasts = f"{data.duration:g} s by {data.solver.method}, from {self.path}"
        tables = case_tables(plain(resolved_case_text(data, self.path.parent)))
        return Document(data.title, list(tables), lasts, Units(self.units))

    def inputs(self) -> tuple[Path, ...]:
        """The case file and all files that it names: databases, series, the run to start from."""
        return (self.path, *files_named(self.data, self.path.parent))

    def settings(self, asked: Mapping[str, Any] = MappingProxyType({})) -> str:
        """What a result is made with: all that the case sets, in SI and radians, but its title, and
        what else is ``asked`` for."""
        data = self.data.model_dump(
            mode="json", exclude_unset=True, warnings=False, exclude={"title"}
        )
        return settings_text(data, asked)

    def stages(self) -> tuple[Stage, ...]:
        """The runs of other cases that this one needs: recorded series with a case of their own."""
        folder = self.path.parent
        series = (form for _, form in recorded_series(self.data) if form.case is not None)
        needed = {folder / form.file: folder / str(form.case) for form in series}
        return tuple(Stage(file, load_case(path)) for file, path in needed.items())


@dataclass(frozen=True)
class Stage:
    """A run that another case needs: its ``file``, and the ``case`` that it is a run of."""

    file: Path
    case: Case


def load_case(path: Path | str, settings: Mapping[str, Any] | Sequence[str] = ()) -> Case:
    """The case in the YAML file ``path``, validated, with ``settings`` laid over it.

    Settings are texts ``KEY=VALUE`` or a mapping; a key is dotted ("solver.step",
    "environment.waves.seed", "forces.interface.points.0"), a value is as in the file, None removes.
    Raises InputError with a line for each problem: file and line, key, what was found, what was
    expected, what to do.

    >>> case = hs.load_case("cases/friction_block/exact.yaml", {"duration": "20 s"})
    >>> case.data.duration
    20.0
    """
    return laid_over(Path(path), read_case(Path(path)), settings)


def as_case(case: Case | str | Path) -> Case:
    """A case, or the case in a file. Raises InputError if it is neither."""
    if isinstance(case, Case):
        return case
    if isinstance(case, str | Path):
        return load_case(case)
    text = f"found {case!r:.60} ({type(case).__name__}); expected a case or the path of its file"
    raise InputError(f"case: {text}.")


def laid_over(
    path: Path, read: tuple[str, Node], settings: Mapping[str, Any] | Sequence[str]
) -> Case:
    """`load_case` of what was ``read`` of the file, text and nodes."""
    text, document = read
    texts = settings_of(settings) if isinstance(settings, Mapping) else settings
    for setting in texts:
        document = apply_setting(document, setting)
    if texts:
        remarks = "".join(f"# {SETTING}{' '.join(setting.split())}\n" for setting in texts)
        text = f"# {path.name}\n{remarks}{yaml_text(document)}"
    with units_written() as written:
        data = validate_document(document, CaseFile, lambda data: check(data, path.parent))
    return Case(path, text, data, chosen_units(written), places_of(document))
