"""Scenes by name: dry blocks that fly, bounce, stick and slide, and the H-851 of the thesis' cases,
moored, free floating or pressed against the topside."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import lru_cache
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike
from scipy.spatial.transform import Rotation

import hydrosim as hs
from hydrosim import load_case
from hydrosim.database import HydroDatabase, load
from hydrosim.dofs import DOFS, about_z
from hydrosim.elements import (
    AppliedForce,
    Fender,
    Frictionless,
    FrictionSlope,
    LinearMooring,
    NormalCurve,
    Plane,
    PrescribedNormal,
    Signal,
    StickSlip,
    Table,
    constant,
)
from hydrosim.results.dataset import write_run
from hydrosim.scene import (
    Body,
    ForceElement,
    Jonswap,
    LinearScenes,
    Scene,
    Solver,
    Start,
    Stream,
    WaveTrain,
)

INERTIA = np.array([[3.0, -0.4, 0.2], [-0.4, 4.0, 0.3], [0.2, 0.3, 6.0]])  # per unit of mass [m^2]
ROOT = Path(__file__).parents[1]
CASES = ROOT / "cases" / "reverse_float_over"
SEA = Jonswap(significant_height=1.5, peak_period=8.0, peak_enhancement=3.3)
SWINGING_BLOCK = """\
title: Swinging block
duration: 20 s
bodies:
  block: {mass: 2 kg, dofs: [surge], initial: {position: [0.3 m, 0, 0, 0, 0, 0]}}
forces:
  spring: {type: linear_mooring, body: block, stiffness: {surge: 5 N/m}}
solver: {step: 0.02 s, linear: step}
output: {step: 0.1 s}
"""
FLOOR = Plane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
Law = StickSlip | FrictionSlope | Frictionless


def block(mass: float, dofs: Sequence[str] = DOFS, name: str = "block", **changes: Any) -> Body:
    """A dry body without symmetry."""
    return replace(Body(name, mass, mass * INERTIA, dofs=tuple(dofs)), **changes)


def moving(**values: float) -> tuple[float, ...]:
    """Six coordinates or velocities by name."""
    return tuple(values.get(dof, 0.0) for dof in DOFS)


def table(time: ArrayLike, force: ArrayLike) -> dict[str, Signal]:
    """Forces and moments (n, 6) at ``time`` (n,), by the names of the DOFs."""
    time, force = np.asarray(time, float), np.asarray(force, float)
    return {dof: Table(time, column) for dof, column in zip(DOFS, force.T, strict=True)}


def steady(body: str = "block", **force: float) -> AppliedForce:
    """A constant force on the centre of gravity."""
    signals = {dof: constant(size) for dof, size in force.items()}
    return AppliedForce(body, (0.0, 0.0, 0.0), signals)


def on_floor(
    stiffness: float,
    friction: Law,
    points: Sequence[Sequence[float]] = ((0.0, 0.0, 0.0),),
    plane: Plane = FLOOR,
    body: str = "block",
) -> Fender:
    """Points with a straight normal curve."""
    curve = NormalCurve(np.array([0.0, 1.0]), np.array([0.0, stiffness]))
    return Fender(body, np.array(points, dtype=float), plane, curve, friction)


def scene(
    bodies: Body | Sequence[Body],
    forces: Mapping[str, ForceElement],
    duration: float,
    output_step: float,
    **solver: Any,
) -> Scene:
    """A scene without water."""
    bodies = (bodies,) if isinstance(bodies, Body) else tuple(bodies)
    settings = Solver(**{"step": output_step, "linear": LinearScenes.STEP, **solver})
    return Scene(
        "dry", duration, bodies, forces=forces, solver=settings, output={"step": output_step}
    )


def with_step(scene: Scene, step: float, **changes: Any) -> Scene:
    """The same scene at another step, and other changes of the solver."""
    return replace(scene, solver=replace(scene.solver, step=step, **changes))


def surge(run: xr.Dataset) -> np.ndarray:
    """Surge of the first body (nt,)."""
    return run.position.values[:, 0, 0]


def heave(run: xr.Dataset) -> np.ndarray:
    """Heave of the first body (nt,)."""
    return run.position.values[:, 0, 2]


def errors(scene: Scene, steps: Sequence[float], exact: np.ndarray, dof: int = 0, **solver: Any):
    """Largest error of a coordinate of the first body at the output times, for every step."""
    runs = [hs.simulate(with_step(scene, step, **solver)) for step in steps]
    return np.array([np.abs(run.position.values[:, 0, dof] - exact).max() for run in runs])


def observed_orders(steps: Sequence[float], errors: np.ndarray) -> np.ndarray:
    """log(e1 / e2) / log(h1 / h2) of neighbours."""
    return np.diff(np.log(errors)) / np.diff(np.log(steps))


@lru_cache
def hull() -> HydroDatabase:
    """The barge's database, about the centre of gravity of the cases."""
    return load(ROOT / "hydro_db" / "h851.nc")


@lru_cache
def scene_of(case: str) -> Scene:
    """The scene of one of the reverse float-over cases, with the database read once for all."""
    return with_body(load_case(CASES / f"{case}.yaml").scene(), hydrodynamics=hull())


def with_body(scene: Scene, **changes: Any) -> Scene:
    """The scene with its one body changed."""
    (body,) = scene.bodies
    return replace(scene, bodies=(replace(body, **changes),))


def in_waves(scene: Scene, *trains: WaveTrain) -> Scene:
    """The scene in other waves; in calm water if there are none."""
    return replace(scene, environment=replace(scene.environment, waves=trains))


def in_contact(duration: float, step: float = 0.1, points: np.ndarray | None = None) -> Scene:
    """The base case lifted at once until the barge knocks against the topside in every wave.

    The fenders are those of the base case or others at ``points`` (n, 3) with the same totals.
    """
    base = scene_of("base")
    fender = base.forces["interface"]
    assert isinstance(fender, Fender)
    lift = steady("barge", heave=160e6)
    interface = fender if points is None else _shared(fender, np.asarray(points, dtype=float))
    scene = with_body(in_waves(base, WaveTrain(SEA)), position=(0.0, 0.0, 1.05, 0.0, 0.0, 0.0))
    return replace(
        scene,
        duration=duration,
        forces={"mooring": base.forces["mooring"], "lift": lift, "interface": interface},
        solver=Solver(step=step),
    )


def _shared(fender: Fender, points: np.ndarray) -> Fender:
    """The fender with its total stiffness, damping and friction on other points."""
    share = len(fender.points) / len(points)
    curve, law = fender.normal, fender.friction
    assert isinstance(law, StickSlip)
    return replace(
        fender,
        points=points,
        normal=NormalCurve(curve.compression, share * curve.force, share * curve.damping),
        friction=replace(
            law,
            stiffness=share * law.stiffness,
            damping=share * law.damping,
            slip_damping=share * law.slip_damping,
        ),
    )


def motion(run: xr.Dataset, body: int = 0) -> np.ndarray:
    """Position (nt, 6) of a body."""
    return run.position.values[:, body]


def momenta(run: xr.Dataset, bodies: Sequence[Body]) -> tuple[np.ndarray, np.ndarray]:
    """Linear and angular momentum (nt, 3) about the earth's origin."""
    linear, angular = np.zeros((run.time.size, 3)), np.zeros((run.time.size, 3))
    for i, body in enumerate(bodies):
        q, v = run.position.values[:, i], run.velocity.values[:, i]
        R = Rotation.from_euler("ZYX", q[:, :2:-1]).as_matrix()
        spin = np.einsum("tij,jk,tlk,tl->ti", R, body.inertia, R, v[:, 3:])
        p, place = body.mass * v[:, :3], q[:, :3] + run.reference_position.values[i]
        linear, angular = linear + p, angular + spin + np.cross(place, p)
    return linear, angular


def assert_continues(
    whole: Scene, run: xr.Dataset, times: ArrayLike, *names: str, file: Path | None = None
) -> None:
    """Started from the states of its run at ``times``, a scene goes on to the bit; ``names`` are
    compared at all times, states at the end. With a ``file`` the run is written and read there."""
    if file is not None:
        write_run(run, file)
    for time in np.asarray(times, float):
        start = Start(file or run, float(time))
        after = hs.simulate(replace(whole, duration=whole.duration - time, initial=start))
        rest = run.sel(time=slice(time - 1e-9, None))
        for name in names:
            np.testing.assert_array_equal(after[name].values, rest[name].values, err_msg=name)
        np.testing.assert_array_equal(after.state_value[-1], run.state_value[-1])


def central_force(body: str = "block", **signals: Signal) -> AppliedForce:
    """Forces and moments over time on the centre of gravity."""
    return AppliedForce(body, (0.0, 0.0, 0.0), signals)


def mooring(body: str = "block", **stiffness: float) -> LinearMooring:
    """Springs at the centre of gravity that couple nothing."""
    return LinearMooring(body, np.diag(moving(**stiffness)))


def catenary_of(
    body: str,
    point: Sequence[float],
    anchor: Sequence[float],
    length: ArrayLike,
    weight: ArrayLike,
    stiffness: ArrayLike,
    hung: ArrayLike = 0.0,
    width: ArrayLike = 0.0,
    friction: float | None = None,
    curves: Mapping[int, np.ndarray] | None = None,
    paid: Signal | None = None,
    **keys: Any,
) -> hs.Catenary:
    """A catenary of segments with such columns; the first is ``paid`` out. ``hung`` is a clump
    above 0, else a buoy; ``curves`` of stretch and tension replace the stiffness."""
    laws = {k: hs.StretchCurve(*curve) for k, curve in (curves or {}).items()}
    columns = np.broadcast_arrays(*map(np.atleast_1d, (length, weight, stiffness, hung, width)))
    segments = [
        hs.Segment(
            paid if k == 0 and paid is not None else float(L),
            float(w),
            laws.get(k, float(EA)),
            drag=hs.LineDrag(1.0, float(b)) if b else None,
            clump=float(load) if load > 0.0 else None,
            buoy=float(-load) if load < 0.0 else None,
        )
        for k, (L, w, EA, load, b) in enumerate(zip(*columns, strict=True))
    ]
    bed = None if friction is None else hs.Seabed(friction)
    return hs.Catenary(body, tuple(point), tuple(anchor), segments=segments, seabed=bed, **keys)


def straight_curve(stiffness: float, damping: float = 0.0) -> NormalCurve:
    return NormalCurve(np.array([0.0, 1.0]), np.array([0.0, stiffness]), damping)


def foot(normal: NormalCurve | PrescribedNormal, friction: Law) -> Fender:
    """The origin of the block on the floor."""
    return Fender("block", np.zeros((1, 3)), FLOOR, normal, friction)


class Stops(NamedTuple):
    """Stops of a motion of a joint that may be a turn or a slide."""

    lowest: float
    highest: float
    stiffness: float
    damping: float = 0.0


class JointFriction(NamedTuple):
    """Its friction; bearings are one radius from the axis of a turn."""

    static: float = 0.0
    kinetic: float = 0.0
    static_coefficient: float = 0.0
    kinetic_coefficient: float = 0.0
    radius: float = 1.0
    collar_radius: float = 0.0
    bearing_distance: float = inf


class Acting(NamedTuple):
    """What acts in a motion of a joint, and its start."""

    stiffness: float = 0.0
    neutral: float = 0.0
    damping: float = 0.0
    stops: Stops | None = None
    friction: JointFriction | None = None
    position: float = 0.0
    velocity: float = 0.0


MOTION_KEYS = {
    "cylindrical": ("slide", "turn"),
    "universal": ("first", "second"),
    "planar": ("first", "second", "turn"),
}


def joint_of(kind: str, body: str, to: str | None = None, *acting: Acting, **keys: Any) -> hs.Joint:
    """A joint of a kind, with ``axis`` and ``second_axis`` as far as it has them (else along or
    about z); what is ``acting`` in its motions, nothing without."""
    cls = getattr(hs, kind.capitalize())
    known = cls.schema_fields()
    axes = {"axis": (0.0, 0.0, 1.0), "second_axis": keys.pop("second_axis", None), **keys}
    given = {k: x for k, x in axes.items() if k in known or k not in ("axis", "second_axis")}
    joint = cls(body, to, **given)
    return with_motions(joint, *acting) if acting else joint


def with_motions(joint: hs.Joint, *acting: Acting) -> hs.Joint:
    """The same joint with this ``acting`` in its motions."""
    if joint.type == "ball":
        start = hs.BallInitial([a.position for a in acting], [a.velocity for a in acting])
        (damping,) = {a.damping for a in acting}
        return replace(joint, damping=damping, initial=start)
    forms = [_form_of(a, m.kind == "slide") for a, m in zip(acting, joint.motions, strict=True)]
    if joint.type in MOTION_KEYS:
        return replace(joint, **dict(zip(MOTION_KEYS[joint.type], forms, strict=True)))
    return replace(joint, **{f.name: getattr(forms[0], f.name) for f in fields(forms[0])})


def _form_of(acting: Acting, slides: bool) -> hs.Slide | hs.Turn:
    start = (hs.SlideInitial if slides else hs.TurnInitial)(acting.position, acting.velocity)
    keys = {"initial": start, **dict(zip(Acting._fields[:3], acting, strict=False))}
    if acting.stops:
        ends = (acting.stops[:2], *acting.stops[2:])
        keys["stops"] = (hs.SlideStops if slides else hs.TurnStops)(*ends)
    if acting.friction:
        rubs = (hs.SlideFriction if slides else hs.TurnFriction)(**_friction_keys(acting, slides))
        keys["friction"] = rubs
    return (hs.Slide if slides else hs.Turn)(**keys)


def _friction_keys(acting: Acting, slides: bool) -> dict[str, float | None]:
    of = acting.friction
    given = "force" if slides else "moment"
    keys = {f"static_{given}": of.static, f"kinetic_{given}": of.kinetic} if of.static else {}
    if not of.static_coefficient:
        return keys
    for key in ("static_coefficient", "kinetic_coefficient"):
        keys[key] = getattr(of, key)
    apart = None if of.bearing_distance == inf else of.bearing_distance
    if slides:
        return {**keys, "guide_length": apart}
    levers = {"radius": of.radius or None, "collar_radius": of.collar_radius or None}
    return {**keys, **levers, "bearing_distance": apart}


def stream_of(velocity: np.ndarray) -> Stream:
    """The stream of this velocity."""
    return Stream(float(np.hypot(*velocity[:2])), float(np.arctan2(velocity[1], velocity[0])))


def _turned_stream(stream: Any, by: float) -> Any:
    return type(stream).build_from(stream, heading=stream.heading + by)


def turned_scene(scene: Scene, by: float, shift: Sequence[float] = (0.0, 0.0)) -> Scene:
    """The scene, its waves and streams turned about the vertical through the origin, then shifted.
    Joints are in the frames of their bodies and stay; so do forces of the body."""
    R, T = about_z(by), np.eye(6)
    T[:3, :3] = R

    def turn_body(body: Body) -> Body:
        q, v = np.array(body.position), np.array(body.velocity)
        place = (R @ [*body.location, 0.0])[:2] + shift
        start = {"position": (*(R @ q[:3]), *q[3:]), "velocity": (*(R @ v[:3]), *(R @ v[3:]))}
        return replace(body, location=tuple(place), heading=body.heading + by, **start)

    def turn_force(e: Any) -> ForceElement:
        if isinstance(e, LinearMooring):  # angles are the body's own
            damping = None if e.damping is None else T @ e.damping @ T.T
            return replace(e, stiffness=T @ e.stiffness @ T.T, damping=damping)
        if isinstance(e, Fender) and e.plane.body is None:
            point = tuple(R @ e.plane.point + [*shift, 0.0])
            return replace(e, plane=replace(e.plane, point=point, normal=tuple(R @ e.plane.normal)))
        if getattr(e, "anchor", None) is not None and e.anchor_body is None:
            return replace(e, anchor=tuple(R @ e.anchor + [*shift, 0.0]))
        upright = isinstance(e, AppliedForce) and {*e.force} <= {"heave", "yaw"}
        assert upright or not isinstance(e, AppliedForce) or e.frame == "body"
        return e

    water = scene.environment
    waves = tuple(replace(train, heading=train.heading + by) for train in water.waves)
    table = water.current.table
    if table is not None and table.heading:
        turned = replace(table, heading=[heading + by for heading in table.heading])
        current = replace(water.current, profile=turned)
    else:
        current = _turned_stream(water.current, by)
    wind = _turned_stream(water.wind, by)
    return replace(
        scene,
        bodies=tuple(map(turn_body, scene.bodies)),
        forces={name: turn_force(e) for name, e in scene.forces.items()},
        environment=replace(water, waves=waves, current=current, wind=wind),
    )
