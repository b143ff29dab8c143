"""Lines with a curve of tension over stretch: against quadrature, differences and the ledger."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import pairwise
from math import inf, nan, pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
import yaml
from scenes import assert_continues, block, catenary_of, mooring, moving, scene
from scipy.integrate import quad, quad_vec
from scipy.optimize import brentq

import hydrosim as hs
from hydrosim.analysis.line import lines_of_system
from hydrosim.case.lines.chains import case_keys, read_mooring_system
from hydrosim.elements.line.hang import SuspendedLine, new_pieces
from hydrosim.elements.line.points import line_points
from hydrosim.elements.line.search import length_rates, stiffness, stored_energy
from hydrosim.elements.line.shape import (
    CORNER_CODE,
    LOOSE,
    SOLVED,
    LinePull,
    find_profile,
    kink_room,
    solve,
)
from hydrosim.errors import InputError
from hydrosim.files.text import Source
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import natural_modes
from hydrosim.report.evidence import Feature, Kind
from hydrosim.scene import Environment, Method, Scene

DEPTH = 50.0
WAYS = ("hangs", "lies", "rests")

SAMPLES = 200
"""Places on each segment; between two of them a tension passes a corner once at most."""


class CurvedLine(NamedTuple):
    """A line, for hydrosim and for quadrature: ``way`` is how it meets the bed."""

    pieces: np.ndarray
    curves: dict[int, np.ndarray]
    x: float
    z: float
    way: str = "hangs"
    bed: float = -inf
    friction: float = 0.0

    @property
    def suspended(self) -> SuspendedLine:
        ends = (self.x, self.z, self.bed, self.friction)
        return SuspendedLine(self.pieces, 0, self.pieces.size, *ends)

    def pull(self, H: float = nan, V: float = nan) -> LinePull:
        return LinePull(*solve(self.suspended, H, V))

    def of(self, function: Any, *more: object) -> Any:
        """A function of the line and its pull."""
        return function(self.suspended, self.pull(), *more)


def strain_of(line: CurvedLine, i: int, T: float) -> float:
    """Stretch of a segment; beyond the end of its curve by the last slope."""
    if i not in line.curves:
        return T / line.pieces["stiffness"][i]
    e, t = line.curves[i]
    last = (e[-1] - e[-2]) / (t[-1] - t[-2])
    return e[-1] + last * (T - t[-1]) if t[-1] < T else float(np.interp(T, t, e))


def misses(line: CurvedLine, H: float, V: float, Va: float) -> np.ndarray:
    """By how much a line with the pulls H, V at the fairlead and Va at the anchor misses its
    anchor and the bed, by quadrature along it."""
    pieces = line.pieces
    ends = np.concatenate([[0.0], np.cumsum(pieces["length"])])
    loads = np.concatenate([[0.0], np.cumsum(pieces["weight"] * pieces["length"] + pieces["hung"])])
    whole = loads[-1] - pieces["hung"][-1]
    total, below = np.zeros(2), np.zeros(2)

    for i, piece in enumerate(pieces):

        def raw(s: float, i: int = i, w: float = piece["weight"]) -> float:
            return V - loads[i] - w * (s - ends[i])

        def back(s: float, raw: Callable[[float], float] = raw) -> float:
            return raw(s) - V + whole - Va

        def state(s: float, raw: Any = raw, back: Any = back) -> tuple[float, float, bool]:
            """T, V and whether it lies."""
            if line.way == "hangs" or raw(s) > 0.0:
                return float(np.hypot(H, raw(s))), raw(s), False
            if line.way == "lies":
                return max(H + line.friction * raw(s), 0.0), 0.0, True
            if back(s) < 0.0:
                return float(np.hypot(H, back(s))), back(s), False
            return H, 0.0, True

        def rate(s: float, i: int = i, state: Any = state) -> np.ndarray:
            T, pull, lies = state(s)
            along = np.array([1.0, 0.0]) if lies else np.array([H, pull]) / T
            return (1.0 + strain_of(line, i, T)) * along

        kinks = [raw, back, lambda s, raw=raw: H + line.friction * raw(s)]
        for level in line.curves.get(i, np.zeros((2, 0)))[1]:
            kinks.append(lambda s, level=level, state=state: state(s)[0] - level)
        marks = np.linspace(ends[i], ends[i + 1], SAMPLES)
        cuts = {ends[i], ends[i + 1]}
        for kink in kinks:
            side = np.array([kink(s) > 0.0 for s in marks])
            for k in np.flatnonzero(side[1:] != side[:-1]):
                cuts.add(brentq(kink, marks[k], marks[k + 1], xtol=1e-14, rtol=1e-15))
        ordered = sorted(cuts)
        for a, b in pairwise(ordered):
            part, _ = quad_vec(rate, a, b, epsabs=1e-15 * ends[-1], epsrel=1e-14)
            total += part
            if state(0.5 * (a + b))[1] < 0.0:
                below += part
    if line.way == "rests":
        off = total[0] - line.x, total[1] - below[1] - line.z + line.bed, below[1] - line.bed
        return np.array(off)
    return total - (line.x, line.z)


def random_curve(rng: np.random.Generator, EA: float, T: float) -> np.ndarray:
    """A curve (2, n) of some corners about a tension T, stiffer and softer."""
    n = int(rng.integers(2, 7))
    tension = np.concatenate([[0.0], np.sort(T * 10 ** rng.uniform(-1.0, 0.5, n))])
    slopes = EA * 10 ** rng.uniform(-0.7, 0.7, n)
    return np.array([np.concatenate([[0.0], np.cumsum(np.diff(tension) / slopes)]), tension])


def random_line(seed: int, way: str) -> tuple[CurvedLine, np.ndarray]:
    """A line whose pulls are drawn first, and whose ends follow from them by quadrature; H, V, and
    the pull at the anchor of one that rests on the bed."""
    rng = np.random.default_rng([19, seed])
    n = int(rng.integers(1, 4))
    length = 10 ** rng.uniform(1.3, 2.7, n)
    weight = 10 ** rng.uniform(1.0, 3.0, n)
    hung = np.zeros(n)
    if n > 1 and rng.random() < 0.6:
        hung[:-1] = 10 ** rng.uniform(2.0, 4.5, n - 1)
        if way == "hangs":
            hung *= rng.choice([-1.0, 1.0], n)
            weight *= rng.choice([-1.0, 1.0, 1.0], n)
    H = float(np.sum(np.abs(weight) * length + np.abs(hung))) * 10 ** rng.uniform(-1.5, 2.0)
    whole = float(np.sum(weight * length) + hung.sum())
    share = {"hangs": (-0.5, 1.5), "lies": (0.2, 1.0), "rests": (0.4, 0.4)}[way]
    V, Va = rng.uniform(*share) * whole, rng.uniform(0.1, 0.5) * whole
    T = float(np.hypot(H, V))
    EA = T * 10 ** rng.uniform(1.0, 2.5)
    curves = {i: random_curve(rng, EA, T) for i in range(n) if i == 0 or rng.random() < 0.6}
    pieces = new_pieces(length, weight, np.full(n, EA), hung, curves)
    friction = rng.uniform(0.0, 2.0) * rng.integers(0, 2) if way == "lies" else 0.0
    line = CurvedLine(pieces, curves, 0.0, 0.0, way, -inf if way == "hangs" else 0.0, friction)
    x, z, *bed = map(float, misses(line, H, V, Va))
    if bed:
        return line._replace(x=x, z=z + bed[0], bed=bed[0]), np.array([H, V, Va])
    return line._replace(x=x, z=z), np.array([H, V])


@cache
def random_lines(way: str) -> list[tuple[CurvedLine, np.ndarray]]:
    return [random_line(seed, way) for seed in range(60)]


def test_pull_against_quadrature(validated: Callable[..., None]) -> None:
    """Lines of some segments with curves, clumps and buoys, softer and stiffer at each corner."""
    errors = []
    for line, drawn in (each for way in WAYS for each in random_lines(way)):
        p = line.pull()
        assert p.converged
        found = np.array([p.H, p.V, -p.anchor_V])[: drawn.size]
        errors.append(np.abs(found - drawn).max() / np.hypot(*drawn[:2]))
    assert len(errors) == 180
    claim = "pull of 180 random lines with curves of tension over stretch, of the tension"
    validated(Kind.INDEPENDENT, claim, "adaptive quadrature", max(errors), 1e-9, Feature.CATENARIES)


@pytest.mark.parametrize("way", WAYS)
def test_stiffness(way: str) -> None:
    """Against differences within a profile. Without friction of the bed it is symmetric and
    positive definite."""
    compared = 0
    for line, _ in random_lines(way):
        exact = np.reshape(line.of(stiffness), (2, 2))
        scale = np.abs(exact).max()
        if line.friction == 0.0:
            assert abs(exact[0, 1] - exact[1, 0]) < 1e-9 * scale
            assert np.linalg.eigvalsh(0.5 * (exact + exact.T)).min() > 0.0
        h = 1e-6 * line.pieces["length"].sum()
        moves = {"x": (h, 0.0), "z": (0.0, h)}
        sides = {
            (axis, sign): line._replace(x=line.x + sign * dx, z=line.z + sign * dz)
            for axis, (dx, dz) in moves.items()
            for sign in (1.0, -1.0, 2.0, -2.0)
        }
        if {moved.of(find_profile) for moved in sides.values()} != {line.of(find_profile)}:
            continue
        compared += 1
        for k, axis in enumerate(moves):
            a, b, c, d = (np.array(sides[axis, sign].pull()[:2]) for sign in (1.0, -1.0, 2.0, -2.0))
            slope = (8.0 * (a - b) - (c - d)) / (12.0 * h)
            np.testing.assert_allclose(exact[:, k], slope, rtol=0, atol=1e-6 * scale)
    assert compared > 40


@pytest.mark.parametrize("way", WAYS)
def test_length_rates(way: str) -> None:
    """Against differences, of every segment."""
    for line, _ in random_lines(way)[:30]:
        h = 1e-6 * line.pieces["length"].sum()
        scale = np.abs(line.of(stiffness)).max()
        for k in range(line.pieces.size):
            longer, shorter = line.pieces.copy(), line.pieces.copy()
            longer["length"][k] += h
            shorter["length"][k] -= h
            ends = [np.array(line._replace(pieces=p).pull()[:2]) for p in (longer, shorter)]
            slope = (ends[0] - ends[1]) / (2.0 * h)
            rates = line.of(length_rates, k)
            np.testing.assert_allclose(rates, slope, rtol=0, atol=1e-5 * scale)


@pytest.mark.parametrize("way", WAYS)
def test_energy_is_work_through_corners(way: str) -> None:
    """Without friction of the bed, the stored energy grows by the work of the pull."""
    for line, _ in random_lines(way)[:30]:
        if line.friction == 0.0:
            far = 1e-2 * line.pieces["length"].sum()

            def pull_at(s: float, line: CurvedLine = line, far: float = far) -> LinePull:
                return line._replace(x=line.x + far * s, z=line.z + far * s).pull()

            work, _ = quad(
                lambda s, at=pull_at: at(s).H + at(s).V, 0.0, 1.0, epsrel=1e-9, limit=200
            )
            moved = line._replace(x=line.x + far, z=line.z + far)
            gain = moved.of(stored_energy) - line.of(stored_energy)
            assert gain == pytest.approx(far * work, rel=1e-7)


@pytest.mark.parametrize("way", WAYS)
def test_points(way: str) -> None:
    """The polygon of a line ends at its anchor, with the tensions at both ends."""
    for line, _ in random_lines(way):
        p = line.pull()
        length = line.pieces["length"].sum()
        places, T = line_points(line.suspended, p, 301)
        np.testing.assert_allclose(places[-1], (line.x, 0.0), atol=1e-9 * length)
        ends = np.hypot(p.H, p.V), np.hypot(p.anchor_H, p.anchor_V)
        assert (T[0], T[-1]) == pytest.approx(ends, abs=1e-9 * ends[0])


def test_a_straight_curve_is_a_number() -> None:
    """To the bit."""
    for line, _ in random_lines("hangs"):
        n = line.pieces.size
        columns = [line.pieces[name] for name in ("length", "weight", "stiffness", "hung")]
        EA = columns[2]
        straight = {
            i: np.array([[0.0, 0.01, 0.03], [0.0, 0.01 * EA[i], 0.03 * EA[i]]]) for i in range(n)
        }
        numbers = line._replace(pieces=new_pieces(*columns))
        curved = line._replace(pieces=new_pieces(*columns, straight))
        assert not curved.pieces["corners"].any()
        curved.pieces["stiffness"] = EA
        assert numbers.pull() == curved.pull()


def test_random_lines_are_solved() -> None:
    """Slack to taut, on the bed and off it, light to heavy; the solution leads to the anchor, and
    does not depend on the guess."""
    for seed in range(300):
        rng = np.random.default_rng([23, seed])
        n = int(rng.integers(1, 5))
        length = 10 ** rng.uniform(0.5, 3.0, n)
        weight = 10 ** rng.uniform(-1.0, 3.5, n) * rng.choice([0.0, 1.0, 1.0, 1.0], n)
        T = 10 ** rng.uniform(3.0, 7.0)
        EA = T * 10 ** rng.uniform(0.5, 2.5)
        curves = {i: random_curve(rng, EA, T) for i in range(n) if rng.random() < 0.8}
        hung = rng.choice([0.0, 1.0], n) * 10 ** rng.uniform(2.0, 5.0, n)
        pieces = new_pieces(length, weight, np.full(n, EA), hung, curves)
        chord, angle = length.sum() * rng.uniform(0.3, 1.3), rng.uniform(0.0, pi / 2.0)
        x, z = float(chord * np.cos(angle)), float(chord * np.sin(angle))
        bed = float(rng.choice([0.0, -inf, -0.2 * length.sum()]))
        friction = float(rng.choice([0.0, 0.7]))
        line = CurvedLine(pieces, curves, x, z, "", bed, friction)
        p = line.pull()
        assert p.reason == SOLVED or (p.reason == LOOSE and not weight.all())
        tension = np.hypot(p.H, p.V)
        if p.H > 0.0:
            places, _ = line_points(line.suspended, p, 201)
            np.testing.assert_allclose(places[-1], (x, 0.0), atol=1e-9 * length.sum())
        for a, b in ((1.3, 0.7), (0.999, 1.002)):
            q = line.pull(a * p.H, b * p.V)
            np.testing.assert_allclose(q[:4], p[:4], rtol=0, atol=1e-11 * tension)


@pytest.mark.parametrize(
    ("weight", "friction", "bed"),
    [(800.0, 0.0, 0.0), (800.0, 0.6, 0.0), (0.0, 0.0, -inf), (-0.0, 0.0, -inf), (20.0, 0.0, -60.0)],
)
def test_kinks_at_corners(weight: float, friction: float, bed: float) -> None:
    """The room of a profile is positive inside and falls through zero where it ends."""
    curve = np.array([[0.0, 0.01, 0.03, 0.06], [0.0, 3e5, 2e6, 3e6]])
    pieces = new_pieces([300.0, 100.0], [weight, weight], [5e7, 5e7], [0.0, 0.0], {1: curve})
    line = CurvedLine(pieces, {1: curve}, 0.0, 100.0, "", bed, friction)
    xs = np.linspace(388.0, 410.0, 150)
    profiles = [line._replace(x=x).of(find_profile) for x in xs]
    assert len(dict.fromkeys(p // CORNER_CODE for p in profiles)) >= 3
    for x, profile in zip(xs, profiles, strict=True):
        assert line._replace(x=x).of(kink_room, profile) >= 0.0
    for i in np.flatnonzero(np.diff(profiles)):
        low, high = xs[i], xs[i + 1]
        while high - low > 1e-11 * high:
            middle = 0.5 * (low + high)
            inside = line._replace(x=middle).of(find_profile) == profiles[i]
            low, high = (middle, high) if inside else (low, middle)
        before, after = (line._replace(x=x).of(find_profile) for x in (low, high))
        for profile, inner, outer in ((before, low, high), (after, high, low)):
            assert 0.0 <= line._replace(x=inner).of(kink_room, profile) < 1e-6
            assert -1e-6 < line._replace(x=outer).of(kink_room, profile) <= 0.0


def roped(step: float, duration: float = 12.0, **changes: Any) -> Scene:
    """A block on three lines with tails of light rope, thrown so that tensions pass corners."""
    tail = np.array([[0.0, 0.05, 0.1, 0.2], [0.0, 2e5, 6e5, 2.5e6]])
    ends = {"ahead": (1.0, 0.0), "astern": (-1.0, 0.1), "abeam": (0.0, 1.0)}
    forces = {
        name: catenary_of(
            "block",
            point=(10.0 * x, 5.0 * y, -2.0),
            anchor=(110.0 * x, 104.0 * y, -DEPTH),
            length=np.array([60.0, 54.0]),
            weight=np.array([2.0, 300.0]),
            stiffness=np.array([4e6, 4e8]),
            hung=np.array([2e2, 0.0]),
            friction=0.0,
            curves={0: tail},
        )
        for name, (x, y) in ends.items()
    }
    thrown = block(4e5, velocity=moving(surge=4.0, sway=1.0, yaw=0.02))
    solver = {"method": Method.RK4, "step": step, **changes}
    case = scene(
        thrown,
        {"afloat": mooring(heave=4e5, roll=4e7, pitch=4e7), **forces},
        duration,
        0.2,
        **solver,
    )
    return replace(case, environment=Environment(water_depth=DEPTH))


def test_ledger_through_corners() -> None:
    """Corners are events, so the energy of the curves is what the body has given. The tension
    converges at the order of the method."""
    exact = hs.simulate(roped(0.00125))
    assert exact.attrs["solver_events"] > 6
    assert np.abs(exact.energy_residual).max() < 1e-9 * float(exact.energy_kinetic.max())
    steps = [0.04, 0.02, 0.01]
    tensions = [hs.simulate(roped(step)).line_tension.values for step in steps]
    errors = [np.abs(tension - exact.line_tension.values).max() for tension in tensions]
    assert errors[-1] < 1e-6 * float(exact.line_tension.max())
    assert errors[0] > 8.0 * errors[1] > 64.0 * errors[2]


def test_a_restart_passes_corners_to_the_bit() -> None:
    case = roped(0.02).with_output(states=True)
    assert_continues(case, hs.simulate(case), (6.0,), "position", "line_tension")


def test_linear_stiffness_is_the_tangent() -> None:
    """The modes at a place have the stiffness of differences of the pull."""
    line, _ = random_lines("hangs")[3]
    at, mass = line.of(stiffness), 1e4
    columns = [line.pieces[name] for name in ("length", "weight", "stiffness", "hung")]
    anchor = (line.x, 0.0, -line.z)
    rope = catenary_of("block", (0.0, 0.0, 0.0), anchor, *columns, curves=line.curves)
    case = scene(block(mass, ("surge",)), {"rope": rope}, 1.0, 0.1)
    modes = natural_modes(linearise(*hs.compile_scene(case)))
    assert modes[0].natural_period == pytest.approx(2.0 * pi * np.sqrt(mass / at[0]), rel=1e-9)


CASE = """
title: Block on a rope
duration: 1 s
bodies:
  block: {mass: 1 t, radii_of_gyration: [1 m, 1 m, 1 m]}
forces:
  rope:
    type: catenary
    body: block
    point: [0 m, 0 m, 0 m]
    anchor: [10.4 m, 0 m, 1 m]
    segments: [{length: 10 m, weight: 10 N/m, stiffness: STIFFNESS}]
"""


MANY = [0.05 * k for k in range(40)]


@pytest.mark.parametrize(
    ("curve", "said"),
    [
        ("{stretch: [0, 1], tension: [0 N, 1 N, 2 N]}", "2 values in stretch and 3 in tension"),
        ("{stretch: [0, 5 %, 5 %], tension: [0 N, 1 N, 2 N]}", "0.05 after 0.05; expected values"),
        ("{stretch: [0, 5 %, 9 %], tension: [0 N, 2 N, 1 N]}", "1 after 2; expected values that"),
        ("{stretch: [0, 5 %], tension: [1 N, 2 N]}", "the first at 0"),
        ("{stretch: [0], tension: [0 N]}", "at least two points"),
        ("{stretch: [0, 5 %]}", "tension"),
        ("{stretch: [0, 5], tension: [0 N, 1 N]}", "found 5; expected a stretch, .* be 2 or less"),
        (f"{{stretch: {MANY}, tension: {MANY}}}", "40 points; expected at most 32"),
        ("0 N", "above 0"),
    ],
)
def test_curves_that_are_refused(tmp_path: Path, curve: str, said: str) -> None:
    path = tmp_path / "rope.yaml"
    path.write_text(CASE.replace("STIFFNESS", curve))
    with pytest.raises(InputError, match=said):
        hs.load_case(path)


def test_a_stretch_beyond_the_curve_is_told(tmp_path: Path) -> None:
    """At the start and by the run; a large stretch within the curve is not."""
    path = tmp_path / "rope.yaml"
    told = {}
    for end in (4, 30):
        curve = f"{{stretch: [0, 2 %, {end} %], tension: [0 N, 30 kN, 60 kN]}}"
        path.write_text(CASE.replace("STIFFNESS", curve))
        told[end] = str(hs.simulate(path).attrs.get("warnings", ""))
    assert "at the start" in told[4]
    assert "the curve of stiffness ends at 6e+04 N" in told[4]
    assert "the curve of its stiffness ends at 6e+04 N" in told[4]
    assert "stiffness" not in told[30]
    assert "stretched" not in told[30]


MOORDYN = """\
--- LINE TYPES ---
Name Diam MassDen EA BA/-zeta EI Cd Ca CdAx CaAx
(-) (m) (kg/m) (N) (N-s/-) (N-m^2) (-) (-) (-) (-)
rope 0.1 12 rope.dat -1 0 1.0 1 0.2 0
--- POINTS ---
Node Type X Y Z M V FX FY FZ CdA CA
(-) (-) (m) (m) (m) (kg) (m^3) (kN) (kN) (kN) (m^2) (-)
1 Fixed 600 0 -100 0 0 0 0 0 0 0
2 Vessel 20 0 -5 0 0 0 0 0 0 0
--- LINES ---
Line LineType AttachA AttachB UnstrLen NumSegs Outputs
(-) (-) (-) (-) (m) (-) (-)
1 rope 1 2 600 20 -
--- SOLVER OPTIONS ---
100 WtrDpth
"""
TABLE = """\
stretch  tension
(-)      (N)
0.0      0.0
0.05     2e5
0.10     6e5
"""


def test_moordyn_table(tmp_path: Path) -> None:
    """EA of a line type may be the name of a table; its curve is that of keys in a case."""
    (tmp_path / "rope.dat").write_text(TABLE)
    file = tmp_path / "lines.txt"
    file.write_text(MOORDYN)
    keys = yaml.safe_load(case_keys(file))["forces"]["line_1"]["segments"]
    assert keys[0]["stiffness"]["stretch"] == [0.0, 0.05, 0.1]
    (line,) = lines_of_system(read_mooring_system(Source(file)))
    assert line.pieces["corners"].tolist() == [1]
    assert line.pieces["limit"].tolist() == [6e5]
    (tmp_path / "rope.dat").write_text(TABLE.replace("6e5", "1e5"))
    with pytest.raises(InputError, match=r"rope.dat: found 100000 after 200000"):
        read_mooring_system(Source(file))
