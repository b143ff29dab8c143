"""From a validated case to the scene's dataclasses."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from hydrosim import forces, scene
from hydrosim.case import schema, signals
from hydrosim.case.records import read_record
from hydrosim.case.seas import wave_trains
from hydrosim.documents.quantities import as_matrix
from hydrosim.forces.signal import scaled

OUTPUT_STEP = 0.5  # s, about: if the case does not say


def build_scene(data: schema.CaseFile, path: Path, text: str) -> scene.Scene:
    """The scene of a case; relative paths begin at the folder of ``path``."""
    step = data.solver.step
    return scene.Scene(
        title=data.title,
        duration=data.duration,
        bodies=tuple(_body(name, body, path.parent) for name, body in data.bodies.items()),
        environment=_environment(data.environment or schema.Environment(), path),
        forces={name: _element(name, element, path) for name, element in data.forces.items()},
        solver=_solver(data.solver),
        output_step=data.output.step or step * max(1, round(OUTPUT_STEP / step)),
        output_states=data.output.states,
        wave_probes=data.output.wave_probes,
        initial=_start(data.initial, path.parent) if data.initial else None,
        source={"case_file": str(path), "case": text},
    )


def _start(start: schema.Start, folder: Path) -> scene.Start:
    return scene.Start(folder / start.run, start.time)


def _solver(solver: schema.Solver) -> scene.Solver:
    tolerance = scene.Tolerance(**dict(solver.tolerance))
    return scene.Solver(**{**dict(solver), "tolerance": tolerance})


def _environment(water: schema.Environment, path: Path) -> scene.Environment:
    current, wind = (scene.Stream(**dict(s or {})) for s in (water.current, water.wind))
    return scene.Environment(
        *(water.water_depth, water.water_density, water.gravity, wave_trains(water, path)),
        current=current,
        wind=wind,
    )


def _body(name: str, body: schema.Body, folder: Path) -> scene.Body:
    return scene.Body(
        name=name,
        mass=body.mass,
        inertia=_inertia(body),
        hydrodynamics=folder / body.hydrodynamics if body.hydrodynamics is not None else None,
        centre_of_gravity=body.centre_of_gravity or (0.0, 0.0, 0.0),
        location=body.location,
        database_body=body.database_body,
        dofs=body.dofs,
        position=body.initial.position,
        velocity=body.initial.velocity,
        radiation=_radiation(body.radiation),
        wave_forces=scene.WaveForces(**dict(body.wave_forces)),
    )


def _radiation(form: schema.Radiation) -> scene.RadiationModel | scene.Radiation:
    match form:
        case schema.StateSpaceRadiation():
            return scene.StateSpaceRadiation(form.tolerance, form.length, form.step)
        case schema.ConvolutionRadiation():
            return scene.ConvolutionRadiation(form.length, form.step)
        case schema.ConstantRadiation():
            return scene.ConstantRadiation(form.period)
        case schema.NoRadiation():
            return scene.RadiationModel.NONE


def _inertia(body: schema.Body) -> np.ndarray:
    if body.inertia is not None:
        return np.array(body.inertia)
    if body.mass_matrix is not None:
        return np.array(body.mass_matrix)[3:, 3:]
    # Without free rotations any inertia will do.
    return body.mass * np.diag(np.square(body.radii_of_gyration or (1.0, 1.0, 1.0)))


def _element(name: str, element: schema.Element, path: Path) -> scene.ForceElement:
    match element:
        case schema.LinearMooring():
            return _mooring(element)
        case schema.AppliedForce():
            return _applied_force(name, element, path)
        case schema.Fender():
            return _fender(name, element, path)
        case schema.Spring():
            return _spring(element)
        case schema.LinearDamping():
            return _linear_damping(element)
        case schema.QuadraticDamping():
            return forces.QuadraticDamping(element.body, damping=as_matrix(element.damping))
        case schema.CurrentLoad():
            return forces.CurrentLoad(element.body, element.point, *_all_round(element))
        case schema.WindLoad():
            return forces.WindLoad(element.body, element.point, *_all_round(element))


def _mooring(element: schema.LinearMooring) -> forces.LinearMooring:
    stiffness, damping, ratio = element.stiffness, element.damping, element.damping_ratio
    return forces.LinearMooring(
        element.body,
        stiffness=np.zeros((6, 6)) if stiffness is None else as_matrix(stiffness),
        natural_period=element.diagonal[1],
        damping=None if damping is None else as_matrix(damping),
        damping_ratio=None if ratio is None else np.array(ratio.values()),
    )


def _linear_damping(element: schema.LinearDamping) -> forces.LinearDamping:
    damping, ratio = element.damping, element.damping_ratio
    return forces.LinearDamping(
        element.body,
        damping=None if damping is None else as_matrix(damping),
        damping_ratio=None if ratio is None else np.array(ratio.values()),
        relative_to_current=element.relative_to_current,
    )


def _all_round(element: schema.StreamLoad) -> tuple[np.ndarray, ...]:
    """Headings, and coefficients in surge, sway and yaw, of the whole circle."""
    headings = np.array(element.headings)
    zero = (0.0,) * headings.size
    values = [np.array(x or zero) for x in (element.surge, element.sway, element.yaw)]
    if not element.is_half:
        return headings, *values
    image = slice(-2, 0, -1)  # without 0 and 180 deg, which are their own
    mirrored = [sign * x[image] for sign, x in zip((1.0, -1.0, -1.0), values, strict=True)]
    both = [np.append(x, more) for x, more in zip(values, mirrored, strict=True)]
    return np.append(headings, 2.0 * np.pi - headings[image]), *both


def _applied_force(name: str, element: schema.AppliedForce, path: Path) -> forces.AppliedForce:
    time = np.array(element.time or (0.0,))
    force: dict[str, forces.Signal] = {}
    for dof, form in zip(scene.DOFS, element.force.values(absent=None), strict=True):
        if isinstance(form, tuple):
            force[dof] = forces.Table(time, np.array(form))
        elif form is not None:
            unit = "N" if dof in scene.DOFS[:3] else "N m"
            force[dof] = _signal(form, f"forces.{name}.force.{dof}", path, unit)
    return forces.AppliedForce(
        element.body, point=element.point, force=force, body_fixed=element.frame == "body"
    )


def _signal(form: signals.Form, key: str, path: Path, unit: str) -> forces.Signal:
    """The signal in ``unit`` that is at ``key`` of the case file ``path``."""
    match form:
        case signals.Table():
            return forces.Table(np.array(form.time), np.array(form.force))
        case signals.Harmonic():
            return forces.Harmonic(form.amplitude, form.period, form.mean or 0.0, form.phase)
    series = read_record(form, key, path, unit)
    return forces.Recorded(series.time, series.value)


def _fender(name: str, element: schema.Fender, path: Path) -> forces.Fender:
    count = len(element.points)
    return forces.Fender(
        element.body,
        points=np.array(element.points),
        plane=forces.Plane(**dict(element.plane)),
        normal=_normal(name, element.normal, count, path),
        friction=_friction(element.friction, count),
    )


def _normal(
    name: str, normal: schema.Normal, count: int, path: Path
) -> forces.NormalCurve | forces.PrescribedNormal:
    share = 1.0 / count if normal.total else 1.0
    if normal.prescribed is not None:
        key = f"forces.{name}.normal.prescribed"
        return forces.PrescribedNormal(scaled(_signal(normal.prescribed, key, path, "N"), share))
    if normal.stiffness is not None:
        table = np.array([0.0, 1.0]), np.array([0.0, normal.stiffness])
    else:
        table = np.array(normal.compression), np.array(normal.force)
    compression, force = table
    return forces.NormalCurve(compression, share * force, share * normal.damping)


def _friction(
    friction: schema.Friction, count: int
) -> forces.StickSlip | forces.FrictionSlope | forces.Coulomb | forces.Frictionless:
    if isinstance(friction, schema.Frictionless):
        return forces.Frictionless()
    if isinstance(friction, schema.Coulomb):
        return forces.Coulomb(friction.static, friction.kinetic)
    share = 1.0 / count if friction.total else 1.0
    if isinstance(friction, schema.FrictionSlope):
        return forces.FrictionSlope(friction.coefficient, share * friction.slope)
    return forces.StickSlip(
        friction.static,
        friction.kinetic,
        share * friction.stiffness,
        share * friction.damping,
        share * friction.slip_damping,
        load=_load(friction.load, share),
    )


def _spring(element: schema.Spring) -> forces.Spring:
    extension, tension = np.array([0.0, 1.0]), np.array([0.0, element.stiffness or 0.0])
    if element.curve is not None:
        extension, tension = np.array(element.curve.extension), np.array(element.curve.tension)
    return forces.Spring(
        element.body,
        point=element.point,
        anchor=element.anchor,
        length=element.length,
        extension=extension,
        tension=tension,
        damping=element.damping,
        anchor_body=element.anchor_body,
    )


def _load(load: schema.LoadPowers | None, share: float) -> forces.LoadPowers | None:
    if load is None:
        return None
    powers = (load.stiffness, load.damping, load.slip_damping)
    return forces.LoadPowers(share * load.reference, *powers)
