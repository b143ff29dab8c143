"""Random cases, such as a user might write: 1 to 4 bodies afloat or dry, on fenders and lines.

A case is drawn from its seed alone, in SI units, as the mapping that a case file holds. Sizes go
together: masses with dimensions, stiffness with masses and natural periods, friction with the loads
that press, steps with the fastest rate that was built in. What is drawn is sensible, not gentle:
things touch, fall, stick and slide, and some steps are too large.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import cos, exp, hypot, log, pi, sin
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import yaml

from hydrosim.dofs import DOFS

DATABASES = Path(__file__).parents[2] / "hydro_db"
GRAVITY = 9.81
UNITS = 12  # contact points and lines, at most
STEPS = (0.2, 0.1, 0.05, 0.04, 0.025, 0.02, 0.01, 0.005, 0.002, 0.001, 0.0005)
MOST_STEPS = {"convolution": 3_000, None: 20_000}
FREE = (DOFS, DOFS, DOFS, ("surge", "heave", "pitch"), ("surge", "sway", "yaw"), ("surge", "heave"))
ASTRAY = 8  # scenes, of which one starts turned from its headings at rest
FINE = {"rk4": 1.0, "dopri5": 1.0, "esdirk4": 2.0, "rk2": 0.2, "heun": 0.2}
"""Of the step of rk4, what users take with other methods."""

T = TypeVar("T")
Case = dict[str, Any]
Place = tuple[float, float, float]


@dataclass(frozen=True)
class Hull:
    """A shipped database, and what goes with it: frame origin to bottom and top [m], the heave
    stiffness [N/m], peak periods [s] of waves for it."""

    file: str
    mass: float
    centre: Place
    radii: Place
    length: float
    beam: float
    bottom: float
    top: float
    heave: float
    periods: tuple[float, float]
    depth: str = "infinite"
    density: float = 1025.0


LAUNCH_BARGE = Hull(
    *("h851.nc", 1.56758e8, (0.0, 0.0, -4.9), (22.05, 67.6, 68.9), 260.0, 63.0),
    *(-12.4, 2.6, 1.321e8, (12.0, 16.0)),
)
BOX = Hull(
    *("box.nc", 1.025e7, (0.0, 0.0, 0.0), (7.0, 26.0, 26.0), 100.0, 20.0),
    *(-5.0, 3.0, 2.01e7, (9.0, 14.0)),
)
SPHERE = Hull(
    *("sphere.nc", 2.618e5, (0.0, 0.0, -2.0), (2.54, 2.54, 3.16), 10.0, 10.0),
    *(-5.0, 5.0, 7.7e5, (5.0, 9.0), "infinite", 1000.0),
)
SHALLOW = Hull(
    *("h851_50m.nc", 1.56758e8, (0.0, 0.0, -4.9), (22.05, 67.6, 68.9), 260.0, 63.0),
    *(-12.4, 2.6, 1.321e8, (13.5, 16.0), "50 m"),
)
PAIR = tuple(
    Hull(
        *("two_barges.nc", 1.23e6, (0.0, y, 0.0), (3.5, 10.4, 10.4), 40.0, 10.0),
        *(-3.0, 2.0, 4.0e6, (11.5, 14.0)),
    )
    for y in (7.0, -7.0)
)


@dataclass
class Form:
    """A body as far as others must know it: half its length and beam, bottom and top in its own
    frame [m]; where it is in the axes of the scene."""

    name: str
    mass: float
    half: tuple[float, float]
    bottom: float
    top: float
    at: Place
    heave: float = 0.0
    periods: tuple[float, float] = (5.0, 12.0)

    @property
    def afloat(self) -> bool:
        """Whether water carries it."""
        return self.heave > 0.0


class Draw:
    """Numbers from a seed."""

    def __init__(self, seed: int) -> None:
        self.rng = np.random.default_rng(seed)

    def between(self, low: float, high: float) -> float:
        """Evenly between two."""
        return rounded(float(self.rng.uniform(low, high)))

    def order(self, low: float, high: float) -> float:
        """Of an order of magnitude that is even between two."""
        return rounded(exp(float(self.rng.uniform(log(low), log(high)))))

    def chance(self, part: float) -> bool:
        """True in this part of all cases."""
        return bool(self.rng.uniform() < part)

    def one(self, options: Sequence[T], *weights: float) -> T:
        """One of several, all alike or by their weights."""
        chosen = np.array(weights or [1.0] * len(options))
        return options[int(self.rng.choice(len(options), p=chosen / chosen.sum()))]


@dataclass
class Sketch:
    """A case on its way: the axes of the scene are turned by ``yaw`` from the earth's, which is the
    heading of its bodies at rest, or if they start ``astray``, with small angles or not, their yaw
    at the start; ``rates`` [rad/s] are the fastest that elements bring in. If it is ``linked``, it
    has stops, gas springs, dry friction and spring-dampers along lines and about axes."""

    draw: Draw
    astray: bool = False
    linked: bool = False
    yaw: float = 0.0
    bodies: Case = field(default_factory=dict)
    forms: list[Form] = field(default_factory=list)
    forces: Case = field(default_factory=dict)
    environment: Case = field(default_factory=dict)
    rates: list[float] = field(default_factory=lambda: [2.0])
    units: int = 0

    def turned(self, x: float, y: float) -> tuple[float, float]:
        """A horizontal vector from the axes of the scene to the earth's."""
        c, s = cos(self.yaw), sin(self.yaw)
        return rounded(c * x - s * y), rounded(s * x + c * y)

    def head(self, body: Case, place: list[float]) -> None:
        """Turn a body that starts at this ``place`` (5,) with the scene."""
        yaw = self.yaw if self.astray else 0.0
        if self.yaw and not self.astray:
            body["heading"] = self.yaw
        if yaw or any(place):
            body["initial"] = {"position": [*place, yaw]}

    def add(self, kind: str, body: str, **keys: Any) -> None:
        """A force element, under a name of its own."""
        self.forces[f"{kind}_{len(self.forces) + 1}"] = {"type": kind, "body": body, **keys}


def rounded(x: float) -> float:
    """To five digits, as people write numbers."""
    return float(f"{x:.5g}")


def random_case(seed: int) -> Case:
    """The case of a seed, as a case file holds it."""
    from tests.generators.random_elements import furnish
    from tests.generators.random_links import LINKED_FROM

    draw = Draw(seed)
    sketch = Sketch(draw, astray=seed % ASTRAY == 0, linked=seed >= LINKED_FROM)
    if draw.chance(0.5):
        _afloat(sketch)
    else:
        _dry(sketch)
    furnish(sketch)
    return with_solver(sketch, seed)


def text_of(case: Case) -> str:
    """A case as the text of its file."""
    return yaml.safe_dump(case, sort_keys=False, default_flow_style=None, width=100)


def _afloat(s: Sketch) -> None:
    """Hulls side by side, and what lies on their decks."""
    d = s.draw
    first = float_hulls(s)
    on_deck = d.one((0, 1, 2), 60, 30, 10) if first is not SPHERE else 0
    for form in [f for f in s.forms if f.afloat][:on_deck]:
        mass = d.order(0.01, 0.1) * form.mass
        _block(s, mass, under=form)


def float_hulls(s: Sketch, beams_apart: float = 0.0) -> Hull:
    """Place hulls side by side in the water of their databases; the first is returned."""
    d = s.draw
    hulls = d.one(((LAUNCH_BARGE,), (BOX,), (SPHERE,), (SHALLOW,), PAIR), 30, 30, 15, 10, 15)
    if hulls is not PAIR:
        s.yaw = d.between(-pi, pi) if d.chance(0.5) else 0.0
        hulls = hulls * d.one((1, 2, 3), 70, 22, 8)
    y, gap = 0.0, d.between(0.3, 3.0)
    radiation = _radiation(d, hulls[0])
    for i, hull in enumerate(hulls):
        at = (0.0, y, hull.centre[2])
        _float_body(s, hull, i + 1, at, radiation)
        y += hull.beam + (beams_apart * hull.beam or gap)
    s.environment.update(water_depth=hulls[0].depth, water_density=hulls[0].density)
    return hulls[0]


def _radiation(d: Draw, hull: Hull) -> Any:
    memory = {"model": "state_space", "length": 160.0, "tolerance": 0.01}
    usual = memory if hull is PAIR[0] else "automatic"
    constant = {"model": "constant", "period": d.between(*hull.periods)}
    return d.one((usual, "convolution", constant, "none"), 75, 8, 10, 7)


def _float_body(s: Sketch, hull: Hull, number: int, at: Place, radiation: Any) -> None:
    d, name = s.draw, f"hull{number}"
    tilt = (d.between(-1.0, 1.0) for _ in range(2))
    small = [d.between(-0.3, 0.3), d.between(-0.3, 0.3), d.between(-0.3, 0.3)]
    angles = [rounded(angle * 0.3 / hull.length) for angle in tilt]
    body: Case = {"hydrodynamics": str(DATABASES / hull.file), "mass": hull.mass}
    body |= {"centre_of_gravity": list(hull.centre), "radii_of_gyration": list(hull.radii)}
    body |= {"radiation": radiation, "wave_forces": {"second_order": _second_order(d, hull)}}
    if hull in PAIR:
        body["database_body"] = number
        at = (0.0, hull.centre[1], hull.centre[2])
    else:
        body["location"] = list(s.turned(at[0], at[1]))
    if d.chance(0.15):
        body["dofs"] = list(d.one(FREE[3:]))
    if d.chance(0.5):
        free = set(body.get("dofs", DOFS))
        still = [x if dof in free else 0.0 for x, dof in zip([*small, *angles], DOFS, strict=False)]
        s.head(body, still)
    else:
        s.head(body, [0.0] * 5)
    s.bodies[name] = body
    depth = hull.centre[2]
    half, deep = (hull.length / 2, hull.beam / 2), (hull.bottom - depth, hull.top - depth)
    s.forms.append(Form(name, hull.mass, half, *deep, at, hull.heave, hull.periods))


def _second_order(d: Draw, hull: Hull) -> str:
    if hull in PAIR:
        return "none"
    return d.one(("none", "newman", "mean_drift", "newman_square_root"), 50, 30, 10, 10)


def _dry(s: Sketch) -> None:
    """Blocks on a floor, on each other, side by side."""
    d = s.draw
    s.yaw = d.between(-pi, pi) if d.chance(0.4) else 0.0
    mass = d.order(2e3, 2e7)
    for _ in range(d.one((1, 2, 3, 4), 45, 30, 15, 10)):
        under = s.forms[-1] if s.forms and d.chance(0.5) else None
        _block(s, mass * d.order(0.4, 1.5), under)


def _block(s: Sketch, mass: float, under: Form | None) -> None:
    """A dry block on the deck ``under`` it or in a row on the floor, perhaps falling a little."""
    d, name = s.draw, f"block{len(s.forms) + 1}"
    mass = rounded(mass)
    size = (mass / d.between(400.0, 1500.0)) ** (1.0 / 3.0)
    half = (rounded(size * d.between(0.5, 1.0)), rounded(size * d.between(0.4, 0.8)))
    height = rounded(size * d.between(0.3, 0.8))
    if under is not None:
        at = (under.at[0], under.at[1], under.at[2] + under.top + height / 2)
    else:
        row = sum(2.2 * form.half[0] for form in s.forms)
        at = (rounded(row + half[0]), 0.0, height / 2)
    sides = (hypot(half[1], height / 2) / 1.7, half[0] / 1.6, hypot(*half) / 1.7)
    radii = [rounded(r) for r in sides]
    body: Case = {"mass": mass, "centre_of_gravity": [0.0, 0.0, rounded(at[2])]}
    body |= {"location": list(s.turned(at[0], at[1])), "radii_of_gyration": radii}
    dofs = list(d.one(FREE))
    if len(dofs) < 6:
        body["dofs"] = dofs
    up = d.one((0.0, d.between(0.0, 0.1), d.between(0.1, 0.5)), 60, 25, 15)
    s.head(body, [0.0, 0.0, up if "heave" in dofs else 0.0, 0.0, 0.0])
    if d.chance(0.4):
        speed = [d.between(-1.0, 1.0) for _ in range(2)]
        free = [v if dof in dofs else 0.0 for v, dof in zip(speed, DOFS, strict=False)]
        body.setdefault("initial", {})["velocity"] = [*free, 0.0, 0.0, 0.0, 0.0]
    s.bodies[name] = body
    s.forms.append(Form(name, mass, half, rounded(-height / 2), rounded(height / 2), at))
    s.add("applied_force", name, force={"heave": rounded(-mass * GRAVITY)})


def with_solver(s: Sketch, seed: int) -> Case:
    """The whole case, with a method and a step that goes with its fastest rate."""
    d = s.draw
    method = d.one(("rk4", "dopri5", "esdirk4", "rk2", "heun"), 50, 20, 14, 8, 8)
    wanted = FINE[method] * d.order(0.06, 0.5) / max(s.rates)
    step = next((h for h in STEPS if h <= wanted), STEPS[-1])
    slow = any(body.get("radiation") == "convolution" for body in s.bodies.values())
    most = MOST_STEPS["convolution" if slow else None] * step
    duration = float(round(min(d.between(20.0, 100.0), max(most, 20.0))))
    waves = s.environment.get("waves", {})
    if waves.get("ramp", 0.0) > 0.5 * duration:
        waves["ramp"] = rounded(0.5 * duration)
    solver: Case = {"method": method, "step": step}
    if d.chance(0.15):
        solver["kinematics"] = "linear"
    if d.chance(0.2):
        solver["linear"] = "step"
    if d.chance(0.2):
        solver["symmetry"] = "ignore"
    if method == "dopri5" and d.chance(0.3):
        tolerance = d.order(1e-8, 1e-5)
        solver["tolerance"] = dict.fromkeys(("relative", "position"), tolerance)
    every = max(1, round(d.one((0.1, 0.2, 0.5)) / step))
    case = {"title": f"random case {seed}", "duration": duration, "environment": s.environment}
    case |= {"bodies": s.bodies, "forces": s.forces, "solver": solver}
    return {**case, "output": {"step": rounded(every * step)}}
