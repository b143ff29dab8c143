"""From the record of a run to an xarray dataset, and to netCDF.

Dimensions: time, body, dof, fender (contact points), spring, probe, axis. Wrenches are (force,
moment about the centre of gravity) in the earth frame. The ledger: `energy_kinetic` and
`energy_stored_*` are what the system holds, `energy_work_*` what was put in, `energy_dissipated_*`
what was lost, all since the start; `energy_residual` is holdings minus start minus work plus
losses, zero but for the error of the time integration. A run that starts from another counts on
from there; its residual is its own, zero where it begins.

The whole state y is in `state_value` (state_time, state) by name, for a start from there
(`hydrosim.compiling.restart`): at the end, or at every output time if the scene says so.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from math import prod

import numpy as np
import xarray as xr

from hydrosim.dofs import DOFS
from hydrosim.forces import Contact, Spring, own_modes, spring, trigger
from hydrosim.forces.ballast import tanks
from hydrosim.forces.contact import fender, guide, loop
from hydrosim.forces.contact.fender import (
    COMPRESSION,
    DAMPED,
    FRICTION,
    LOST,
    NODE,
    NORMAL_FORCE,
    SLIP_DAMPED,
    SLIP_DISTANCE,
    STATES,
)
from hydrosim.forces.modes import MODE, OPEN, RISING, SEGMENT
from hydrosim.forces.spring import LENGTH, TENSION
from hydrosim.radiation import VelocityHistory, input_rates
from hydrosim.results import ballast, impulses, memory, points
from hydrosim.results.assembled import assembled
from hydrosim.results.ledger import guard
from hydrosim.results.phases import group_phases
from hydrosim.results.stages import staged
from hydrosim.results.variables import EARTH, describe
from hydrosim.scene import Scene
from hydrosim.stepping.blending import STATES as STATES_OF_DRAUGHT
from hydrosim.stepping.dynamics import Model
from hydrosim.stepping.names import (
    capacities,
    contact_groups,
    fender_names,
    force_names,
    guide_names,
    loses,
    spring_names,
    stores,
    supplies,
    trigger_names,
)
from hydrosim.stepping.record import channels
from hydrosim.stepping.state import Record
from hydrosim.stepping.state_layout import Kind, state_layout
from hydrosim.waves import Components, elevations

MOTION, POINT = ("time", "body", "dof"), ("time", "fender", "axis")
Columns = dict[str, tuple[tuple[str, ...], np.ndarray]]
"""Of variables by name the dimensions and the values."""


def to_dataset(
    scene: Scene,
    model: Model,
    sea: Sequence[Components],
    record: Record,
    count: int,
    history: VelocityHistory,
    attributes: Mapping[str, object],
) -> xr.Dataset:
    """The first ``count`` records as a dataset with ``attributes``, the waves of the ``sea`` at the
    probes, and the velocity ``history`` at the end."""
    values = unpack(model, record, count)
    time = values["time"]
    data: Columns = {
        "position": (MOTION, _by_body(values["coordinates"])),
        "velocity": (MOTION, _by_body(values["velocity"])),
        "reference_position": (("body", "axis"), model.bodies.each["origin"]),
        "wave_elevation": (("time",), values["elevation"]),
    }
    if record.accelerations.size:
        data["acceleration"] = (MOTION, _by_body(record.accelerations[:count]))
    for row, name in enumerate(force_names(scene)):
        data[f"force_{name}"] = (MOTION, _by_body(values["wrench"][:, row]))
    data.update(_draughts(model, values["y"]))
    points, modes = _contact_states(model, values["y"]), record.modes[:count]
    own = own_modes(fender, model.elements.fenders, modes)
    data.update(_fenders(time, values["fenders"], own, points, contact_groups(scene)))
    data.update(_closings(model.elements.fenders, values["y"]))
    data.update(_springs(values["springs"], own_modes(spring, model.elements.springs, modes)))
    data.update(ballast.recorded(model, values["y"], modes))
    data.update(_guides(values["guides"], own_modes(guide, model.elements.guides, modes)))
    acting = own_modes(trigger, model.elements.triggers, modes)[:, :, MODE].astype(np.int8)
    data.update({"trigger_stage": (("time", "trigger"), acting)} if acting.shape[1] else {})
    data.update(impulses.recorded(scene, model, values))
    data.update(_probes(scene, sea, time))
    data.update(_points(scene, model, values["coordinates"]))
    data.update({name: (("time",), e) for name, e in _ledger(scene, model, values).items()})
    states, of_states = _states(scene, model, values, modes)
    memories, of_memory = memory.packed(scene, model, history)
    coords = {**_coordinates(scene, time), **of_states, **of_memory}
    dataset = assembled({**data, **states, **memories}, coords)
    describe(dataset)
    dataset = staged(dataset, model.elements.fenders, values["y"])
    dataset.attrs.update({k: v for k, v in attributes.items() if v is not None})
    guard(dataset, sum(body.mass for body in scene.bodies if body.dofs))
    return dataset


def unpack(model: Model, record: Record, count: int, first: int = 0) -> dict[str, np.ndarray]:
    """Channels by name, (count - first, ...) each, of the records ``first`` to ``count``."""
    kept = record.channels[first:count]
    values = {}
    at = 0
    for name, shape in channels(model).items():
        width = prod(shape)
        values[name] = kept[:, at : at + width].reshape(len(kept), *shape)
        at += width
    return values


def _by_body(flat: np.ndarray) -> np.ndarray:
    return flat.reshape(len(flat), -1, 6)


def _states(
    scene: Scene, model: Model, values: dict[str, np.ndarray], modes: np.ndarray
) -> tuple[Columns, dict[str, object]]:
    """What a run can start from, at the end or at every output time, and its coordinates."""
    kept = slice(None) if scene.output_states else slice(-1, None)
    layout = state_layout(scene, model)
    of_memory = (q for entry in layout.of(Kind.RADIATION) for q in entry.coordinates)
    remembered = dict.fromkeys(q.name for q in of_memory)
    rates = np.zeros(model.size)
    rates[model.radiation :][: model.states.decay.size] = input_rates(model.states)
    coords: dict[str, object] = {
        "state_time": ("state_time", values["time"][kept], {"units": "s", "long_name": "time"}),
        "state": ("state", layout.names(), {"long_name": "name of the state"}),
        "state_kind": ("state", layout.kinds(), {"long_name": "kind of the state"}),
        "state_owner": ("state", layout.owners(), {"long_name": "body, unit or row of the state"}),
        **({"radiation_dof": ("radiation_dof", [*remembered])} if remembered else {}),
        "state_component": ("state", layout.components(), {"long_name": "what the state is of it"}),
    }
    states: Columns = {
        "state_value": (("state_time", "state"), values["y"][kept]),
        "state_input": (("state",), rates),
    }
    points, lines = model.elements.fenders.points, model.elements.springs.lines
    of_fenders = own_modes(fender, model.elements.fenders, modes[kept])
    of_springs = own_modes(spring, model.elements.springs, modes[kept])
    of_flows = own_modes(tanks, model.elements.tanks, modes[kept])
    of_guides = own_modes(guide, model.elements.guides, modes[kept])
    flows, pins = model.elements.tanks.flows, model.elements.guides.pins
    kinds = (("fender", points, of_fenders), ("spring", lines, of_springs))
    for kind, each, of in (*kinds, ("pump", flows, of_flows), ("guide", pins, of_guides)):
        if each.size:
            segments = (of[:, :, SEGMENT] - each["first"]).astype(np.int16)
            states[f"{kind}_segment"] = (("state_time", kind), segments)
    if model.elements.triggers.each.size:
        waits = own_modes(trigger, model.elements.triggers, modes[kept])[:, :, RISING]
        states["trigger_waits"] = (("state_time", "trigger"), waits.astype(np.int8))
    if points.size:
        rising = of_fenders[:, :, RISING].astype(np.int8)
        states["fender_rising"] = (("state_time", "fender"), rising)
    return states, coords


def _contact_states(model: Model, y: np.ndarray) -> np.ndarray:
    """States (nt, fenders, `STATES`) of the contact points."""
    p = model.elements.fenders
    return y[:, p.state : p.state + STATES * p.points.size].reshape(len(y), -1, STATES)


def _fenders(
    time: np.ndarray,
    contact: np.ndarray,
    modes: np.ndarray,
    points: np.ndarray,
    groups: Sequence[str],
) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    if modes.shape[1] == 0:
        return {}
    open_ = modes[:, :, MODE] == OPEN
    return {
        "fender_compression": (POINT[:2], contact[:, :, COMPRESSION]),
        "fender_normal_force": (POINT[:2], np.where(open_, 0.0, contact[:, :, NORMAL_FORCE])),
        "fender_mode": (POINT[:2], modes[:, :, MODE].astype(np.int8)),
        "contact_phase": (("time", "contact_group"), group_phases(time, modes[:, :, MODE], groups)),
        "fender_friction": (POINT, contact[:, :, FRICTION:NODE]),
        "fender_node": (POINT, contact[:, :, NODE:LOST]),
        "fender_slip_distance": (POINT[:2], points[:, :, SLIP_DISTANCE]),
        "fender_dissipated": (POINT[:2], contact[:, :, LOST]),
        "fender_dissipated_damping": (POINT[:2], points[:, :, DAMPED]),
        "fender_dissipated_slip_damping": (POINT[:2], points[:, :, SLIP_DAMPED]),
    }


def _draughts(model: Model, y: np.ndarray) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Slow draughts (nt, nb) of bodies with a family of databases, not a number of others."""
    family = model.family
    if family.body.size == 0:
        return {}
    found = np.full((len(y), model.bodies.each.size), np.nan)
    filters = y[:, model.draught : model.energy]
    found[:, family.body] = family.rest - filters[:, 1::STATES_OF_DRAUGHT]
    return {"slow_draught": (MOTION[:2], found)}


def _guides(walls: np.ndarray, modes: np.ndarray) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    if modes.shape[1] == 0:
        return {}
    each = ("time", "guide")
    return {
        "guide_force": (each, walls[:, :, guide.FORCE]),
        "guide_clearance": (each, walls[:, :, guide.CLEARANCE]),
        "guide_mode": (each, modes[:, :, MODE].astype(np.int8)),
    }


def _closings(p: fender.Params, y: np.ndarray) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """What contacts remember of how they closed; not a number of those that do not."""
    if p.remembering == 0:
        return {}
    known = np.full((len(y), p.points.size, loop.STATES), np.nan)
    known[:, fender.which_remember(p)] = fender.memories(p, y)
    return {
        "fender_closings": (POINT[:2], known[:, :, loop.CLOSINGS]),
        "fender_closing_speed": (POINT[:2], known[:, :, loop.SPEED]),
        "fender_largest_force": (POINT[:2], known[:, :, loop.LARGEST]),
    }


def _springs(pulls: np.ndarray, modes: np.ndarray) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    if modes.shape[1] == 0:
        return {}
    each = ("time", "spring")
    return {
        "spring_tension": (each, pulls[:, :, TENSION]),
        "spring_length": (each, pulls[:, :, LENGTH]),
        "spring_mode": (each, modes[:, :, MODE].astype(np.int8)),
    }


def _probes(
    scene: Scene, sea: Sequence[Components], time: np.ndarray
) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Elevation at the probes: a sum over the components, for nothing in a run depends on it."""
    if not scene.wave_probes:
        return {}
    points = np.array(list(scene.wave_probes.values()))
    found = elevations(sea, points, time)
    return {"wave_elevation_at_probe": (("time", "probe"), found)}


def _points(
    scene: Scene, model: Model, coordinates: np.ndarray
) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Named points and clearances."""
    found: dict[str, tuple[tuple[str, ...], np.ndarray]] = {}
    if not (points.point_names(scene) or scene.clearances):
        return found
    frames = points.frames_of(model, coordinates)
    if points.point_names(scene):
        found["point_position"] = (("time", "point", "axis"), points.point_positions(scene, frames))
    if scene.clearances:
        found["clearance"] = (("time", "gap"), points.clearances(scene, frames))
    return found


def _ledger(scene: Scene, model: Model, values: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """All energies (nt,) and their residual."""
    integrals = values["y"][:, model.energy :]
    friction = friction_losses(scene, model, values["fenders"])
    ledger = {"energy_kinetic": values["kinetic"]}
    total = values["kinetic"].copy()
    for row, name in enumerate(force_names(scene)):
        if stores(scene, row):
            ledger[f"energy_stored_{name}"] = values["stored"][:, row]
            total += values["stored"][:, row]
        if supplies(scene, row):
            ledger[f"energy_work_{name}"] = integrals[:, row]
            total -= integrals[:, row]
        elif loses(scene, row):
            lost = integrals[:, row] + friction.get(name, 0.0)
            ledger[f"energy_dissipated_{name}"] = lost
            total += lost
    ledger["energy_wave_absolute"] = integrals[:, model.rows]
    ledger["energy_residual"] = total - total[0] if total.size else total
    return ledger


def friction_losses(scene: Scene, model: Model, contact: np.ndarray) -> dict[str, np.ndarray]:
    """Energy lost in friction (nt,) by fender element."""
    rows = model.elements.fenders.points["row"]
    return {
        name: contact[:, rows == row, LOST].sum(axis=1)
        for row, name in enumerate(force_names(scene))
        if np.any(rows == row)
    }


def _coordinates(scene: Scene, time: np.ndarray) -> dict[str, object]:
    along_time = ("time", time, {"units": "s", "long_name": "time since the start"})
    return {"time": along_time, **fixed_coordinates(scene)}


def fixed_coordinates(scene: Scene) -> dict[str, object]:
    """Names of bodies, contacts, springs, points and what goes with them: a run of the scene has
    them whatever happens."""
    return {
        "body": ("body", [b.name for b in scene.bodies], {"long_name": "body"}),
        "dof": ("dof", list(DOFS), {"long_name": "degree of freedom"}),
        "axis": ("axis", ["x", "y", "z"], {"long_name": "axis of the frame"}),
        **_fender_coordinates(scene),
        **({"spring": ("spring", names)} if (names := spring_names(scene)) else {}),
        **_capacities(scene),
        **ballast.coordinates(scene),
        **impulses.coordinates(scene),
        **({"guide": ("guide", names)} if (names := guide_names(scene)) else {}),
        **({"trigger": ("trigger", names)} if (names := trigger_names(scene)) else {}),
        **(_probe_places(scene) if scene.wave_probes else {}),
        **({"point": ("point", names)} if (names := points.point_names(scene)) else {}),
        **({"gap": ("gap", list(scene.clearances))} if scene.clearances else {}),
    }


def _probe_places(scene: Scene) -> dict[str, object]:
    x, y = np.array(list(scene.wave_probes.values())).T
    place = {"units": "m", "long_name": "place of the probe", "frame": EARTH}
    return {
        "probe": ("probe", list(scene.wave_probes)),
        "probe_x": ("probe", x, place),
        "probe_y": ("probe", y, place),
    }


def _fender_coordinates(scene: Scene) -> dict[str, object]:
    """Names of contact points, the element that each belongs to, and those elements."""
    groups = contact_groups(scene)
    if not groups:
        return {}
    said = {"long_name": "element of contact points, whose phases are told together"}
    return {
        "fender": ("fender", fender_names(scene)),
        "fender_group": ("fender", groups, said),
        "contact_group": ("contact_group", [*dict.fromkeys(groups)], said),
    }


def _capacities(scene: Scene) -> dict[str, object]:
    """Capacities of contact points and of springs, if any are said."""
    said = {"long_name": "capacity: what the unit may carry", "units": "N"}
    each = {dim: capacities(scene, kind) for dim, kind in (("fender", Contact), ("spring", Spring))}
    known = {dim: values for dim, values in each.items() if np.isfinite(values).any()}
    return {f"{dim}_capacity": (dim, values, said) for dim, values in known.items()}
