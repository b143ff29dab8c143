"""Lines in their plane, against extended precision, MoorPy, OrcaFlex, and work along paths."""

import csv
from collections.abc import Iterator
from functools import cache
from math import inf, log, nan, pi
from typing import Any

import numpy as np
import pytest
from validation_data import unpacked

from hydrosim.elements.line import shape
from hydrosim.elements.line.hang import SuspendedLine, new_pieces
from hydrosim.elements.line.points import line_points
from hydrosim.elements.line.search import length_rates, stiffness, stored_energy
from hydrosim.report.evidence import Feature, Kind

Line = tuple[np.ndarray, float, float, float, float]
"""Pieces, x, z, bed, friction."""
CHAIN = (1000.0, 800.0, 7e8, 0.0)
MIXED = ((100.0, 500.0, 1e8, 0.0), (200.0, 100.0, 2e7, 5e4), (400.0, 800.0, 1e8, 0.0))


def line(*rows: tuple[float, ...], x: float, z: float, bed: float = 0.0, CB: float = 0.0) -> Line:
    """A line of rows of length, weight, EA and hung."""
    return new_pieces(*np.array(rows).T), float(x), float(z), float(bed), float(CB)


def suspended(case: Line) -> SuspendedLine:
    return SuspendedLine(case[0], 0, case[0].size, *case[1:])


def pull(case: Line, H: float = nan, V: float = nan) -> shape.LinePull:
    """Its solution from a guess."""
    return shape.LinePull(*shape.solve(suspended(case), H, V))


def of(function: Any, case: Line, *more: object) -> Any:
    """A function of the line and its pull."""
    return function(suspended(case), pull(case), *more)


KINDS = {
    "lies": line(CHAIN, x=850.0, z=200.0),
    "friction": line(CHAIN, x=880.0, z=200.0, CB=0.4),
    "friction takes all": line(CHAIN, x=850.0, z=200.0, CB=1.5),
    "hangs": line(CHAIN, x=1000.0, z=100.0, bed=-inf),
    "as a U": line(CHAIN, x=800.0, z=20.0, bed=-500.0),
    "rests": line(CHAIN, x=800.0, z=20.0, bed=-60.0),
    "slack": line(CHAIN, x=700.0, z=200.0),
    "slack at rest": line(CHAIN, x=700.0, z=20.0, bed=-60.0),
    "tether": line((300.0, -90.0, 5e6, 0.0), x=30.0, z=310.0),
    "pieces": line(*MIXED, x=620.0, z=200.0),
    "clump on the bed": line(*MIXED, x=600.0, z=200.0, CB=0.2),
    "clump between": line(*MIXED, x=450.0, z=170.0, bed=-70.0),
    "buoy": line((100.0, 500.0, 1e8, 0), (100.0, 500.0, 2e7, -7e4), CHAIN, x=1080.0, z=170.0),
}


@cache
def table(name: str) -> list[dict[str, float]]:
    """Rows of a stored table."""
    with unpacked(f"lines/{name}.csv").open() as file:
        return [{k: float(v or 0.0) for k, v in row.items()} for row in csv.DictReader(file)]


def exact_lines() -> Iterator[tuple[Line, dict[str, float]]]:
    """Lines whose pull and stiffness are known to 50 digits (tests/data/README.md)."""
    for row in table("exact"):
        names, pieces = ("length", "weight", "stiffness", "hung"), range(1, 6)
        rows = [tuple(row[f"{c}{i}"] for c in names) for i in pieces if row[f"length{i}"] > 0.0]
        yield line(*rows, x=row["x"], z=row["z"], bed=row["bed"], CB=row["friction"]), row


def error_of(p: shape.LinePull, row: dict[str, float]) -> float:
    """Error of both forces in parts of the tension."""
    tension = np.hypot(row["H"], row["V"])
    error = max(abs(p.H - row["H"]), abs(p.V - row["V"]))
    return float(error / tension) if tension > 0.0 else float(error)


def test_extended_precision(validated) -> None:
    """300 lines: slack to taut, soft to stiff, up to five pieces with clumps, on the bed or off."""
    errors = [error_of(pull(case), row) for case, row in exact_lines()]
    assert len(errors) == 300
    claim = "pull of 300 random mooring lines, of the tension"
    against = "textbook equations at 50 digits"
    validated(Kind.INDEPENDENT, claim, against, max(errors), 1e-11, Feature.CATENARIES)


def test_guess() -> None:
    """The solution does not depend on the guess."""
    for case, row in exact_lines():
        p = pull(case)
        tension = np.hypot(row["H"], row["V"])
        for a, b in ((1.3, 0.7), (0.999, 1.002)):
            q = pull(case, a * p.H, b * p.V)
            np.testing.assert_allclose(q[:4], p[:4], rtol=0, atol=1e-13 * tension)


def test_stiffness() -> None:
    """Against differences at 50 digits."""
    for case, row in exact_lines():
        exact = np.array([row[name] for name in ("Hx", "Hz", "Vx", "Vz")])
        if not np.any(np.isnan(exact)):
            found = of(stiffness, case)
            tiny = 1e-8 * np.abs(exact).max() + 1e-12
            np.testing.assert_allclose(found, exact, rtol=0, atol=tiny)


def test_stiffness_straight_down() -> None:
    """A line straight above its anchor is a pendulum: x = H (ln(Va/Vb)/w + L/EA)."""
    case = line(CHAIN, x=0.0, z=1010.0, bed=-inf)
    p = pull(case)
    L, w, EA, _ = CHAIN
    assert p.H == 0.0
    assert p.V - p.anchor_V == pytest.approx(w * L)
    exact = (1 / (log(p.V / p.anchor_V) / w + L / EA), 0, 0, EA / L)
    np.testing.assert_allclose(of(stiffness, case), exact, atol=1e-9)


def test_moorpy(validated) -> None:
    """500 random lines that MoorPy solves."""
    errors = []
    for row in table("moorpy"):
        piece = (row["length"], row["weight"], row["stiffness"], 0.0)
        p = pull(line(piece, x=row["x"], z=row["z"], bed=row["bed"], CB=row["friction"]))
        errors.append(error_of(p, row))
    assert len(errors) == 500
    claim = "pull of 500 random mooring lines, of the tension"
    against = "MoorPy 1.3.0 at its tolerance 1e-12"
    validated(Kind.PROGRAM, claim, against, max(errors), 1e-6, Feature.CATENARIES)


@pytest.mark.parametrize(
    ("case", "expected", "rtol"),
    [
        (line((500.0, 800.0, 7.51e12, 0), x=400, z=200, CB=5), (96643.4, 237751.8), 1e-6),
        (  # MoorPy's tests
            line((130.0, 881.05, 7.51e8, 0), x=89.9, z=59.2, bed=-372.7),
            (31373.229006, 87886.158730),
            1e-6,
        ),
    ],
)
def test_published(case: Line, expected: tuple[float, float], rtol: float) -> None:
    """Rows that MoorPy publishes."""
    np.testing.assert_allclose(pull(case)[:2], expected, rtol=rtol)


@pytest.mark.parametrize(
    ("more", "H", "V", "anchor_V"),
    [
        (-0.01, 71116.8171986, 76680.6434641, 75567.2658246),
        (0.0, 58377.2414227, 63044.4129559, 61931.0044429),
        (0.01, 46077.2711724, 49878.8124286, 48765.3730421),
    ],
)
def test_nearly_taut(more: float, H: float, V: float, anchor_V: float) -> None:
    """At 40 digits; MoorPy falls back to a straight line here."""
    row = (360.63566262396927 + more, 3.08735, 7e8, 0)
    p = pull(line(row, x=246.22420940032947, z=263.55766330843164))
    np.testing.assert_allclose(p[:3], (H, V, anchor_V), rtol=2e-12)


def test_inextensible() -> None:
    """L 1000 m over 800 and 100 m, w 1962 N/m: H = 671.478 kN, T = 1288.8 kN."""
    p = pull(line((1000.0, 1962.0, 1e18, 0), x=800, z=100, bed=-inf))
    assert pytest.approx(671.478e3, rel=1e-6) == p.H
    assert np.hypot(p.H, p.V) == pytest.approx(1288.8e3, rel=1e-4)
    a = p.H / 1962.0
    assert 2 * a * np.sinh(800 / (2 * a)) == pytest.approx(np.sqrt(1000**2 - 100**2), rel=1e-9)


@pytest.mark.parametrize(
    ("depth", "x", "length", "fairlead", "bound"),
    [
        (50, 400, 410, 991.6e3, 0.015),
        (200, 700, 760, 2065.4e3, 0.005),
        (600, 1500, 1700, 5232.6e3, 0.005),
    ],
)
def test_chains(validated, depth, x, length, fairlead, bound):
    """MoorDyn's chains (tests/Mooring/WD0050_Chain.txt and the like): tension by OrcaFlex."""
    weight = (390.0 - 1025.0 * pi / 4 * 0.252**2) * 9.8
    p = pull(line((length, weight, 1.674e9, 0), x=x, z=depth))
    error = abs(np.hypot(p.H, p.V) / fairlead - 1.0)
    claim = f"chain in water {depth} m deep, tension at the fairlead"
    validated(Kind.PROGRAM, claim, "OrcaFlex", error, bound, Feature.CATENARIES)
    assert np.hypot(p.anchor_H, p.anchor_V) < np.hypot(p.H, p.V)


@pytest.mark.parametrize("name", KINDS)
def test_length_rates(name: str) -> None:
    """Against differences, of every piece."""
    case = KINDS[name]
    for k in range(case[0].size):
        sides = []
        for h in (1e-4, -1e-4):
            pieces = case[0].copy()
            pieces["length"][k] += h
            sides.append(np.array(pull((pieces, *case[1:]))[:2]))
        scale = max(np.abs(of(stiffness, case)).max(), 1.0)
        slope = (sides[0] - sides[1]) / 2e-4
        np.testing.assert_allclose(of(length_rates, case, k), slope, rtol=0, atol=1e-6 * scale)


@pytest.mark.parametrize("name", [name for name, case in KINDS.items() if case[4] == 0.0])
def test_energy_is_work(name: str) -> None:
    """Without friction the forces do the work that the stored energy grows by."""
    pieces, x, z, bed, _ = KINDS[name]
    nodes, weights = np.polynomial.legendre.leggauss(16)
    dx, dz = 0.4, 0.3
    work = 0.0
    for s, c in zip(nodes, weights, strict=True):
        case = (pieces, x + dx * s, z + dz * s, bed, 0.0)
        assert of(shape.find_profile, case) == of(shape.find_profile, KINDS[name])
        p = pull(case)
        work += c * (p.H * dx + p.V * dz)
    ends = [of(stored_energy, (pieces, x + s * dx, z + s * dz, bed, 0.0)) for s in (-1, 1)]
    assert ends[1] - ends[0] == pytest.approx(work, rel=1e-10)


@pytest.mark.parametrize("name", KINDS)
def test_points(name: str) -> None:
    """A fine polygon leads to the anchor, on the bed or above; its tension and weight make U."""
    case = KINDS[name]
    pieces, x, _, bed, _ = case
    p = pull(case)
    n = 42001  # joints of pieces are among the points
    places, T = line_points(suspended(case), p, n)
    np.testing.assert_allclose(places[-1], (x, 0.0), atol=1e-9 * x)
    assert places[:, 1].min() >= bed - 1e-9 * x
    assert T[0] == pytest.approx(np.hypot(p.H, p.V))
    assert T[-1] == pytest.approx(np.hypot(p.anchor_H, p.anchor_V), abs=1e-9 * T[0])
    s = np.linspace(0.0, pieces["length"].sum(), n)
    ends = np.cumsum(pieces["length"])
    middle = 0.5 * (s[1:] + s[:-1])
    i = np.searchsorted(ends, middle)
    ds = np.diff(s)
    height = 0.5 * (places[1:, 1] + places[:-1, 1])
    tension = 0.5 * (T[1:] + T[:-1])
    energy = np.sum(ds * (pieces["weight"][i] * height + tension**2 / (2 * pieces["stiffness"][i])))
    energy += np.sum(pieces["hung"][:-1] * np.interp(ends[:-1], s, places[:, 1]))
    scale = np.hypot(p.H, p.V) * s[-1]
    assert of(stored_energy, case) == pytest.approx(energy, abs=2e-6 * scale)


@pytest.mark.parametrize(
    ("name", "start", "end", "profiles"),
    [
        ("lies", 700.0, 990.0, 3),  # slack, lies, hangs
        ("friction takes all", 790.0, 990.0, 4),  # slack, dead, under tension, hangs
        ("rests", 850.0, 990.0, 3),  # slack, rests, hangs
        ("clump on the bed", 520.0, 690.0, 5),
        ("clump between", 400.0, 640.0, 4),
    ],
)
def test_kinks(name: str, start: float, end: float, profiles: int) -> None:
    """The room of a profile is positive inside and falls through zero where it ends."""
    pieces, _, z, bed, CB = KINDS[name]

    def at(x: float) -> Line:
        return pieces, x, z, bed, CB

    def roomy(x: float, profile: int) -> float:
        return of(shape.kink_room, at(x), profile)

    xs = np.linspace(start, end, 120)
    seen = [of(shape.find_profile, at(x)) for x in xs]
    assert len(dict.fromkeys(seen)) >= profiles
    for x, profile in zip(xs, seen, strict=True):
        assert roomy(x, profile) >= 0.0
    for i in np.flatnonzero(np.diff(seen)):
        low, high = xs[i], xs[i + 1]
        while high - low > 1e-11 * end:
            middle = 0.5 * (low + high)
            inside = of(shape.find_profile, at(middle)) == seen[i]
            low, high = (middle, high) if inside else (low, middle)
        before, after = of(shape.find_profile, at(low)), of(shape.find_profile, at(high))
        for profile, inner, outer in ((before, low, high), (after, high, low)):
            assert 0.0 <= roomy(inner, profile) < 1e-6
            assert -1e-6 < roomy(outer, profile) <= 0.0


def test_floating_pieces() -> None:
    """Random lines of which pieces float, or hang from buoys: what is found reaches the anchor,
    nowhere below the bed, and nothing that lies floats. All else is refused. The potential energy
    is convex, so such a shape is the only one."""
    solved = 0
    for seed in range(300):
        rng = np.random.default_rng([7, seed])
        n = int(rng.integers(2, 6))
        pieces = new_pieces(
            10 ** rng.uniform(1.3, 3, n),
            10 ** rng.uniform(1, 3.5, n) * rng.choice([-1, 1, 1, 1], n),
            10 ** rng.uniform(5, 9.5, n),
            rng.choice([-1, 0, 1], n) * 10 ** rng.uniform(3, 5.5, n),
        )
        length = pieces["length"].sum()
        chord = length * rng.uniform(0.5, 1.05)
        angle = rng.uniform(0, pi / 2)
        case = (pieces, chord * np.cos(angle), chord * np.sin(angle), 0.0, 0.0)
        p = pull(case)
        assert p.reason in (shape.SOLVED, shape.FLOATS, shape.TWICE)
        if not p.converged:
            continue
        solved += 1
        places, _ = line_points(suspended(case), p, 501)
        np.testing.assert_allclose(places[-1], (case[1], 0.0), atol=1e-8 * length)
        assert places[:, 1].min() >= -1e-9 * length
        lies = np.cumsum(pieces["length"]) > p.touch * (1 + 1e-12)
        assert np.all(pieces["weight"][lies] > 0.0)
    assert solved > 200


def test_mirror() -> None:
    """A line with its ends exchanged, and one that floats in water turned over, is the same."""
    p = pull(line(CHAIN, x=900.0, z=200.0, bed=-inf))
    q = pull(line(CHAIN, x=900.0, z=-200.0, bed=-inf))
    np.testing.assert_allclose((q.H, q.V, q.anchor_V), (p.H, -p.anchor_V, -p.V), rtol=1e-13)
    L, w, EA, hung = CHAIN
    q = pull(line((L, -w, EA, hung), x=900.0, z=-200.0, bed=-inf))
    np.testing.assert_allclose((q.H, q.V, q.anchor_V), (p.H, -p.V, -p.anchor_V), rtol=1e-13)


@pytest.mark.parametrize(
    ("case", "reason"),
    [
        (line(CHAIN, x=900.0, z=-1.0), shape.BELOW),
        (line(CHAIN, x=900.0, z=200.0, bed=1.0), shape.BURIED),
        (
            line((400.0, 800.0, 7e8, 0), (400.0, 800.0, 7e8, -5e4), CHAIN, x=1500.0, z=150.0),
            shape.FLOATS,
        ),
        (line((300.0, 800.0, 7e8, 0), (10.0, -3e4, 7e8, 0), CHAIN, x=1100.0, z=60.0), shape.TWICE),
    ],
)
def test_refused(case: Line, reason: int) -> None:
    """Lines that are not solved say so."""
    p = pull(case)
    assert not p.converged
    assert p.reason == reason
