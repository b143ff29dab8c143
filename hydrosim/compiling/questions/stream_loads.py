"""Questions about loads of wind and current: their size beside the hull, and their sign."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from hydrosim.compiling.questions.extents import Extents, extents
from hydrosim.compiling.questions.query import Query, SceneContext, text_outside
from hydrosim.forces.stream_load import CurrentLoad, StreamLoad, WindLoad

AIR = 1.225  # kg/m^3
# drag coefficients: of the current on length times draught; of the wind on length times breadth,
# because no area above the water is known
CURRENT_DRAG = (0.002, 10.0)
WIND_DRAG = (0.003, 30.0)
SAME_DRAUGHT = 3.0  # ratio
MAX_OPPOSING_FRACTION = 0.1  # part of the forces


def coefficients(about: SceneContext) -> Iterator[Query]:
    """Ask about coefficients of wind and current that are not those of a hull of this size, that
    drive a body against the stream, and about a draught for the current that the hull has not."""
    sizes = {body.name: extents(body, db) for _, body, db in about.floating_bodies()}
    density = about.scene.environment.water_density
    for name, of in about.scene.forces.items():
        if isinstance(of, StreamLoad):
            yield from _reversed_tables(name, of)
        size = sizes.get(of.body)
        if size is not None and isinstance(of, CurrentLoad):
            area = 2.0 * float(size.half.max()) * size.draught
            yield from _unlikely_size(name, of, 0.5 * density * area, CURRENT_DRAG)
        elif size is not None and isinstance(of, WindLoad):
            area = 4.0 * float(np.prod(size.half))
            yield from _unlikely_size(name, of, 0.5 * AIR * area, WIND_DRAG)
    for _, body, _ in about.floating_bodies():
        yield from _other_draught(body.name, body.draught, sizes[body.name])


def _unlikely_size(
    name: str, of: StreamLoad, reference: float, limits: tuple[float, float]
) -> Iterator[Query]:
    """Ask about coefficients whose largest force is far from a ``reference`` force [N s^2/m^2]."""
    low, high = limits
    for key, force in (("surge", of.surge), ("sway", of.sway)):
        largest = float(np.abs(force).max())
        coefficient = largest / reference
        if largest > 0.0 and not low <= coefficient <= high:
            text = text_outside(coefficient, low, high, ".2g")
            found_text = (
                f"up to {largest:.3g} N s^2/m^2, a drag coefficient of {text} for the size of"
                f" {of.body}"
            )
            usual = f"usual is {low:g} to {high:g}"
            yield Query(f"forces.{name}.{key}", found_text, usual, "Is it in kN?")


def _reversed_tables(name: str, of: StreamLoad) -> Iterator[Query]:
    """Ask about a table whose forces are against the stream in the sum over its headings."""
    for key, force, component in (
        ("surge", of.surge, np.cos(of.headings)),
        ("sway", of.sway, np.sin(of.headings)),
    ):
        if float(force @ component) < -MAX_OPPOSING_FRACTION * float(np.abs(force).sum()):
            found_text = "forces against the stream"
            usual = "usual are forces along it: surge above 0 at 0 deg, sway above 0 at 90 deg"
            advice = "headings are those that the stream goes to, relative to the body."
            yield Query(f"forces.{name}.{key}", found_text, usual, advice)


def _other_draught(body: str, draught: float | None, size: Extents | None) -> Iterator[Query]:
    if draught is None or size is None:
        return
    ratio = draught / size.draught
    if not 1.0 / SAME_DRAUGHT <= ratio <= SAME_DRAUGHT:
        found_text = f"{draught:.3g} m"
        usual = f"the hull of its database has about {size.draught:.3g} m"
        yield Query(f"bodies.{body}.draught", found_text, usual)
