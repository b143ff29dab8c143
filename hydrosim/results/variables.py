"""What the variables of a run are: their names in words, units and frames, and what modes mean.

Where the degrees of freedom have units of their own, `dof_units` says them in place of `units`.
"""

from __future__ import annotations

import numpy as np
import xarray as xr

from hydrosim.forces.contact import guide
from hydrosim.results import impulses
from hydrosim.results.phases import Phase

EARTH, HEADING = "earth", "axes that turn with the yaw of the body"
MIXED = "SI"  # of numbers that have different units
VARIABLES: dict[str, tuple[str, str, str]] = {
    # name: long_name, units, frame; a name that ends in "_" is of all that begin with it
    "position": ("displacement of the centre of gravity from rest; angles", "m or rad", EARTH),
    "velocity": ("velocity of the centre of gravity; angular velocity", "m/s or rad/s", EARTH),
    "acceleration": (
        "acceleration of the centre of gravity; angular acceleration",
        "m/s^2 or rad/s^2",
        EARTH,
    ),
    "momentum": ("momentum of body and added mass", "N s or N m s", EARTH),
    "impulse": ("integral of a force, of its moment, since the start", "N s or N m s", EARTH),
    "work": ("work of a force by degree of freedom since the start", "J", EARTH),
    **impulses.VARIABLES,
    "reference_position": ("place of the centre of gravity at rest", "m", EARTH),
    "slow_draught": ("draught, slow, that the coefficients of a family are for", "m", "none"),
    "wave_elevation": ("undisturbed wave elevation at the origin", "m", EARTH),
    "wave_elevation_at_probe": ("undisturbed wave elevation at a probe", "m", EARTH),
    "force_": ("force; moment about the centre of gravity", "N or N m", EARTH),
    "fender_compression": ("compression, negative when open", "m", "normal of the plane"),
    "fender_normal_force": ("normal force", "N", "normal of the plane"),
    "fender_mode": ("contact mode", "1", "none"),
    "fender_friction": ("friction force on the body", "N", EARTH),
    "fender_node": ("place of the contact node on the plane", "m", EARTH),
    "fender_slip_distance": ("distance slipped since the start", "m", "plane"),
    "fender_dissipated": ("energy lost in friction and loops since the start", "J", "none"),
    "fender_dissipated_damping": ("of it in the node's damper C2", "J", "none"),
    "fender_dissipated_slip_damping": ("of it in slip damping C3", "J", "none"),
    "fender_closings": ("how often the contact has closed since the start", "1", "none"),
    "fender_closing_speed": ("speed at which it closed last", "m/s", "normal of the plane"),
    "fender_largest_force": ("largest normal force since then", "N", "normal of the plane"),
    "contact_phase": ("phase of the operation by the contacts of a group", "1", "none"),
    "point_position": ("place of a named point", "m", EARTH),
    "clearance": ("clearance of a named point", "m", "none"),
    "spring_tension": ("tension", "N", "from the point to the anchor"),
    "spring_length": ("distance from the point to the anchor", "m", "none"),
    "spring_mode": ("slack (no tension) or taut", "1", "none"),
    "energy_kinetic": ("kinetic energy, with added mass", "J", "none"),
    "energy_stored_": ("stored energy", "J", "none"),
    "energy_work_": ("work done on the bodies since the start", "J", "none"),
    "energy_dissipated_": ("energy lost since the start", "J", "none"),
    "energy_wave_absolute": ("integral of |wave power| since the start", "J", "none"),
    "energy_residual": ("energy that the ledger cannot account for", "J", "none"),
    "state_value": ("state that a run can start from", MIXED, "that of each state"),
    "state_input": ("rate of a radiation state for unit velocities", MIXED, "body"),
    "fender_segment": ("piece of the normal curve, counted from 0", "1", "none"),
    "guide_force": ("force of the wall, across the axis of the seat", "N", "none"),
    "guide_clearance": ("clearance to the wall, negative if pressed", "m", "none"),
    "guide_mode": ("whether a pin is in its guide, and pressed to the wall", "1", "none"),
    "guide_segment": ("piece of the curve of the wall, counted from 0", "1", "none"),
    "spring_segment": ("piece of the curve, 0 if slack", "1", "none"),
    "tank_level": ("level above the bottom of the tank", "m", "tank"),
    "tank_mass": ("mass of the fluid in the tank", "kg", "none"),
    "pump_rate": ("mass per time into the target, back to the source if negative", "kg/s", "none"),
    "pump_mode": ("mode of a flow", "1", "none"),
    "pump_segment": ("piece of its rates, counted from 0", "1", "none"),
    "mass": ("mass with what is in the tanks", "kg", "none"),
    "centre_of_gravity": ("centre of gravity from the body's origin", "m", "body"),
    "fender_rising": ("1 if the stretch is that of a rising load", "1", "none"),
    "trigger_stage": ("before, during or after the time in which an element acts", "1", "none"),
    "trigger_waits": ("1 while what is waited for lasts", "1", "none"),
    "memory_past": ("velocity that a convolution remembers, and its integrals", MIXED, HEADING),
    "memory_node": ("the same with the acceleration, at the last step but one", MIXED, HEADING),
}
FLAGS = {
    "fender_mode": "open stick slip",
    "pump_mode": "waiting running over",
    "spring_mode": "slack taut absent",
    "guide_mode": " ".join(guide.NAMES),
    "trigger_stage": "before during after",
    "contact_phase": " ".join(phase.name.lower() for phase in Phase),
}


def units_of(units: str) -> dict[str, str]:
    """The one unit; or those of the six degrees of freedom; or that each number has its own."""
    translation, _, rotation = units.partition(" or ")
    if rotation:
        return {"dof_units": ", ".join([translation] * 3 + [rotation] * 3)}
    return {"comment": "each number in SI, angles in rad"} if units == MIXED else {"units": units}


def describe(dataset: xr.Dataset) -> None:
    """Units, long_name and frame of every variable, from the table; meanings of modes."""
    for name in dataset.data_vars:
        variable = dataset.variables[name]
        key = name if name in VARIABLES else next(k for k in VARIABLES if str(name).startswith(k))
        long_name, units, frame = VARIABLES[str(key)]
        what = str(name)[len(str(key)) :].replace("_", " ") if str(key).endswith("_") else ""
        long_name = f"{what}: {long_name}" if what else long_name
        variable.attrs.update(long_name=long_name, **units_of(units), frame=frame)
    for name, meanings in FLAGS.items():
        if name in dataset:
            values = np.arange(len(meanings.split()), dtype=np.int8)
            dataset.variables[name].attrs.update(flag_values=values, flag_meanings=meanings)
