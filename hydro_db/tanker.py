"""Mesh of the tanker: a full hull with a flat bottom, an elliptic bow and a transom stern.

The half-breadth at the deck is that of the middle body, tapered over both ends by quarter ellipses.
Sections are superellipses: nearly boxes amidships, rounder towards the ends. The keel is level and
rises only under the stern. Deck and deckhouse are for the eye. The origin is on the waterline, over
the centre of buoyancy of the panels.

python hydro_db/tanker.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from hydrosim.database.build import mesh
from hydrosim.files.quantities import MeshKeys

HERE = Path(__file__).parent
HALF_LENGTH = 120.0  # m
HALF_BEAM = 21.0  # m
DRAUGHT = 14.0  # m
FREEBOARD = 7.0  # m
HOUSE = [
    (-112.0, -88.0),
    (-15.0, 15.0),
    (FREEBOARD, FREEBOARD + 18.0),
]  # x, y and z of the deckhouse, m
BOW_LENGTH = 42.0  # of the ellipse, m
STERN_LENGTH = 60.0  # of the taper, m
STEM = 0.1  # breadth of the flat stem, of the full one
TRANSOM = 0.6  # breadth of the transom, of the full one
RUN_LENGTH = 48.0  # over which the keel rises, m
COUNTER = 3.0  # draught at the transom, m
STATIONS = 52
POINTS = 11  # of a half section below the water


def half_breadth(x: ArrayLike) -> np.ndarray:
    """Half-breadth at the waterline [m] at ``x`` forward of amidships [m]."""
    x = np.asarray(x)
    bow = np.clip((x - HALF_LENGTH + BOW_LENGTH) / BOW_LENGTH, 0.0, 1.0)
    stern = np.clip((STERN_LENGTH - HALF_LENGTH - x) / STERN_LENGTH, 0.0, 1.0)
    return HALF_BEAM * np.sqrt(1.0 - (1.0 - STEM**2) * bow**2) * (1.0 - (1.0 - TRANSOM) * stern**2)


def keel_depth(x: ArrayLike) -> np.ndarray:
    """Depth of the keel [m] at ``x`` forward of amidships [m]."""
    x = np.asarray(x)
    stern = np.clip((RUN_LENGTH - HALF_LENGTH - x) / RUN_LENGTH, 0.0, 1.0)
    return DRAUGHT - (DRAUGHT - COUNTER) * stern**2 * (3.0 - 2.0 * stern)


def roundness(x: ArrayLike) -> np.ndarray:
    """Exponent of the section's superellipse at ``x`` forward of amidships [m]."""
    x = np.asarray(x)
    bow = np.clip((x - HALF_LENGTH + BOW_LENGTH) / BOW_LENGTH, 0.0, 1.0)
    stern = np.clip((STERN_LENGTH - HALF_LENGTH - x) / STERN_LENGTH, 0.0, 1.0)
    return 9.0 - 5.0 * bow**2 - 6.0 * stern


def section(x: float) -> np.ndarray:
    """Points (POINTS, 2) of y and z [m] from the keel to the waterline, closer at the waterline."""
    angle = np.linspace(0.0, np.pi / 2, 4001)
    power = 2.0 / roundness(x)
    outline = np.stack(
        [half_breadth(x) * np.sin(angle) ** power, -keel_depth(x) * np.cos(angle) ** power]
    )
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(outline)))])
    share = np.sin(np.linspace(0.0, 0.5, POINTS) * np.pi * 0.8) / np.sin(0.4 * np.pi)
    points = np.stack([np.interp(share * along[-1], along, line) for line in outline], axis=1)
    points[-1] = half_breadth(x), 0.0
    return points


def stations() -> np.ndarray:
    """Stations [m] forward of amidships, closer towards both ends."""
    even = np.linspace(-1.0, 1.0, STATIONS)
    return HALF_LENGTH * (0.55 * even + 0.45 * np.sin(np.pi / 2 * even))


def patch(rows: np.ndarray) -> np.ndarray:
    """Panels (n, 4, 3) of a net of points (stations, points, 3)."""
    corners = [rows[:-1, :-1], rows[:-1, 1:], rows[1:, 1:], rows[1:, :-1]]
    return np.stack(corners, axis=2).reshape(-1, 4, 3)


def half_hull() -> np.ndarray:
    """Panels (n, 4, 3) of the half hull at y >= 0 up to the deck, normals outward."""
    x = stations()
    net = np.array([[(place, y, z) for y, z in section(place)] for place in x])
    rim = net[:, -1:] + [0.0, 0.0, FREEBOARD]
    side = np.concatenate([net[:, -1:], rim], axis=1)
    deck = np.concatenate([rim, rim * [1.0, 0.0, 1.0]], axis=1)
    upper = np.stack([side * [1.0, 0.0, 1.0], side], axis=1)
    stern, bow = (np.concatenate([end_plate(net[k]), patch(upper[k])]) for k in (0, -1))
    parts = [patch(rows) for rows in (net, side, deck)]
    return np.concatenate([*parts, stern, bow[:, [0, 3, 2, 1]]])


def end_plate(outline: np.ndarray) -> np.ndarray:
    """Panels of a flat end: rings from the middle of the waterline to its ``outline`` (n, 3)."""
    middle = outline[-1] * [1.0, 0.0, 1.0]
    rings = np.linspace(0.0, 1.0, 4)[:, None, None]
    return patch(middle + rings * (outline - middle))


def half_house() -> np.ndarray:
    """Panels (5, 4, 3) of the half deckhouse at y >= 0, normals outward."""
    (aft, fore), (_, y), (foot, top) = HOUSE
    low = np.array([(aft, 0, foot), (aft, y, foot), (fore, y, foot), (fore, 0, foot)], float)
    high = low + np.array([0.0, 0.0, top - foot])
    walls = [[low[k], high[k], high[k + 1], low[k + 1]] for k in range(3)]
    return np.array([*walls, high[::-1], low])


def write(name: str, panels: np.ndarray) -> None:
    """Write quadrilaterals (n, 4, 3) as a Wavefront file with each corner once."""
    corners, faces = np.unique(panels.reshape(-1, 3).round(6), axis=0, return_inverse=True)
    lines = [f"v {x:.6g} {y:.6g} {z:.6g}" for x, y, z in corners]
    lines += [f"f {a} {b} {c} {d}" for a, b, c, d in faces.reshape(-1, 4) + 1]
    (HERE / f"{name}.obj").write_text("\n".join([*lines, ""]))


if __name__ == "__main__":
    half = np.concatenate([half_hull(), half_house()])
    whole = np.concatenate([half, half[:, [0, 3, 2, 1]] * [1.0, -1.0, 1.0]])
    write("tanker", whole)
    wet = mesh.read_panels(HERE / "tanker.obj", MeshKeys())
    centre = mesh.integrals(wet).centre_of_buoyancy
    print(f"centre of buoyancy {centre[0]:.3f} m forward of amidships")
    write("tanker", whole - [centre[0], 0.0, 0.0])
