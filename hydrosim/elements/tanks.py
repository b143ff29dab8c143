"""Tanks that change as a kind: volumes, modes of flows, and the variables of both."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

import numpy as np

from hydrosim.elements import kind
from hydrosim.modes import MODE, SEGMENT
from hydrosim.scene import Scene
from hydrosim.tanks import contents
from hydrosim.tanks.pumping import PUMP_RUNNING
from hydrosim.tanks.surface import FLUID_LEVEL


class TankFlowKind(kind.UnitKind):
    unit = "pump"
    variables: ClassVar = {
        "tank_level": kind.Variable(
            "level above the bottom of the tank",
            "m",
            "tank",
            chart=kind.ChartHint("Levels of tanks", "level", kind.Topic.CLEARANCES + 1),
            is_detail=True,
        ),
        "tank_mass": kind.Variable("mass of the fluid in the tank", "kg", is_detail=True),
        "pump_rate": kind.Variable(
            "mass per time into the target, back to the source if negative",
            "kg/s",
            chart=kind.ChartHint("Pump rates", "pumped", kind.Topic.DETAILS + 8),
            is_detail=True,
        ),
        "pump_mode": kind.Variable("mode of a flow", "1", flags="waiting running over"),
        "pump_segment": kind.Variable("piece of its rates, counted from 0", "1"),
        "mass": kind.Variable("mass including the contents of tanks", "kg", is_detail=True),
        "centre_of_gravity": kind.Variable(
            "centre of gravity from the body's origin", "m", "body", is_detail=True
        ),
    }

    def constants_in(self, parts: kind.KindConstants) -> contents.Tanks:
        return parts.tanks

    def unit_names(self, scene: Scene) -> list[str]:
        """Names of the flows."""
        return contents.flow_names(scene)

    def modes(self, p: contents.Tanks) -> kind.ModeRows:
        return kind.ModeRows(p.flows.size, first=p.flows["first"], last=p.flows["last"])

    def states(self, p: contents.Tanks, scene: Scene) -> Iterator[kind.StateBlocks]:
        yield kind.StateBlocks("tank", contents.tank_names(scene), ("volume",))

    def coordinates(self, scene: Scene) -> dict[str, object]:
        names = contents.tank_names(scene)
        return {"tank": ("tank", names), **super().coordinates(scene)} if names else {}

    def record(self, p: contents.Tanks, bodies: Any, unit_record: kind.UnitRecord) -> kind.Columns:
        volume = unit_record.y[p.state : p.state + p.each.size]
        running = unit_record.modes[:, :, MODE] == PUMP_RUNNING
        rate = p.rates["rate"][unit_record.modes[:, :, SEGMENT]]
        mass, centre = contents.mass_and_centre(p, bodies["mass"], volume)
        return {
            "tank_level": (("time", "tank"), contents.quantities(p, volume, FLUID_LEVEL)),
            "tank_mass": (("time", "tank"), volume * p.each["density"]),
            "pump_rate": (("time", "pump"), np.where(running, rate, 0)),
            "pump_mode": (("time", "pump"), unit_record.modes[:, :, MODE].astype(np.int8)),
            "mass": (("time", "body"), mass),
            "centre_of_gravity": (("time", "body", "axis"), centre),
        }

    def is_mirrored(self, p: contents.Tanks, y: np.ndarray, modes: np.ndarray) -> bool:
        return contents.is_mirrored(p, y, modes)


TANK_FLOW_KIND = TankFlowKind()
