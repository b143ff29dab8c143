"""How bodies float at the start, and where waves, wind and current come from, for `check`.

What these figures show, no question can know: a height above the keel in place of z, an angle in
the wrong unit, or a heading that waves come from in place of the one that they go to.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import atan2, cos, hypot, isfinite, pi, sin
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compiling.questions.extents import extents
from hydrosim.compiling.questions.query import describe_start
from hydrosim.database.database import require_array
from hydrosim.forces.line.catenary import Catenary
from hydrosim.forces.pair import TwoPointElement
from hydrosim.presentation.document import Cell, List, Node, Table, Value
from hydrosim.stepping.start_loads import start_loads
from hydrosim.waves.sea_state import sea_state

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.compiling.questions.query import SceneContext
    from hydrosim.database.database import HydroDatabase
    from hydrosim.scene import Body, Scene

SIDES = (
    "from astern",
    "from the starboard quarter",
    "from starboard abeam",
    "from the starboard bow",
    "from ahead",
    "from the port bow",
    "from port abeam",
    "from the port quarter",
)
"""Where a stream comes from that goes to 0, 45, 90, ... degrees of a body's heading."""
ALONG_AXIS = sin(pi / 8.0)  # component below which a direction is along the other axis
MAX_NAMED_BODIES = 4
FLOATING_HEAD = (
    "body",
    "heading",
    "heel",
    "trim",
    "draught, about",
    "G above water",
    "GM in roll",
    "GM in pitch",
)


def describe_floating(own: Compiled) -> Iterator[Node]:
    """Directions of the environment beside bodies, and how hulls with a database float."""
    scene = own.scene
    about = describe_start(scene, own.facts, own.state, own.sea, own.begin + scene.duration)
    afloat = list(about.afloat())
    rotation = {body.name: about.motion.rotation[i] for i, body, _ in afloat}
    headings = {name: atan2(R[1, 0], R[0, 0]) for name, R in rotation.items()}
    directions = list(_describe_directions(scene, headings))
    if directions:
        yield List(directions, "Directions at the start")
    rows = [
        _floating_row(about, body, db, headings[body.name], rotation[body.name])
        for _, body, db in afloat
    ]
    if rows:
        yield Table(FLOATING_HEAD, rows, "Bodies afloat at the start")


def _floating_row(
    about: SceneContext, body: Body, db: HydroDatabase, heading: float, R: np.ndarray
) -> list[Cell]:
    gravity = about.scene.environment.gravity
    size = extents(body, db)
    stiffness = require_array(db, "hydrostatic_stiffness")
    transverse, longitudinal = (float(stiffness[k, k]) / (body.mass * gravity) for k in (3, 4))
    height = float(about.centre(about.index[body.name])[2])
    return [
        body.name,
        Value(heading, "rad", 3),
        Value(atan2(R[2, 1], R[2, 2]), "rad", 3),
        Value(atan2(-R[2, 0], hypot(R[0, 0], R[1, 0])), "rad", 3),
        Value(size.draught, "m", 3) if size is not None else "",
        Value(height, "m", 3),
        Value(transverse, "m", 3),
        Value(longitudinal, "m", 3),
    ]


def _describe_directions(scene: Scene, headings: dict[str, float]) -> Iterator[str]:
    environment = scene.environment
    trains = environment.waves
    for k, train in enumerate(trains, 1):
        heading = sea_state(train, environment).heading
        name = f"waves {k}" if len(trains) > 1 else "waves"
        if isfinite(heading):
            yield f"{name} {describe_direction(heading, headings)}"
    for name, stream in (("current", environment.current), ("wind", environment.wind)):
        if stream.speed > 0.0:
            yield f"{name} {describe_direction(stream.heading, headings)}"


def describe_direction(heading: float, headings: dict[str, float]) -> str:
    """Where a stream with this ``heading`` [rad] goes, and from where it meets bodies with these
    ``headings``, in words."""
    text = f"towards {_axis_text(heading)} of the earth frame"
    met: dict[str, list[str]] = {}
    for body, own in headings.items():
        octant = round((heading - own) / (pi / 4.0)) % 8
        met.setdefault(SIDES[octant], []).append(body)
    for side, bodies in met.items():
        more = len(bodies) - MAX_NAMED_BODIES
        names = ", ".join(bodies[:MAX_NAMED_BODIES]) + (f" and {more} more" if more > 0 else "")
        text += f"; {side} of {names}"
    return text


def _axis_text(heading: float) -> str:
    parts = [
        f"{'+' if component > 0.0 else '-'}{axis}"
        for axis, component in (("x", cos(heading)), ("y", sin(heading)))
        if abs(component) > ALONG_AXIS
    ]
    return " and ".join(parts)


def describe_lines(own: Compiled) -> Iterator[Table]:
    """Tensions of lines and forces of struts at the start, beside what they may carry, and the
    heights of the ends of mooring lines."""
    lines = {name: of for name, of in own.scene.forces.items() if isinstance(of, TwoPointElement)}
    if not lines:
        return
    loads = start_loads(own.scene, own.model, own.state, own.facts.rows, own.begin)
    about = describe_start(own.scene, own.facts, own.state, own.sea, own.begin)
    heights = {name: _line_heights(about, of) for name, of in lines.items()}
    moored = any(any(cells) for cells in heights.values())
    rows: list[list[Cell]] = []
    for name, line in lines.items():
        allowed: list[Cell] = ["", ""]
        if line.capacity is not None:
            allowed = [Value(line.capacity, "N"), Value(loads[name] / line.capacity, "share", 2)]
        rows.append([name, Value(loads[name], "N"), *allowed, *(heights[name] if moored else ())])
    head = ["line", "load at the start", "capacity", "used"]
    if moored:
        head += ["fairlead above water", "anchor above bed"]
    yield Table(head, rows, "Loads of lines")


def _line_heights(about: SceneContext, line: TwoPointElement) -> list[Cell]:
    """Heights of the fairlead of a mooring line above the water, and of its anchor above the bed;
    empty for other lines."""
    if not isinstance(line, Catenary) or line.anchor_body is not None:
        return ["", ""]
    b = about.index[line.body]
    place = about.centre(b) + about.motion.rotation[b] @ np.array(line.point, float)
    above = about.scene.environment.water_depth + line.anchor[2]
    return [Value(float(place[2]), "m", 3), Value(above, "m", 3) if isfinite(above) else ""]
