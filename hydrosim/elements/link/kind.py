"""Kinds of links: springs, compensators, and all others, each a range of one table."""

from __future__ import annotations

from collections.abc import Hashable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from hydrosim.elements.contact.geometry import EARTH
from hydrosim.elements.kind import (
    ChartHint,
    Columns,
    KindConstants,
    KindWithModeSets,
    LinearResistance,
    ModeRows,
    ModeSet,
    StateBlocks,
    Topic,
    UnitRecord,
    Variable,
    capacity_of,
    elements_of,
    rest_at_first,
    with_mode_of_unit,
)
from hydrosim.elements.link import coordinate
from hydrosim.elements.link.gas import PULLING
from hydrosim.elements.link.law import POWER_OUTPUT
from hydrosim.elements.link.laws import ELASTIC, LAWS, LinkConstants
from hydrosim.elements.link.table import (
    COMPENSATORS,
    OTHERS,
    SPRINGS,
    compile_elements,
)
from hydrosim.elements.link.tension import SLACK, TAUT
from hydrosim.modes import ACTING, MODE, MODE_COLUMNS, SEGMENT, UNDEFINED
from hydrosim.scene import Scene
from hydrosim.scene.links import Compensator, CoordinateElement, Link, Spring, Strut

OTHER_LINKS = tuple(kind for kind in LAWS if kind not in (Spring, Compensator))
"""The classes of links of `LinkKind`."""


@dataclass(frozen=True)
class TableKind(KindWithModeSets):
    """The kind of one ``family`` of links, whose constants are a range of the table. Its units are
    idle in ``idle_mode``, and at their stiffest in ``stiff_mode``, as their texts say; each of them
    ``alone`` too, said so in words, unless these are empty."""

    idle_text: ClassVar[str]
    stiff_text: ClassVar[str]
    alone: ClassVar[str] = ""
    family: int
    idle_mode: int = ACTING
    stiff_mode: int = ACTING

    def constants_in(self, parts: KindConstants) -> LinkConstants:
        p: LinkConstants = parts.elements.link_table
        first, last = np.searchsorted(p.links["family"], [self.family, self.family + 1])
        return p._replace(links=p.links[first:last], mode=p.mode + int(first))

    def replaced_in(self, elements: Any, p: LinkConstants) -> Any:
        table = elements.link_table
        links = table.links.copy()
        first, last = np.searchsorted(links["family"], [self.family, self.family + 1])
        links[first:last] = p.links
        indices = {"state": p.state, "mode": p.mode - int(first), "losses": p.losses}
        return elements._replace(link_table=table._replace(links=links, **indices))

    def modes(self, p: LinkConstants) -> ModeRows:
        first, last, slope = p.links["first"], p.links["last"], p.links["steepest"]
        rising = "half_turns" if self.family == OTHERS else ""
        return ModeRows(len(p.links), rising=rising, first=first, last=last, steepest=slope)

    def record(self, p: LinkConstants, bodies: Any, unit_record: UnitRecord) -> Columns:
        modes = unit_record.modes[:, :, MODE].astype(np.int8)
        columns_by_name: Columns = {f"{self.unit}_mode": (("time", self.unit), modes)}
        for k, (_, declared) in enumerate(LAWS.values()):
            units = p.links["element"] == k
            for name, column in declared.columns.items() if units.any() else ():
                values = unit_record.observed[:, units, column.output]
                columns_by_name[name] = (("time", declared.dimension), values)
        return columns_by_name

    def coordinates(self, scene: Scene) -> dict[str, object]:
        return super().coordinates(scene) | capacity_of(self.unit, elements_of(scene, self.classes))

    def mode_sets(self, p: LinkConstants) -> Sequence[ModeSet]:
        """All on the piece of their law without load, and on their stiffest."""
        if not p.links.size:
            return []
        sets = [ModeSet(self.idle_text, rest_at_first(p.links["idle"], self.idle_mode))]
        differ = self.idle_mode != self.stiff_mode or np.any(p.links["stiff"] != p.links["idle"])
        if differ:
            stiff = rest_at_first(p.links["stiff"], self.stiff_mode)
            sets.append(ModeSet(self.stiff_text, stiff))
        return sets

    def one_unit_active(
        self, p: LinkConstants, names: Sequence[str], which: Sequence[int]
    ) -> Iterator[ModeSet]:
        if not self.alone:
            return
        idle = rest_at_first(p.links["idle"], self.idle_mode)
        stiff = rest_at_first(p.links["stiff"], self.stiff_mode)
        for i in which if p.links.size > 1 else ():
            yield ModeSet(f"{names[i]} {self.alone}", with_mode_of_unit(idle, stiff, i))

    def equivalence_keys(self, p: LinkConstants) -> Sequence[Hashable]:
        """No two links are alike: each acts in a direction of its own."""
        return range(p.links.size) if self.alone else ()

    def rates(self, p: LinkConstants, bodies: Any, motion: Any) -> np.ndarray:
        """Along the coordinates."""
        if not self.alone:
            return super().rates(p, bodies, motion)
        y = np.zeros(0)
        rates = [link_kinematics(p, i, y, motion, bodies).rate for i in range(p.links.size)]
        return np.reshape(rates, (-1, 1))

    def moved_onto_segment(
        self, p: LinkConstants, modes: np.ndarray, bodies: Any, motion: Any, y: np.ndarray
    ) -> LinkConstants:
        """Constants in which each link is on its piece, at an offset where it is linearised."""
        links = p.links.copy()
        for i, link in enumerate(links):
            posture = "stiff" if modes[i, SEGMENT] == link["stiff"] else "idle"
            s = link_kinematics(p, i, y, motion, bodies)
            x = np.clip(s.x, *link[f"{posture}_range"])
            if x != s.x:
                link["neutral"] = s.place - x
                link["varies"] = False
        return p._replace(links=links)


def variables_of(*classes: type[Link]) -> dict[str, Variable]:
    """The variables of these classes of links."""
    columns = {name: column for kind in classes for name, column in LAWS[kind][1].columns.items()}
    return {name: column.variable for name, column in columns.items()}


def link_kinematics(
    p: LinkConstants, i: int, y: np.ndarray, motion: Any, bodies: Any
) -> coordinate.LinkKinematics:
    """State of link ``i`` at the time 0, its twist within half a turn."""
    mode = np.zeros(MODE_COLUMNS, dtype=np.int64)
    return coordinate.LinkKinematics(
        *coordinate.find_kinematics(p.links[i], mode, 0.0, y, motion, bodies, p)
    )


class SpringKind(TableKind):
    unit = "spring"
    idle_text = "springs slack"
    stiff_text = "springs taut"
    alone = "alone taut"
    variables: ClassVar = {
        **variables_of(Spring),
        "spring_mode": Variable("slack (no tension) or taut", "1", flags="slack taut absent"),
        "spring_segment": Variable("piece of the curve, 0 if slack", "1"),
    }


class CompensatorKind(TableKind):
    unit = "compensator"
    idle_text = "compensators in their stroke"
    stiff_text = "compensators on their stops"
    alone = "alone on its stop"
    variables: ClassVar = {
        **variables_of(Compensator),
        "compensator_mode": Variable(
            "pulling, or cut by its damping", "1", flags="pulling cut absent"
        ),
        "compensator_segment": Variable("slack, lower stop, gas, upper stop", "1"),
    }


def _unit_coordinates(scene: Scene) -> Iterator[tuple[str, object]]:
    """Coordinates with units, of variables of links that act along a line or about an axis."""
    for kind in OTHER_LINKS:
        links = [of for _, of in elements_of(scene, kind) if isinstance(of, CoordinateElement)]
        for name, column in LAWS[kind][1].columns.items() if links else ():
            along, about = column.variable.units.split(" or ")
            units = [about if of.turns(scene.joints) else along for of in links]
            attributes = {"long_name": f"unit of {name}"}
            yield f"{name}_unit", (LAWS[kind][1].dimension, units, attributes)


class LinkKind(TableKind):
    unit = "link"
    idle_text = ""
    stiff_text = "links on their steepest pieces"
    variables: ClassVar = {
        **variables_of(*OTHER_LINKS),
        "pto_power": Variable(
            "power absorbed by a power take-off",
            "W",
            chart=ChartHint("Power of power take-offs", "absorbed power", Topic.LINKS + 4),
        ),
        "link_mode": Variable("whether a link acts", "1", flags="acting absent"),
        "link_segment": Variable("piece of the curve", "1"),
        "link_half_turns": Variable("half turns of the twist", "1"),
    }

    def states(self, p: LinkConstants, scene: Scene) -> Iterator[StateBlocks]:
        for name, link in elements_of(scene, self.classes):
            assert isinstance(link, Link)
            if state_names := LAWS[type(link)][1].state_names:
                yield StateBlocks(self.unit, [name], state_names)

    def coupled_states(self, p: LinkConstants) -> np.ndarray:
        count = int(p.links["states"].sum())
        return np.arange(p.state, p.state + count, dtype=np.int64)

    def resistances(self, p: LinkConstants) -> Iterator[LinearResistance]:
        """Damping of each torsion spring with small angles; struts are never linear."""
        for link in p.links[
            (p.links["coordinate"] == coordinate.TWIST) & (p.links["law"] == ELASTIC)
        ]:
            axis = link["axes"][:3]
            J = np.array([0.0, 0.0, 0.0, *axis])
            if link["other"] != EARTH:
                J = np.concatenate([J, -J])
            B = link["damping"] * np.outer(J, J)
            yield LinearResistance(
                link["row"], link["body"], B, np.zeros(len(B)), other=link["other"]
            )

    def undefined_units(self, p: LinkConstants, modes: np.ndarray) -> Iterator[tuple[int, str]]:
        reasons = {
            coordinate.DISTANCE: "its ends meet (closer than 1 % of its length), where it has no"
            " direction",
            coordinate.TWIST: "its axis has swung to the opposite, where its twist is not defined",
        }
        for i in np.flatnonzero(modes[:, MODE] == UNDEFINED).tolist():
            yield i, reasons[int(p.links[i]["coordinate"])]

    def coordinates(self, scene: Scene) -> dict[str, object]:
        links = elements_of(scene, self.classes)
        struts = elements_of(scene, Strut)
        named = {
            "link": links,
            **{LAWS[kind][1].dimension: elements_of(scene, kind) for kind in OTHER_LINKS},
            "pto": [(n, e) for n, e in links if getattr(e, "absorbs", False)],
        }
        coordinates_by_dim: dict[str, object] = {
            d: (d, [n for n, _ in units]) for d, units in named.items() if units
        }
        units = dict(_unit_coordinates(scene))
        return coordinates_by_dim | units | capacity_of("strut", struts)

    def record(self, p: LinkConstants, bodies: Any, unit_record: UnitRecord) -> Columns:
        columns = super().record(p, bodies, unit_record)
        if p.links["absorbs"].any():
            power = unit_record.observed[:, p.links["absorbs"], POWER_OUTPUT]
            columns["pto_power"] = (("time", "pto"), power)
        return columns


SPRING_KIND = SpringKind("link_table", (Spring,), compile_elements, SPRINGS, SLACK, TAUT)
COMPENSATOR_KIND = CompensatorKind(
    "link_table", (Compensator,), compile_elements, COMPENSATORS, PULLING, PULLING
)
LINK_KIND = LinkKind("link_table", OTHER_LINKS, compile_elements, OTHERS)
