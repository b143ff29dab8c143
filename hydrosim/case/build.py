"""From a validated case to the scene's dataclasses, or to a text with every key."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import replace
from enum import Enum
from functools import partial
from math import inf
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml
from pydantic import BaseModel

from hydrosim import scene
from hydrosim.case import schema
from hydrosim.case.criteria import as_attributes
from hydrosim.case.hydrodynamics import build_hydrodynamics, hull_of
from hydrosim.case.lines.element import Lines, Vessel
from hydrosim.case.seas import wave_trains
from hydrosim.case.tanks import SEA_NAME
from hydrosim.errors import InputError
from hydrosim.files.display_units import as_attribute
from hydrosim.files.layers import DUMPER, FILES
from hydrosim.files.messages import fields_of
from hydrosim.files.schema_class import SchemaClass
from hydrosim.files.units import CoordinateValue, Scale
from hydrosim.scene.body import inertia_matrix
from hydrosim.scene.damping import ViscousRoll
from hydrosim.scene.force import BuildContext
from hydrosim.scene.scene import arrange_joints

if TYPE_CHECKING:
    from hydrosim.case.schema import CaseFile

# A case written out with every key, so that later versions with other defaults run the same.


def resolved_case_text(data: CaseFile, folder: Path) -> str:
    """A case file (YAML) that says of each key of ``data`` what is taken for it: in SI and radians,
    with the defaults, relative paths, which begin at ``folder``, as absolute ones."""
    output = replace(data.output, step=data.output.step_beside(data.solver.step))
    place = folder / "case.yaml"
    forces = {
        name: fit_decay(element, BuildContext(f"forces.{name}", place))
        for name, element in data.forces.items()
    }
    changes = {"output": output, "environment": data.water, "bodies": _build_bodies(data)}
    changes["forces"] = forces
    whole = data.model_copy(update=changes)
    return yaml.dump(
        _plain_value(whole, folder),
        Dumper=DUMPER,
        default_flow_style=None,  # what is in one piece stands in one line
        sort_keys=False,
        allow_unicode=True,
        width=100,
    )


def fit_decay(element: Any, where: BuildContext) -> Any:
    """A force element with p1, p2, p3 and the period that are fitted to its recorded decay of roll,
    if it has one."""
    if not isinstance(element, ViscousRoll) or element.decay is None:
        return element
    from hydrosim.elements.roll_decay import fit_files

    form = element.decay
    files = [where.path.parent / form.file]
    key = f"{where.path}: {where.key}.decay"
    fit = fit_files(files, form.column, form.unit, form.start, form.end, key)
    p1, p2, p3 = fit.damping
    return replace(element, decay=None, period=fit.period.value, p1=p1, p2=p2, p3=p3)


def _build_bodies(data: CaseFile) -> dict[str, Any]:
    """The bodies. Those that joints carry have neither degrees of freedom nor a start."""
    carried = arrange_joints(data.joints, list(data.bodies)).children
    without = {"dofs": None, "initial": None}
    return {
        name: schema.BodyEntry.build_from(body, **(without if name in carried else {}))
        for name, body in data.bodies.items()
    }


def _plain_value(value: Any, folder: Path) -> Any:
    """A value as YAML has it; None is left out of mappings."""
    match value:
        case BaseModel() | SchemaClass():
            get = value.as_written if isinstance(value, SchemaClass) else partial(getattr, value)
            fields = fields_of(type(value)).items()
            return _plain_value({field.alias or key: get(key) for key, field in fields}, folder)
        case dict():
            return {
                str(key): os.path.abspath(folder / item) if _is_file(key, item) else plain
                for key, item in value.items()
                if (plain := _plain_value(item, folder)) is not None
            }
        case np.ndarray():
            return value.tolist()
        case tuple() | list():
            return [_plain_value(item, folder) for item in value]
        case Scale():
            return value.text or value.value
        case CoordinateValue():
            return value.text
        case Enum():
            return str(value)
    return "infinite" if value == inf else value


def _is_file(key: object, item: object) -> bool:
    return key in FILES and isinstance(item, str)


def build_scene(
    data: schema.CaseFile, path: Path, text: str, units: Mapping[str, str] = MappingProxyType({})
) -> scene.Scene:
    """The scene of a case; relative paths begin at the folder of ``path``. Its results are read in
    ``units``, by SI unit."""
    bodies = tuple(_build_body(name, body, path.parent) for name, body in data.bodies.items())
    forces, left_out = _build_forces(data, path, {body.name: body for body in bodies})
    return scene.Scene(
        title=data.title,
        duration=data.duration,
        bodies=bodies,
        environment=_build_environment(data.water, path),
        forces=forces,
        joints=data.joints,
        solver=_build_solver(data.solver),
        output=data.output,
        initial=_build_start(data.begins, path.parent) if data.begins else None,
        at_rest=data.initial == "at_rest",
        accept=data.accept,
        left_out=left_out,
        source={
            "case_file": str(path),
            "case": text,
            "case_resolved": resolved_case_text(data, path.parent),
            **as_attribute(units),
            **as_attributes(data.report, data.criteria),
        },
    )


def _build_forces(
    data: schema.CaseFile, path: Path, bodies: Mapping[str, scene.Body]
) -> tuple[dict[str, scene.ForceElement], tuple[scene.OmittedEntry, ...]]:
    """The force elements, and what files of lines say besides, which are several elements each."""
    elements_by_name: dict[str, scene.ForceElement] = {}
    left_out: list[scene.OmittedEntry] = []
    for name, element in data.forces.items():
        where = BuildContext(f"forces.{name}", path, _water_density(data.water), data.joints)
        if isinstance(element, Lines):
            body = bodies[element.body]
            place = (body.location, body.heading, body.centre_of_gravity)
            several, omitted = element.build_lines(where, Vessel(*place, data.water.water_depth))
            left_out += omitted
        else:
            several = {name: fit_decay(element, where).build_active(where)}
        if twice := {*several} & {*elements_by_name, *data.forces} - {name}:
            text = f'found two elements of the name "{min(twice)}"; expected another name of one'
            raise InputError(f"{path}: forces.{name}: {text}; lines have names NAME_LINE")
        elements_by_name |= several
    return elements_by_name, tuple(left_out)


def _build_start(start: scene.Start, folder: Path) -> scene.Start:
    return scene.Start(_path_in_folder(folder, start.run), start.time)


def _path_in_folder(folder: Path, file: str) -> Path:
    """A file that a case in ``folder`` names, by the name that all cases have for it."""
    return Path(os.path.abspath(folder / file))


def _build_solver(solver: schema.SolverEntry) -> scene.Solver:
    given = solver.tolerance
    if isinstance(given, scene.Tolerance):
        return scene.Solver.build_from(solver)
    return scene.Solver.build_from(solver, tolerance=scene.Tolerance(), accuracy=given)


def _water_density(water: schema.EnvironmentEntry) -> tuple[float, float]:
    """Density [kg/m^3] of the water, and gravity [m/s^2]."""
    return water.water_density, water.gravity


def _build_environment(water: schema.EnvironmentEntry, path: Path) -> scene.Environment:
    still = scene.Stream()
    return scene.Environment.build_from(
        water,
        waves=wave_trains(water, path),
        current=water.current or scene.Current.build_from(still),
        wind=water.wind or scene.Wind.build_from(still),
    )


def _build_body(name: str, body: schema.BodyEntry, folder: Path) -> scene.Body:
    tanks = tuple(
        tank.build(key, f"bodies.{name}.tanks.{key}", folder) for key, tank in body.tanks.items()
    )
    hull = hull_of(body.hydrostatics, f"bodies.{name}.hydrostatics", folder, body.database_body)
    return scene.Body.build_from(
        body,
        name=name,
        **_mass_with_contents(body, tanks),
        radii_of_gyration=None,
        mass_matrix=None,
        hydrodynamics=build_hydrodynamics(body.hydrodynamics, partial(_path_in_folder, folder)),
        hydrostatics=hull,
        initial=scene.Initial(),
        position=body.initial.position,
        velocity=body.initial.velocity,
        weight=body.weight or (scene.Weight.CARRIED if tanks else scene.Weight.BALANCED),
        tanks=tanks,
        pumps=tuple(_build_pump(key, pump) for key, pump in body.pumps.items()),
    )


def _build_pump(name: str, pump: scene.PumpKeys) -> scene.Pump:
    ends = {key: getattr(pump, key) for key in ("source", "target")}
    places = {key: None if end == SEA_NAME else end for key, end in ends.items()}
    return scene.Pump.build_from(pump, name=name, **places)


def _mass_with_contents(body: schema.BodyEntry, tanks: tuple[scene.Tank, ...]) -> dict[str, Any]:
    """Mass, centre of gravity and inertia about it, of the body with what is in its tanks."""
    lightship = body.lightship
    if lightship is None:
        centre = body.centre_of_gravity or (0.0, 0.0, 0.0)
        return {"centre_of_gravity": centre, "inertia": inertia_matrix(body)}
    from hydrosim.tanks.timeline import loaded_body, tanks_at_start  # slow to load

    loaded = loaded_body(
        lightship.mass,
        lightship.centre_of_gravity,
        inertia_matrix(lightship),
        tanks_at_start(tanks),
    )
    return {
        "mass": loaded.mass,
        "centre_of_gravity": tuple(loaded.centre.tolist()),
        "inertia": loaded.inertia,
        "lightship": None,
    }
