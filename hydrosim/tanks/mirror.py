"""Pairs of tanks and of flows of a body that are mirror images in the plane y = const."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from hydrosim import scene
from hydrosim.dofs import SYMMETRY_RTOL
from hydrosim.tanks.shapes import capacity, pieces


def image_indices(body: scene.Body) -> tuple[list[int | None], list[int | None]]:
    """Index of the mirror image of each tank, and of each pump, of a body, in the plane through the
    centre of gravity. The image may be the item itself; None if there is none."""
    y = body.centre_of_gravity[1]
    tanks = [_index_of_image(_mirror_image_of(t, y), body.tanks) for t in body.tanks]
    names = {
        t.name: None if k is None else body.tanks[k].name
        for t, k in zip(body.tanks, tanks, strict=True)
    }
    return tanks, [_same_pump(_mirror_pump(pump, body, names), body.pumps) for pump in body.pumps]


def without_image(body: scene.Body) -> list[str]:
    """Names of the tanks and pumps without a mirror image."""
    tanks, pumps = image_indices(body)
    names = [*(tank.name for tank in body.tanks), *(pump.name for pump in body.pumps)]
    return [name for name, image in zip(names, [*tanks, *pumps], strict=True) if image is None]


def _mirror_image_of(tank: scene.Tank, y: float) -> scene.Tank:
    shape = tank.shape
    if isinstance(shape, scene.TankTable):
        centroid = shape.centroid * [1.0, -1.0, 1.0] + [0.0, 2.0 * y, 0.0]
        image = replace(shape, centroid=centroid, surface=shape.surface * [1.0, -1.0, 1.0])
        return replace(tank, shape=image)
    if isinstance(shape, scene.TankMesh):
        corners = shape.corners[:, ::-1] * [1.0, -1.0, 1.0] + [0.0, 2.0 * y, 0.0]
        return replace(tank, shape=replace(shape, corners=corners))
    low = list(shape.low)
    high = list(shape.high)
    low[1], high[1] = 2.0 * y - high[1], 2.0 * y - low[1]
    return replace(tank, shape=replace(shape, low=tuple(low), high=tuple(high)))


def _index_of_image(image: scene.Tank, tanks: Sequence[scene.Tank]) -> int | None:
    return next((k for k, other in enumerate(tanks) if _is_equal_tank(image, other)), None)


def _is_equal_tank(a: scene.Tank, b: scene.Tank) -> bool:
    """True if two tanks differ in their names only."""
    same = (a.density, a.free_surface) == (b.density, b.free_surface) and _is_close(
        a.level, b.level
    )
    return same and _have_same_shape(a.shape, b.shape) and _have_same_plan(a.plan, b.plan)


def _have_same_shape(a: scene.TankShape, b: scene.TankShape) -> bool:
    if isinstance(a, scene.Box) and isinstance(b, scene.Box):
        return _is_close((*a.low, *a.high, a.permeability), (*b.low, *b.high, b.permeability))
    if isinstance(a, scene.TankTable) and isinstance(b, scene.TankTable):
        names = ("level", "volume", "centroid", "surface")
        return all(_is_close(getattr(a, name), getattr(b, name)) for name in names)
    if isinstance(a, scene.TankMesh) and isinstance(b, scene.TankMesh):
        return _have_same_contents(a, b)
    return False


def _have_same_contents(a: scene.TankMesh, b: scene.TankMesh) -> bool:
    """True if two meshes hold the same contents at every level, whatever their triangles."""
    if not _is_close(*(np.ptp(mesh.corners, axis=(0, 1)) for mesh in (a, b))):
        return False
    x, y = (pieces(mesh, np.zeros(3)) for mesh in (a, b))
    volume = capacity(a)
    size = np.abs(a.corners).max()
    unit = np.repeat([volume * size, volume * size**2, size, volume * size], [3, 6, 1, 3])
    apart = (x["c"][..., 0] - y["c"][..., 0]) / unit if x.shape == y.shape else np.ones(1)
    return bool(np.abs(apart).max() <= SYMMETRY_RTOL)


def _have_same_plan(a: scene.Plan | None, b: scene.Plan | None) -> bool:
    if a is None or b is None:
        return a is b
    return _is_close(a.time, b.time) and _is_close(a.level, b.level)


def _is_close(a: object, b: object) -> bool:
    """True if numbers agree within `SYMMETRY_RTOL` of the largest."""
    x = np.asarray(a, float)
    y = np.asarray(b, float)
    return x.shape == y.shape and bool(
        np.all(np.abs(x - y) <= SYMMETRY_RTOL * np.abs(x).max(initial=0.0))
    )


def _mirror_pump(pump: scene.Pump, body: scene.Body, names: dict[str, str | None]) -> scene.Pump:
    """The pump between the images of its tanks; ``names`` are the names of the images."""
    levels = {
        f"tank_level.{name} of {body.name}": f"tank_level.{image} of {body.name}"
        for name, image in names.items()
    }

    def mirror_condition(
        when: float | scene.LevelReached | scene.When | None,
    ) -> float | scene.LevelReached | scene.When | None:
        if isinstance(when, scene.LevelReached):
            return replace(when, tank=str(names[when.tank]))
        if isinstance(when, scene.When) and when.channel in levels:
            return replace(when, channel=levels[when.channel])
        return when

    ends = [None if end is None else str(names[end]) for end in (pump.source, pump.target)]
    start = mirror_condition(pump.start)
    assert start is not None
    return replace(
        pump, source=ends[0], target=ends[1], start=start, stop=mirror_condition(pump.stop)
    )


def _same_pump(image: scene.Pump, pumps: Sequence[scene.Pump]) -> int | None:
    images = enumerate(replace(pump, name=image.name) for pump in pumps)
    return next((k for k, other in images if other == image), None)
