"""Tanks, plans of their levels, and pumps."""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from hydrosim.scene.triggers import LevelReached, When


@dataclass(frozen=True)
class Box:
    """A tank between two corners (3,) [m]; ``permeability`` is the fraction that fluid fills."""

    low: tuple[float, ...]
    high: tuple[float, ...]
    permeability: float = 1.0


@dataclass(frozen=True, eq=False)
class TankTable:
    """A tank given by a table. At each ``level`` (n,) above its bottom [m], rising from 0, it has
    the ``volume`` (n,) of fluid [m^3], its ``centroid`` (n, 3), and the second moments xx, xy, yy
    of the free ``surface`` about its centroid (n, 3) [m^4]."""

    level: np.ndarray
    volume: np.ndarray
    centroid: np.ndarray
    surface: np.ndarray


@dataclass(frozen=True, eq=False)
class TankMesh:
    """A tank inside the triangles ``corners`` (nt, 3, 3) [m] of a closed mesh, normals outward.
    ``permeability`` is the fraction that fluid fills; ``source`` names the mesh in messages."""

    corners: np.ndarray
    permeability: float = 1.0
    source: str = "a mesh"


TankShape = Box | TankTable | TankMesh


class FreeSurface(StrEnum):
    """Free surface of the fluid in a tank: level at all times, or fixed to the tank."""

    QUASI_STATIC = "quasi_static"
    FROZEN = "frozen"


@dataclass(frozen=True, eq=False)
class Plan:
    """Levels (n,) [m] of a tank at times (n,) [s]. The flow from or to the sea is constant between
    two times, and zero before the first and after the last."""

    time: np.ndarray
    level: np.ndarray


@dataclass(frozen=True)
class Tank:
    """A tank of a body, in the database's frame, with a fluid of this ``density`` [kg/m^3];
    ``level`` [m] is the level at the start, above the bottom."""

    name: str
    shape: TankShape
    level: float
    density: float = 1025.0
    surface: FreeSurface = FreeSurface.QUASI_STATIC
    plan: Plan | None = None


@dataclass(frozen=True)
class Pump:
    """Moves ``rate`` [kg/s] from the ``source`` to the ``target``, from ``start`` to ``stop``. Both
    are tanks of its body; None is the sea. ``start`` and ``stop`` are times [s], levels or events.
    Without ``stop`` it runs until the source is empty or the target full."""

    name: str
    rate: float
    source: str | None
    target: str | None
    start: float | LevelReached | When = 0.0
    stop: float | LevelReached | When | None = None
