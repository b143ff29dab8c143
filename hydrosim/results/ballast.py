"""What is recorded of tanks that change: levels, masses, flows, and the bodies' mass with them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.forces import own_modes
from hydrosim.forces.ballast import tanks
from hydrosim.forces.ballast.pieces import FIRST, LEVEL
from hydrosim.forces.ballast.pumping import RUNNING
from hydrosim.forces.ballast.tanks import Tanks, flow_names, quantity, tank_names
from hydrosim.forces.modes import MODE, SEGMENT

if TYPE_CHECKING:
    from hydrosim.scene import Scene
    from hydrosim.stepping.dynamics import Model

Data = dict[str, tuple[tuple[str, ...], np.ndarray]]


def coordinates(scene: Scene) -> dict[str, object]:
    """Names of tanks and flows; nothing where there are none."""
    if not tank_names(scene):
        return {}
    return {"tank": ("tank", tank_names(scene)), "pump": ("pump", flow_names(scene))}


def recorded(model: Model, y: np.ndarray, modes: np.ndarray) -> Data:
    """By name, from the states (nt, ny) and all modes (nt, rows, 3)."""
    p: Tanks = model.elements.tanks
    if not p.each.size:
        return {}
    volume = y[:, p.state : p.state + p.each.size]
    own = own_modes(tanks, p, modes)
    running = own[:, :, MODE] == RUNNING
    mass, centre = _bodies(model, volume)
    return {
        "tank_level": (("time", "tank"), _each(p, volume, LEVEL)),
        "tank_mass": (("time", "tank"), volume * p.each["density"]),
        "pump_rate": (("time", "pump"), np.where(running, p.rates["rate"][own[:, :, SEGMENT]], 0)),
        "pump_mode": (("time", "pump"), own[:, :, MODE].astype(np.int8)),
        "mass": (("time", "body"), mass),
        "centre_of_gravity": (("time", "body", "axis"), centre),
    }


def _each(p: Tanks, volume: np.ndarray, which: int) -> np.ndarray:
    """One quantity (nt, tanks)."""
    each = [quantity(p, k, volume[:, k], which) for k in range(p.each.size)]
    return np.stack(each, axis=1)


def _bodies(model: Model, volume: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mass (nt, nb), and centre of gravity (nt, nb, 3) from the origin, in the body frame."""
    p, bodies = model.elements.tanks, model.bodies.each
    mass = np.tile(bodies["mass"], (len(volume), 1))
    moment = np.zeros((*mass.shape, 3))
    for rest in p.rests:
        mass[:, rest["body"]], moment[:, rest["body"]] = rest["mass"], rest["moment"]
    first = np.stack([_each(p, volume, FIRST + i) for i in range(3)], axis=2)
    for k, tank in enumerate(p.each):
        mass[:, tank["body"]] += tank["density"] * volume[:, k]
        moment[:, tank["body"]] += tank["density"] * first[:, k]
    return mass, moment / mass[:, :, None]
