"""`lines` of a case file: a mooring system in a file of MoorDyn or MoorPy, as catenaries."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import field, replace
from math import cos, isfinite, sin
from typing import TYPE_CHECKING, Any, ClassVar, Literal, NamedTuple

import numpy as np
from pydantic import StrictStr

from hydrosim.case.lines.chains import mooring_lines, read_mooring_system, water_of_system
from hydrosim.case.lines.system import MooringLine, System
from hydrosim.files import quantities as of
from hydrosim.files.schema_class import schema_class
from hydrosim.files.text import Source
from hydrosim.scene.catenary import Catenary, Seabed
from hydrosim.scene.force import BreakingElement, BuildContext

if TYPE_CHECKING:
    from hydrosim.scene import ForceElement, OmittedEntry

NEARLY = 1e-6  # m: depths that are the same


class Vessel(NamedTuple):
    """A body at rest: ``place`` (x, y) [m] of its database's origin in the earth frame, ``heading``
    [rad], ``centre`` of gravity [m] in the frame of the database; ``depth`` [m] of the water."""

    place: tuple[float, ...]
    heading: float
    centre: tuple[float, ...]
    depth: float


@schema_class
class Lines(BreakingElement):
    """A mooring system from a file of MoorDyn or MoorPy: a catenary for each of its lines."""

    tension_channel: ClassVar[str] = "line_tension"
    example: ClassVar[dict[str, Any]] = {"type": "lines", "body": "barge", "file": "lines.txt"}

    type: Literal["lines"] = field(default="lines", kw_only=True)
    """A mooring system from a file, a catenary for each of its lines."""
    file: StrictStr
    """Input file of MoorDyn or MoorPy. The origin of its axes is the body's database at rest.
    Example: lines.txt."""
    capacity: of.ReferenceForce | None = None
    """Allowable tension of each line, which statistics compare with."""

    def source(self, where: BuildContext) -> Source:
        """The file."""
        return Source(where.path.parent / self.file, f"{where.path}: {where.key}.file")

    def build_lines(
        self, where: BuildContext, vessel: Vessel
    ) -> tuple[dict[str, ForceElement], Iterable[OmittedEntry]]:
        """The catenaries of the scene by name: that of this element, and that of the line. With
        them what the file says and the scene has not."""
        name = where.key.removeprefix("forces.")
        system = read_mooring_system(self.source(where))
        lines = {
            f"{name}_{key}": line.build_active(replace(where, key=f"forces.{name}_{key}"))
            for key, line in self.read_lines(system, where, vessel).items()
        }
        return lines, (entry._replace(key=f"{where.key}.file") for entry in system.left_out)

    def read_lines(
        self, system: System, where: BuildContext, vessel: Vessel
    ) -> dict[str, Catenary]:
        """The lines of the ``system`` in the file, by their names there. Raises InputError for a
        file that does not fit the case."""
        source = self.source(where)
        _check_water(system, where.water, vessel.depth, source)
        lines = mooring_lines(system, water_of_system(system, where.water), source)
        depth = system.depth if system.depth is not None else vessel.depth
        bed = Seabed(friction=system.friction) if isfinite(depth) else None
        return {name: self._catenary(line, vessel, bed) for name, line in lines.items()}

    def _catenary(self, line: MooringLine, vessel: Vessel, bed: Seabed | None) -> Catenary:
        return Catenary.build_from(
            self,
            type="catenary",
            point=tuple(float(v) for v in np.subtract(line.fairlead, vessel.centre)),
            anchor=earth_place(line.anchor, vessel),
            segments=tuple(line.segments),
            seabed=bed,
        )


def earth_place(place: tuple[float, ...], vessel: Vessel) -> tuple[float, ...]:
    """A place of the file in the earth frame."""
    x, y, z = place
    c = cos(vessel.heading)
    s = sin(vessel.heading)
    return vessel.place[0] + c * x - s * y, vessel.place[1] + s * x + c * y, z


def _check_water(system: System, water: tuple[float, float], depth: float, source: Source) -> None:
    """Refuse a file for other water than that of the case."""
    if system.depth is not None and not abs(system.depth - depth) <= NEARLY:
        found_text = "without end" if not isfinite(depth) else f"{depth:g} m"
        text = f"found depth {system.depth:g} m there and water {found_text} in the case"
        source.wrong(f"{text}; expected the same; set environment.water_depth")
    pairs: Mapping[str, tuple[float | None, float, str]] = {
        "density": (system.density, water[0], "kg/m^3"),
        "gravity": (system.gravity, water[1], "m/s^2"),
    }
    for name, (there, here, unit) in pairs.items():
        if there is not None and abs(there - here) > 0.01 * here:
            text = f"found {name} {there:g} {unit} there and {here:g} {unit} in the case"
            source.wrong(f"{text}; expected the same within 1 %")
