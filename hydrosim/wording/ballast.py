"""The loading condition of bodies with tanks, and plans of their pumps."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import isnan
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.presentation.document import (
    Cell,
    Document,
    Heading,
    Node,
    Outcome,
    Part,
    Sentence,
    Table,
    Value,
    Verdict,
)
from hydrosim.presentation.units import units_of
from hydrosim.scene import TankTable

if TYPE_CHECKING:
    from hydrosim.scene import Scene
    from hydrosim.studies.ballast.ballasting import PumpPlan
    from hydrosim.studies.ballast.loading import Condition, TankState

COMMON_HEEL_RAD = 2e-3
"""Heel that any body has [rad]."""
COORDINATES = ("x", "y", "z")


def ballast_document(
    scene: Scene,
    found: Sequence[Condition],
    time: float,
    angle: float | None = None,
    plan: PumpPlan | None = None,
    waiting: Sequence[str] = (),
) -> Document:
    """What bodies weigh and how they float at a ``time`` [s], with what free surfaces take at an
    ``angle`` of heel [rad]; a ``plan`` of their pumps; pumps that are ``waiting`` for events."""
    nodes: list[Node] = [*_shallow_surfaces(found)]
    nodes += [] if angle is None else _upright_walls(found, angle)
    if waiting:
        text = "These pumps wait for events and are taken as not started: {}."
        nodes.append(Verdict(Outcome.WARNING, text, [", ".join(waiting)]))
    for each in found:
        nodes += [Heading(f"{each.body.name} at {time:g} s"), *_condition(each, angle)]
    nodes += [] if plan is None else _pump_plan(plan)
    return Document(scene.title, nodes, units=units_of(scene.source))


def _condition(found: Condition, angle: float | None) -> Iterator[Node]:
    """What a body weighs and how it floats; its tanks; its mass matrix."""
    weights = (("lightship", found.lightship), ("with its tanks", found.loading))
    rows: list[list[Cell]] = [[name, _mass(x.mass), *_lengths(x.centre)] for name, x in weights]
    yield Table(("", "mass", *COORDINATES), rows)
    heave, heel, trim = found.position[2:5]
    at_rest: list[Cell] = [_length(round(heave, 4)), *(_angle(round(x, 6)) for x in (heel, trim))]
    yield Table(("", "heave", "heel", "trim"), [["at rest", *at_rest]])
    yield _metacentric(found, angle)
    head = ("tank", "level", "mass", "filled", "free to a heel", "free to a trim")
    yield Table(head, [_tank(tank) for tank in found.tanks])
    origin = np.array(found.body.centre_of_gravity)
    matrix = found.loading._replace(centre=found.loading.centre - origin).matrix
    rows = [[dof, *(_four_digits(x) for x in row)] for dof, row in zip(DOFS, matrix, strict=True)]
    title = "Mass matrix about the body's origin [kg, kg m, kg m^2]"
    yield Table(("", *DOFS), rows, title, detail=True)


def _metacentric(found: Condition, angle: float | None) -> Table:
    """Metacentric heights in heel and trim, and what free surfaces take of them."""
    head = ["", "GM", "taken by free surfaces"]
    columns = [found.metacentric, found.loss]
    if angle is not None:
        head.append(f"taken at {np.degrees(angle):g} deg of heel")
        columns.append(np.array([found.secant, np.nan]))
    rows = zip(("heel", "trim"), np.transpose([*columns, found.held]), strict=True)
    cells: list[list[Cell]] = [[of, *(_length(x) for x in row)] for of, row in rows]
    return Table([*head, "with lines and contacts"], cells, "Metacentric heights at rest")


def _tank(found: TankState) -> list[Cell]:
    reach = ("" if isnan(x) else _angle(x) for x in found.reach)
    filled = Value(found.filled, "share")
    return [found.tank.name, _length(found.level), _mass(found.mass), filled, *reach]


def _pump_plan(plan: PumpPlan) -> Iterator[Node]:
    heave, heel, trim = plan.position[0, 2:5]
    parts: list[Part] = [Value(plan.within, "s", 6), _length(heave), _angle(heel), _angle(trim)]
    yield Heading("Plan of the pumps")
    yield Sentence("After {} the body is at rest at heave {}, heel {}, trim {}.", parts)
    runs = zip(plan.pumps, plan.rate, plan.mass, strict=True)
    rows: list[list[Cell]] = [
        [name, Value(rate, "kg/s", 5), _mass(mass)] for name, rate, mass in runs
    ]
    yield Table(("pump", "rate", "mass"), rows)


def _shallow_surfaces(found: Sequence[Condition]) -> Iterator[Node]:
    """Free surfaces that meet bottom or top at once: GM is another beyond."""
    for each in found:
        for tank in each.tanks:
            if 0.0 < tank.reach[0] < COMMON_HEEL_RAD:
                yield Verdict(
                    Outcome.WARNING,
                    "{}: its surface meets bottom or top at {} of heel. GM is the slope at rest. At"
                    " a larger heel the free surface takes less: see --heel.",
                    [_key(each, tank), _angle(tank.reach[0], 2)],
                )


def _upright_walls(found: Sequence[Condition], angle: float) -> Iterator[Node]:
    """Tables, whose walls are upright also where the surface meets bottom or top."""
    for each in found:
        for tank in each.tanks:
            if isinstance(tank.tank.shape, TankTable) and abs(angle) > tank.reach[0]:
                yield Verdict(
                    Outcome.WARNING,
                    "{}: a table has upright walls at every heel, but its surface meets bottom or"
                    " top at {}. It takes less than is printed. Give it as a box or a mesh.",
                    [_key(each, tank), _angle(tank.reach[0], 3)],
                )


def _key(of: Condition, tank: TankState) -> str:
    return f"bodies.{of.body.name}.tanks.{tank.tank.name}"


def _mass(value: float) -> Value:
    return Value(float(value), "kg", 6)


def _length(value: float) -> Value:
    return Value(float(value), "m")


def _lengths(values: np.ndarray) -> list[Value]:
    return [_length(value) for value in values]


def _angle(value: float, digits: int = 3) -> Value:
    return Value(float(value), "rad", digits)


def _four_digits(value: float) -> str:
    return f"{value:.4g}".replace("e+0", "e").replace("e+", "e")
