"""Dataset of a run, from its record, with impulses and works of forces.

Dimensions: time, body, dof, fender (contact points), spring, probe, axis. Wrenches are (force,
moment about the centre of gravity) in the earth frame. Energies are relative to the start:
`energy_kinetic` and `energy_stored_*` are held by the system, `energy_work_*` was put in,
`energy_dissipated_*` was lost. `energy_residual` is the energy held, minus its value at the start,
minus work, plus losses. It is zero except for the error of the time integration. A continued run
adds to the energies of the earlier run; its residual begins at zero.

The state y is in `state_value` (state_time, state) by name: at the end, or at every output time if
the scene asks for it. Another run can start from it (`hydrosim.compile.restart`).

Impulses and works of forces, as variables of a run that records them (`Scene.output.impulses`).
All are integrals since the start of the run.

`impulse` and `work` (time, force, body, dof) have a row for each force. Their sums are the changes
of `momentum` (time, body, dof) and of `energy_kinetic`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.dofs import DOFS
from hydrosim.elements import ELEMENT_KINDS, kinds_of, losses, modes_of_kind
from hydrosim.elements import kind as kinds
from hydrosim.elements.contact.kind import group_of_points, remembered_groups
from hydrosim.integrate import names
from hydrosim.integrate.draught_interpolation import DRAUGHT_STATES as STATES_OF_DRAUGHT
from hydrosim.integrate.record import states_at, unpack_channels, with_states
from hydrosim.modes import RISING, SEGMENT
from hydrosim.results import memory
from hydrosim.results.dataset import RECORDED
from hydrosim.results.ledger import check_balance
from hydrosim.results.phases import add_stage_results, group_phases
from hydrosim.results.run_data import new_run_data
from hydrosim.results.variables import EARTH_FRAME, describe, describe_values, unit_coordinates
from hydrosim.water.components import WaveComponents
from hydrosim.water.loads import elevations
from hydrosim.water.radiation import VelocityHistory, input_rates

if TYPE_CHECKING:
    import xarray as xr

    from hydrosim.integrate.dynamics import Model
    from hydrosim.integrate.state import Record
    from hydrosim.scene import Scene


def coordinates(scene: Scene) -> dict[str, object]:
    """Names of forces."""
    return {"force": ("force", list(names.force_names(scene)))} if scene.output.impulses else {}


def unit_tallies(model: Model, y: kinds.RecordedStates, units: int) -> np.ndarray:
    """Further integrals (nt, units, k) of units, from the states y."""
    forces = 2 * model.rows * 6 * model.bodies.each.size
    return y[model.impulse + forces :].reshape(len(y), units, -1)


def impulse_variables(
    scene: Scene, model: Model, values: Mapping[str, np.ndarray]
) -> dict[str, tuple[tuple[str, ...], np.ndarray]]:
    """Variables from the ``values`` (nt, ...) of a record by name."""
    if not scene.output.impulses:
        return {}
    integrals = values["y"][model.impulse :]
    count = len(integrals)
    columns = model.rows * values["momentum"].shape[1]
    forces = integrals[:, : 2 * columns].reshape(count, 2, model.rows, -1, 6)
    dims = ("time", "force", "body", "dof")
    return {
        "momentum": (("time", "body", "dof"), values["momentum"].reshape(count, -1, 6)),
        "impulse": (dims, forces[:, 0]),
        "work": (dims, forces[:, 1]),
    }


MOTION = ("time", "body", "dof")


def to_dataset(
    scene: Scene,
    model: Model,
    layout: names.StateLayout,
    sea: Sequence[WaveComponents],
    record: Record,
    count: int,
    history: VelocityHistory,
    attributes: Mapping[str, object],
) -> xr.Dataset:
    """`RunData` of the first ``count`` records with ``attributes``, the waves of the ``sea`` at the
    probes, and the velocity ``history`` at the end."""
    values = unpack_channels(model, record, count)
    time = values["time"]
    data: kinds.Columns = {
        "position": (MOTION, _reshape_by_body(values["coordinates"])),
        "velocity": (MOTION, _reshape_by_body(values["velocity"])),
        "reference_position": (("body", "axis"), model.bodies.each["origin"]),
        "wave_elevation": (("time",), values["elevation"]),
    }
    if values["wind"].size:
        data["wind_speed"] = (("time",), values["wind"][:, 0])
    if record.accelerations.size:
        data["acceleration"] = (MOTION, _reshape_by_body(record.accelerations[:count]))
    for row, name in enumerate(names.force_names(scene)):
        data[f"force_{name}"] = (MOTION, _reshape_by_body(values["wrench"][:, row]))
    data.update(_draught_columns(model, values["y"]))
    modes = record.modes[:count]
    for kind in ELEMENT_KINDS:
        p = kind.constants_in(model)
        if kind.modes(p).size or (kind.unit in values and values[kind.unit].size):
            data.update(
                kind.record(p, model.bodies.each, _unit_records(kind, p, model, values, modes))
            )
    data.update(_phase_columns(scene, time, data))
    data.update(impulse_variables(scene, model, values))
    data.update(_probe_columns(scene, sea, time))
    data.update(_point_columns(scene, model, values["coordinates"]))
    data.update({name: (("time",), e) for name, e in _ledger_values(scene, model, values).items()})
    states, of_states = _state_columns(scene, model, layout, record, count)
    memories, of_memory = memory.encode_history(scene, model, history)
    of_scene = _scene_coordinates(scene, time)
    coords = {**of_scene, **unit_coordinates(data, of_scene), **of_states, **of_memory}
    dataset = new_run_data({**data, **states, **memories}, coords)
    describe(dataset)
    dataset = add_stage_results(dataset, remembered_groups(model, values["y"]))
    dataset.attrs.update({k: v for k, v in attributes.items() if v is not None})
    if time.size:
        dataset.attrs.update(zip(RECORDED, (float(time[0]), float(time[-1])), strict=True))
    check_balance(dataset, sum(body.mass for body in scene.bodies if body.dofs))
    return dataset


def _reshape_by_body(flat: np.ndarray) -> np.ndarray:
    return flat.reshape(len(flat), -1, 6)


def _state_columns(
    scene: Scene, model: Model, layout: names.StateLayout, record: Record, count: int
) -> tuple[kinds.Columns, dict[str, object]]:
    """State that a run can start from, at every output time or at the last one that has radiation
    states, and its coordinates. That is the end, unless the run blew up and was cut off."""
    records = with_states(record, count)
    if not scene.output.states:
        records = records[-1:]
    time = unpack_channels(model, record, count)["time"][records]
    modes = record.modes[records]
    of_memory = (
        q for entry in layout.entries_of(names.StateKind.RADIATION) for q in entry.coordinates
    )
    remembered = dict.fromkeys(q.name for q in of_memory)
    rates = np.zeros(model.size)
    rates[model.radiation :][: model.states.decay.size] = input_rates(model.states)
    coords: dict[str, object] = {
        "state_time": describe_values("state_time", time, "time", "s"),
        "state": describe_values("state", layout.names(), "name of the state"),
        "state_kind": describe_values("state", layout.kinds(), "kind of the state"),
        "state_owner": describe_values("state", layout.owners(), "body, unit or row of the state"),
        **({"radiation_dof": ("radiation_dof", [*remembered])} if remembered else {}),
        "state_component": describe_values(
            "state", layout.components(), "component that the state describes"
        ),
    }
    states: kinds.Columns = {
        "state_value": (("state_time", "state"), states_at(model, record, records)),
        "state_input": (("state",), rates),
    }
    for kind, p in kinds_of(model):
        states |= _mode_columns(kind.unit, kind.modes(p), modes_of_kind(kind, p, modes))
    return states, coords


def _mode_columns(unit: str, rows: kinds.ModeRows, modes: np.ndarray) -> kinds.Columns:
    """Data of the ``modes`` (nt, n, 3) of units that a run can start from, besides the states."""
    columns: kinds.Columns = {}
    if rows.size and rows.first is not None:
        large = rows.last is not None and rows.last.max() > np.iinfo(np.int16).max
        segments = modes[:, :, SEGMENT] - rows.first
        segments = segments.astype(np.int32 if large else np.int16)
        columns[f"{unit}_segment"] = (("state_time", unit), segments)
    if rows.size and rows.rising:
        rising = modes[:, :, RISING].astype(np.int8)
        columns[f"{unit}_{rows.rising}"] = (("state_time", unit), rising)
    return columns


def _unit_records(
    kind: kinds.UnitKind, p: Any, model: Model, values: Mapping[str, Any], modes: np.ndarray
) -> kinds.UnitRecord:
    """Data of the units of a kind that are kept."""
    y = values["y"]
    rows = kind.modes(p).size
    observed = values.get(kind.unit, np.zeros((len(y), rows, 0)))
    tallied = isinstance(kind, kinds.HasImpulses) and model.impulse < model.size
    tallies = unit_tallies(model, y, rows) if tallied else np.zeros((len(y), rows, 0))
    return kinds.UnitRecord(values["time"], y, modes_of_kind(kind, p, modes), observed, tallies)


def _phase_columns(scene: Scene, time: np.ndarray, data: kinds.Columns) -> kinds.Columns:
    """Phases of the operation, from its contacts."""
    if "fender_mode" not in data:
        return {}
    _, modes = data["fender_mode"]
    phases = group_phases(time, modes, group_of_points(scene))
    return {"contact_phase": (("time", "contact_group"), phases)}


def _draught_columns(model: Model, y: kinds.RecordedStates) -> kinds.Columns:
    """Slow draughts (nt, nb) of bodies with a family of databases; NaN for other bodies."""
    family = model.family
    if family.body.size == 0:
        return {}
    draughts = np.full((len(y), model.bodies.each.size), np.nan)
    filters = y[model.draught : model.energy]
    draughts[:, family.body] = family.rest - filters[:, 1::STATES_OF_DRAUGHT]
    return {"slow_draught": (MOTION[:2], draughts)}


def _probe_columns(scene: Scene, sea: Sequence[WaveComponents], time: np.ndarray) -> kinds.Columns:
    """Elevation at the probes: a sum over the components, computed afterwards because no motion
    depends on it."""
    if not scene.output.wave_probes:
        return {}
    points = np.array(list(scene.output.wave_probes.values()))
    elevation = elevations(sea, points, time)
    return {"wave_elevation_at_probe": (("time", "probe"), elevation)}


def _point_columns(scene: Scene, model: Model, coordinates: np.ndarray) -> kinds.Columns:
    """Named points and clearances."""
    columns: kinds.Columns = {}
    if not (memory.point_names(scene) or scene.output.clearances):
        return columns
    frames = memory.frames_of(model, coordinates)
    if memory.point_names(scene):
        columns["point_position"] = (
            ("time", "point", "axis"),
            memory.point_positions(scene, frames),
        )
    if scene.output.clearances:
        columns["clearance"] = (("time", "gap"), memory.clearances(scene, frames))
    return columns


def _ledger_values(
    scene: Scene, model: Model, values: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """All energies (nt,) and their residual."""
    integrals = values["y"][model.energy :]
    besides = losses(model, values)
    ledger = {"energy_kinetic": values["kinetic"]}
    total = values["kinetic"].copy()
    for row, name in enumerate(names.force_names(scene)):
        if names.may_store_energy(scene, row):
            ledger[f"energy_stored_{name}"] = values["stored"][:, row]
            total += values["stored"][:, row]
        if names.is_work_row(scene, row):
            ledger[f"energy_work_{name}"] = integrals[:, row]
            total -= integrals[:, row]
        elif names.may_dissipate(scene, row):
            lost = integrals[:, row] + besides.get(row, 0.0)
            ledger[f"energy_dissipated_{name}"] = lost
            total += lost
    ledger["energy_wave_absolute"] = integrals[:, model.rows]
    ledger["energy_residual"] = total - total[0] if total.size else total
    return ledger


def _scene_coordinates(scene: Scene, time: np.ndarray) -> dict[str, object]:
    along_time = describe_values("time", time, "time since the start", "s")
    return {"time": along_time, **fixed_coordinates(scene)}


def fixed_coordinates(scene: Scene) -> dict[str, object]:
    """Coordinates of the bodies, contacts, springs and points of a scene. Every run of the scene
    has them."""
    return {
        "body": describe_values("body", [b.name for b in scene.bodies], "body"),
        "dof": describe_values("dof", list(DOFS), "degree of freedom"),
        "axis": describe_values("axis", ["x", "y", "z"], "axis of the frame"),
        **{name: of for kind in ELEMENT_KINDS for name, of in kind.coordinates(scene).items()},
        **coordinates(scene),
        **(_probe_places(scene) if scene.output.wave_probes else {}),
        **memory.coordinates(scene),
        **({"gap": ("gap", list(scene.output.clearances))} if scene.output.clearances else {}),
    }


def _probe_places(scene: Scene) -> dict[str, object]:
    x, y = np.array(list(scene.output.wave_probes.values())).T
    place = {"units": "m", "long_name": "position of the probe", "frame": EARTH_FRAME}
    return {
        "probe": ("probe", list(scene.output.wave_probes)),
        "probe_x": ("probe", x, place),
        "probe_y": ("probe", y, place),
    }
