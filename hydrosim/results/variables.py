"""Variables of a run: their long names, units and frames, and the meanings of modes.

If degrees of freedom have different units, `dof_units` replaces `units`, and a coordinate such as
`force_unit` (dof) holds the same beside the values. Variables of no interest but for a restart have
the attribute `purpose: restart`, and a group `restart` in the file of a run.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.elements import ELEMENT_KINDS
from hydrosim.elements.kind import ChartHint, SummaryColumn, Topic, Variable
from hydrosim.files.series import unit_of
from hydrosim.results.dataset import PURPOSE, RESTART
from hydrosim.results.phases import LOAD_TEXT, Phase

if TYPE_CHECKING:
    import xarray as xr

EARTH_FRAME = "earth"
HEADING = "axes that turn with the yaw of the body"
MIXED = "SI"  # for numbers with different units
OF_CHANNEL = "unit of the channel"  # for numbers of channels
UNIT_COMMENTS = {
    MIXED: "each number in SI, angles in rad",
    OF_CHANNEL: "each in the unit of its channel",
}
RUN_VARIABLES = {  # a name that ends in "_" is a prefix
    "position": Variable(
        "displacement of the centre of gravity from rest; angles", "m or rad", EARTH_FRAME
    ),
    "velocity": Variable(
        "velocity of the centre of gravity; angular velocity", "m/s or rad/s", EARTH_FRAME
    ),
    "acceleration": Variable(
        "acceleration of the centre of gravity; angular acceleration",
        "m/s^2 or rad/s^2",
        EARTH_FRAME,
    ),
    "momentum": Variable("momentum of body and added mass", "N s or N m s", EARTH_FRAME),
    "impulse": Variable(
        "time integral of a force and of its moment since the start", "N s or N m s", EARTH_FRAME
    ),
    "work": Variable("work of a force by degree of freedom since the start", "J", EARTH_FRAME),
    "position_error": Variable(
        "largest error of a motion over the run, by a companion run; of angles about axes that"
        " turn with the yaw of the body",
        "m or rad",
        HEADING,
    ),
    "reference_position": Variable("position of the centre of gravity at rest", "m", EARTH_FRAME),
    "slow_draught": Variable(
        "slow draught, at which the coefficients of a family are taken",
        "m",
        chart=ChartHint("Slow draught", "slow draught", Topic.CLEARANCES + 2),
    ),
    "wave_elevation": Variable(
        "undisturbed wave elevation at the origin",
        "m",
        EARTH_FRAME,
        chart=ChartHint("Wave elevation at the origin", "wave elevation", Topic.WATER),
    ),
    "wind_speed": Variable(
        "speed of the wind at 10 m, with gusts",
        "m/s",
        EARTH_FRAME,
        chart=ChartHint("Wind speed at 10 m", "wind speed", Topic.WATER),
    ),
    "wave_elevation_at_probe": Variable(
        "undisturbed wave elevation at a probe",
        "m",
        EARTH_FRAME,
        chart=ChartHint("Waves at probes", "wave elevation", Topic.DETAILS + 9),
    ),
    "force_": Variable("force; moment about the centre of gravity", "N or N m", EARTH_FRAME),
    "contact_phase": Variable(
        "phase of the operation, from the contacts of a group",
        "1",
        flags=" ".join(phase.name.lower() for phase in Phase),
    ),
    "point_position": Variable("position of a named point", "m", EARTH_FRAME),
    "clearance": Variable(
        "clearance of a named point",
        "m",
        chart=ChartHint("Clearances", "clearance", Topic.CLEARANCES),
        summary=[SummaryColumn(figure, figure) for figure in ("smallest", "at the end")],
        row_label="clearance",
    ),
    "contact_load": Variable(
        LOAD_TEXT, "N", chart=ChartHint("Load of groups of contacts", "load", Topic.DETAILS)
    ),
    "energy_kinetic": Variable("kinetic energy, with added mass", "J"),
    "energy_stored_": Variable("stored energy", "J"),
    "energy_work_": Variable("work done on the bodies since the start", "J"),
    "energy_dissipated_": Variable("energy lost since the start", "J"),
    "energy_wave_absolute": Variable("integral of |wave power| since the start", "J"),
    "energy_residual": Variable("residual of the energy balance", "J"),
    "state_value": Variable("state that a run can start from", MIXED, "unit of each state"),
    "state_input": Variable("rate of a radiation state for unit velocities", MIXED, "body"),
    "memory_past": Variable("velocity history of a convolution, and its integrals", MIXED, HEADING),
    "memory_node": Variable(
        "velocity history at the last step but one, with the acceleration", MIXED, HEADING
    ),
}
LABELS = {  # names of coordinates, with what their labels name
    "axis": "axis of the frame",
    "band": "band of frequencies",
    "channel": "channel of the run",
    "column": "column of the recording",
    "direction": "axis of the frame",
    "dof": "degree of freedom",
    "extreme": "most probable extreme of a run and its interval; extreme of another run",
    "fender": "contact point",
    "gap": "clearance",
    "lock": "joint that comes and goes",
    "mode": "contact mode",
    "part": "cause of a part of friction",
    "phase": "phase of an operation",
    "point": "named point of a body",
    "probe": "wave probe",
    "pto": "power take-off",
    "recorded_in": "unit of the recording",
    "radiation_dof": "coordinate whose motion radiates waves",
    "side": "side of an extreme",
    "span": "stage of the run",
    "stage": "stage of an operation",
    "statistic": "statistic of a channel",
    "trigger": "element or pump with a condition",
    "unit": "unit of the channel",
    "units": "unit of the channel",
}
"""What labels of coordinates name. Of others it is the name of the coordinate."""
UNITS_BY_DOF = {
    "m or rad": "position_unit",
    "m/s or rad/s": "velocity_unit",
    "m/s^2 or rad/s^2": "acceleration_unit",
    "N or N m": "force_unit",
    "N s or N m s": "impulse_unit",
}
"""Coordinates with the units of the six degrees of freedom."""
RESTART_PREFIXES = ("state", "memory_", "radiation_dof")
"""Beginnings of the names of dimensions and coordinates that only serve to continue a run."""
ELEMENT_VARIABLES: dict[str, Variable] = {
    name: variable for kind in ELEMENT_KINDS for name, variable in kind.variables.items()
}
VARIABLES = RUN_VARIABLES | ELEMENT_VARIABLES
BY_RANK = dict(sorted(VARIABLES.items(), key=lambda item: item[1].chart.rank))
"""All variables, in the order of their charts and tables."""
LOADS = {
    next(kind.unit for kind in ELEMENT_KINDS if name in kind.variables): name
    for name, variable in BY_RANK.items()
    if variable.is_load and variable.lowest == 0.0
}
"""Loads of contacts and lines by the dimension of their units: contacts only push, lines only
pull."""
TENSIONS = {
    unit: name for unit, name in LOADS.items() if VARIABLES[name].chart.rank >= Topic.TENSIONS
}
"""Those of them that are tensions."""


def units_of(units: str) -> dict[str, str]:
    """The common unit, none of texts; or units of the six degrees of freedom; or a note that each
    number has its own."""
    if " or " in units:
        return {"dof_units": ", ".join(_units_by_dof(units))}
    if units in UNIT_COMMENTS:
        return {"comment": UNIT_COMMENTS[units]}
    return {"units": units} if units else {}


def quantity_attributes(long_name: str, units: str = "") -> dict[str, str]:
    """Attributes of a variable, with `units_of` its ``units``. Several units stand in its name,
    for labels of plots."""
    name = f"{long_name} [{units}]" if " or " in units else long_name
    return {"long_name": name, **units_of(units)}


def describe_values(
    dims: str | Sequence[str], values: Any, long_name: str, units: str = ""
) -> tuple[Any, ...]:
    """Variable for a dataset, with `quantity_attributes`."""
    return dims, values, quantity_attributes(long_name, units)


def unit_coordinates(
    data: Mapping[str, tuple[tuple[str, ...], Any]], coords: Mapping[str, Any]
) -> dict[str, object]:
    """Coordinates with units, of ``data`` whose degrees of freedom, joint motions or drives have
    different ones; ``coords`` has the labels of these, and such units of links."""
    coordinates: dict[str, object] = {}
    for name, (dims, _) in data.items():
        units = VARIABLES[_name_in_table(name)].units
        if " or " not in units or f"{name}_unit" in coords:
            continue
        if "dof" in dims:
            quantity = UNITS_BY_DOF[units]
            attributes = {"long_name": f"{quantity.replace('_', ' ')} of each degree of freedom"}
            coordinates[quantity] = ("dof", _units_by_dof(units), attributes)
        else:
            units_by_label = [unit_of(units_of(units), [label]) for label in coords[dims[-1]][1]]
            coordinates[f"{name}_unit"] = (
                dims[-1],
                units_by_label,
                {"long_name": f"unit of {name}"},
            )
    return coordinates


def _units_by_dof(units: str) -> list[str]:
    translation, _, rotation = units.partition(" or ")
    return [translation] * 3 + [rotation] * 3


def _name_in_table(name: str) -> str:
    """Name in `VARIABLES` of a variable."""
    return name if name in VARIABLES else next(k for k in VARIABLES if name.startswith(k))


def describe(dataset: xr.Dataset) -> None:
    """Units, long_name and frame of every variable, from the table; meanings of modes."""
    for name in map(str, dataset.data_vars):
        key = _name_in_table(name)
        variable = VARIABLES[key]
        what = name[len(key) :].replace("_", " ") if key.endswith("_") else ""
        long_name = f"{what}: {variable.long_name}" if what else variable.long_name
        attributes: dict[str, object] = {
            **quantity_attributes(long_name, variable.units),
            "frame": variable.frame,
        }
        if variable.flags:
            values = np.arange(len(variable.flags.split()), dtype=np.int8)
            attributes |= {"flag_values": values, "flag_meanings": variable.flags}
        dataset.variables[name].attrs.update(attributes)
    describe_coordinates(dataset)
    for variable_name, array in dataset.variables.items():
        if any(str(label).startswith(RESTART_PREFIXES) for label in (variable_name, *array.dims)):
            array.attrs[PURPOSE] = RESTART


def describe_coordinates(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset, with a long_name of every coordinate that had none."""
    for name in map(str, dataset.coords):
        text = LABELS.get(name, name.replace("_", " "))
        dataset.variables[name].attrs.setdefault("long_name", text)
    return dataset
