"""The lines of a file as keys of a case, in YAML."""

from __future__ import annotations

from pathlib import Path

import yaml

from hydrosim.case.lines.chains import mooring_lines, read_mooring_system, water_of
from hydrosim.case.lines.system import MooringLine, System
from hydrosim.documents.text import Source

DEFAULT_WATER = (1025.0, 9.81)
SIGNIFICANT_DIGITS = 12
HEAD = """\
# Lines of {file}, for {density:g} kg/m^3 and {gravity:g} m/s^2.
# Points count from the origin of the file. In a case they count from the centre of gravity:
# subtract it. Anchors are in the earth frame, for a body at [0 m, 0 m] with heading 0.
"""


def case_keys(file: Path) -> str:
    """YAML of ``forces``, and of the depth if the file says it. Raises InputError."""
    source = Source(file)
    system = read_mooring_system(source)
    water = water_of(system, DEFAULT_WATER)
    lines = mooring_lines(system, water, source)
    keys: dict[str, object] = {}
    if system.depth is not None:
        keys["environment"] = {"water_depth": _with_unit(system.depth, "m")}
    keys["forces"] = {f"line_{name}": _line(line, system) for name, line in lines.items()}
    text = yaml.dump(keys, sort_keys=False, default_flow_style=None, width=100)
    head = HEAD.format(file=file.name, density=water[0], gravity=water[1])
    left_out = "".join(f"# Left out: {each.message}\n" for each in system.left_out)
    return head + left_out + text


def _line(line: MooringLine, system: System) -> dict[str, object]:
    """The keys of a catenary."""
    keys: dict[str, object] = {
        "type": "catenary",
        "body": "vessel",
        "point": [_with_unit(x, "m") for x in line.fairlead],
        "anchor": [_with_unit(x, "m") for x in line.anchor],
        "segments": [],
    }
    segments = []
    for s in line.segments:
        own: dict[str, object] = {
            "length": _with_unit(s.length, "m"),
            "weight": _with_unit(s.weight, "N/m"),
            "stiffness": _with_unit(s.stiffness, "N"),
        }
        if s.drag > 0.0:
            own["drag"] = {"coefficient": s.drag, "diameter": _with_unit(s.diameter, "m")}
        if s.hung != 0.0:
            own["clump" if s.hung > 0.0 else "buoy"] = _with_unit(abs(s.hung), "N")
        segments.append(own)
    keys["segments"] = segments
    if system.depth is not None:
        keys["seabed"] = {"friction": system.friction}
    return keys


def _with_unit(value: float, unit: str) -> str:
    return f"{value:.{SIGNIFICANT_DIGITS}g} {unit}"
