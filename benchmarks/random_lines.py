"""Random lines: all profiles, over the ranges that mooring lines, tethers and hawsers have, and
beyond."""

from __future__ import annotations

import numpy as np

from benchmarks.exact_lines import Line


def random_line(rng: np.random.Generator) -> Line:
    """A line of one piece, slack to taut, heavy, weightless or floating, on the bed or off it."""
    length = 10 ** rng.uniform(1, 3.7)
    weight = 10 ** rng.uniform(-1, 4)
    stiffness = weight * 10 ** rng.uniform(2, 10)
    kind = rng.choice(["lies", "rests", "free"], p=[0.5, 0.2, 0.3])
    sign = rng.choice([1.0, -1.0, 0.0], p=[0.85, 0.12, 0.03]) if kind == "free" else 1.0
    x, z = _ends(rng, length, kind == "free")
    bed = {"lies": 0.0, "rests": -length * 10 ** rng.uniform(-4, -0.3), "free": -np.inf}[kind]
    if kind == "rests":
        z = max(z - rng.uniform(0, 1) * z, z + bed)
    friction = 10 ** rng.uniform(-2, 1) if kind == "lies" and rng.random() < 0.5 else 0.0
    return Line([(length, sign * weight, stiffness, 0.0)], x, z, bed, friction)


def _ends(rng: np.random.Generator, length: float, any_side: bool) -> tuple[float, float]:
    """Distance and height of the ends."""
    how = rng.choice(["slack", "near", "taut"], p=[0.5, 0.35, 0.15])
    if how == "slack":
        chord = length * rng.uniform(0.2, 1)
    elif how == "near":
        chord = length * (1 + rng.choice([-1, 1]) * 10 ** rng.uniform(-8, -2))
    else:
        chord = length * (1 + 10 ** rng.uniform(-3, -0.7))
    angle = rng.uniform(0, np.pi / 2)
    if rng.random() < 0.03:
        angle = np.pi / 2
    x = 0.0 if angle == np.pi / 2 else chord * np.cos(angle)
    z = chord * np.sin(angle)
    return x, -z if any_side and rng.random() < 0.5 else z


def random_chain(rng: np.random.Generator) -> Line:
    """A line of two to five pieces, of which one may carry a clump."""
    n = int(rng.integers(2, 6))
    lengths = 10 ** rng.uniform(1.5, 3, n)
    weights = 10 ** rng.uniform(1, 3.5, n)
    rows = []
    for L, w in zip(lengths, weights, strict=True):
        hung = 10 ** rng.uniform(3, 5.5) if rng.random() < 0.3 else 0.0
        rows.append((float(L), float(w), float(w * 10 ** rng.uniform(3, 7)), float(hung)))
    kind = rng.choice(["lies", "rests", "free"])
    x, z = _ends(rng, float(lengths.sum()), kind == "free")
    length = lengths.sum()
    bed = {"lies": 0.0, "rests": -length * 10 ** rng.uniform(-3, -0.5), "free": -np.inf}[kind]
    friction = rng.uniform(0, 1) if kind == "lies" and rng.random() < 0.5 else 0.0
    return Line(rows, x, z, float(bed), friction)
