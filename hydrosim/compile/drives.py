"""Prescribed motion of a scene: whether it can be, and whether the start agrees with it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compile.hydrostatics import cut_tanks
from hydrosim.dofs import DOFS
from hydrosim.elements import driven_coordinates
from hydrosim.elements.drive import Drive
from hydrosim.elements.events import follow_drives
from hydrosim.elements.signal import compile_signals, find_motion, find_piece
from hydrosim.errors import InputError
from hydrosim.integrate.dynamics import Model, new_work
from hydrosim.multibody.kinematics import LARGEST_TILT
from hydrosim.scene.joint import MotionKind
from hydrosim.scene.scene import Kinematics, arrangement, tree_joints
from hydrosim.scene.signal import Harmonic, SmoothTable, Table

if TYPE_CHECKING:
    from hydrosim.integrate.state import State
    from hydrosim.scene import Body, Joint, Scene

AGREES = 1e-6  # m, rad and per second: rounding of the input
PITCH_LIMIT = "angles of bodies are defined. Drive the angle of a hinge to the earth instead"
ROLL_LIMIT = "the water surface cuts a hull or a tank. Drive a smaller angle"
SAMPLES_PER_PIECE = 7
SAMPLES_PER_PERIOD = 64


def drives_of(scene: Scene) -> dict[str, Drive]:
    """The drives among the forces of a scene."""
    return {name: e for name, e in scene.forces.items() if isinstance(e, Drive)}


def check_drives(scene: Scene, begin: float) -> None:
    """Raises InputError for drives of motions that are not free or already driven, and for signals
    that do not fit the run, which begins at ``begin`` [s], or its start."""
    taken: dict[str, str] = {}
    bodies = {body.name: body for body in scene.bodies}
    for name, drive in drives_of(scene).items():
        problems = [*_problems_of_place(scene, bodies, drive)]
        problems = problems or [*_problems_of_quantity(scene, drive)]
        problems = problems or [*_problems_of_signal(scene, bodies, drive, begin)]
        if drive.driven in taken:
            problems.append(f": {taken[drive.driven]} drives {drive.driven} already; remove one")
        if problems:
            raise InputError(f"forces.{name}{problems[0]}.")
        taken[drive.driven] = name


def _problems_of_place(scene: Scene, bodies: Mapping[str, Body], drive: Drive) -> Iterator[str]:
    """Why a drive cannot move what it names: the rest of its key, and the reason."""
    if drive.active is not None:
        yield (
            ".active: found a condition; a drive acts for the whole run. Let its table stand still"
            " before and after"
        )
    if drive.joint is not None:
        yield from _problems_of_joint(scene, drive)
        return
    if drive.coordinate not in DOFS:
        yield f".dof: found {drive.coordinate}; expected one of {', '.join(DOFS)}"
        return
    carrier = {branch.child: branch.name for branch in arrangement(scene).branches}
    if drive.body in carrier:
        joint = carrier[drive.body]
        yield (
            f".body: found {drive.body}, which the joint {joint} carries; drive a motion of the"
            f" joint instead, by joint: {joint}"
        )
    elif drive.coordinate not in bodies[drive.body].dofs:
        free = ", ".join(bodies[drive.body].dofs) or "none"
        yield (
            f".dof: found {drive.dof}, which is locked by bodies.{drive.body}.dofs; expected a"
            f" free one ({free}). Add {drive.dof} there"
        )


def _problems_of_joint(scene: Scene, drive: Drive) -> Iterator[str]:
    joints = tree_joints(scene)
    if drive.joint not in scene.joints:
        joint_names = ", ".join(scene.joints) or "there is none"
        yield f".joint: found {drive.joint}; expected a joint of the scene: {joint_names}"
        return
    if drive.joint not in joints:
        yield (
            f".joint: found {drive.joint}, which is a constraint: it closes a loop, or holds at"
            " times; drive a motion of another joint"
        )
        return
    joint = joints[drive.joint]
    motions = {motion.name: motion for motion in joint.motions}
    turning = [m.name for m in joint.motions if m.kind == MotionKind.SWIVEL]
    if drive.coordinate not in motions:
        yield (
            f".motion: found {drive.coordinate or 'none'}; expected a motion of {drive.joint}, a"
            f" {joint.type}: {', '.join(motions) or 'it has none'}"
        )
    elif drive.coordinate in turning:
        yield (
            f".motion: found {drive.coordinate}; the turns of a {joint.type} follow no angle each."
            " Expected a slide, or a hinge or universal joint"
        )
    elif _has_friction(joint, drive.coordinate):
        yield (
            f".joint: found friction in joints.{drive.joint}, in the motion that is driven;"
            " expected none there. It would add its own force to that of the drive"
        )


def _problems_of_quantity(scene: Scene, drive: Drive) -> Iterator[str]:
    wanted = "angle" if is_turn(scene, drive) else "offset"
    if drive.quantity != wanted:
        yield f".{drive.quantity}: found {drive.quantity} of {drive.driven}; expected {wanted}"


def _has_friction(joint: Joint, motion: str) -> bool:
    names = [joint_motion.name for joint_motion in joint.motions]
    return joint.resistances[names.index(motion)].friction is not None


def is_turn(scene: Scene, drive: Drive) -> bool:
    """True if a drive prescribes an angle."""
    if drive.joint is None:
        return drive.coordinate in DOFS[3:]
    return any(
        motion.name == drive.coordinate and motion.kind != MotionKind.SLIDE
        for motion in scene.joints[drive.joint].motions
    )


def _problems_of_signal(
    scene: Scene, bodies: Mapping[str, Body], drive: Drive, begin: float
) -> Iterator[str]:
    signal = drive.position
    key = ".angle" if is_turn(scene, drive) else ".offset"
    if isinstance(signal, Table):
        yield f"{key}: found straight lines; expected a SmoothTable, which has no corners of speed"
        return
    last = begin + scene.duration
    if isinstance(signal, SmoothTable):
        time = signal.time
        if time.size < 2:
            yield f"{key}.time: found {time.size} times; expected two or more, which rise"
            return
        if time[0] > begin or time[-1] < last * (1.0 - 1e-9):
            yield (
                f"{key}.time: found a table from {time[0]:g} s to {time[-1]:g} s; expected one of"
                f" the whole run, from {begin:g} s to {last:g} s. Repeat a value to stand still"
            )
            return
    if _is_tilt_limited(scene, bodies, drive):
        times = sample_times(drive, begin, last)
        largest = max(abs(motion_at(drive, float(t))[0]) for t in times)
        if largest > LARGEST_TILT:
            yield (
                f"{key}: found a {drive.dof} of up to {np.degrees(largest):.4g} deg; expected less"
                f" than {np.degrees(LARGEST_TILT):.0f} deg, where"
                f" {ROLL_LIMIT if drive.coordinate == 'roll' else PITCH_LIMIT}"
            )
    if scene.initial is None:
        yield from _problems_of_start(scene, bodies, drive)


def _is_tilt_limited(scene: Scene, bodies: Mapping[str, Body], drive: Drive) -> bool:
    """Whether a drive turns a body in pitch, or a hull or tanks as meshes in roll: a run ends where
    they tilt too far."""
    if drive.joint is not None or scene.solver.kinematics is not Kinematics.EXACT:
        return False
    with_surface = bodies[drive.body].hydrostatics is not None or any(
        scene.bodies[cut.body].name == drive.body for cut in cut_tanks(scene)
    )
    return drive.coordinate == "pitch" or (drive.coordinate == "roll" and with_surface)


def _problems_of_start(scene: Scene, bodies: Mapping[str, Body], drive: Drive) -> Iterator[str]:
    """A start that the scene gives, and that differs from that of the drive."""
    position, speed, _ = motion_at(drive, 0.0)
    there, rate = _given_start(scene, bodies, drive)
    turns = is_turn(scene, drive)
    for given, wanted, what, unit in (
        (there, position, "position", "rad" if turns else "m"),
        (rate, speed, "velocity", "rad/s" if turns else "m/s"),
    ):
        if given != 0.0 and abs(given - wanted) > AGREES * max(1.0, abs(wanted)):
            yield (
                f": found an initial {what} of {given:g} {unit} in {drive.driven}, which this"
                f" drive starts with {wanted:g} {unit}; expected none: the run starts where the"
                " drive does"
            )


def _given_start(scene: Scene, bodies: Mapping[str, Body], drive: Drive) -> tuple[float, float]:
    if drive.joint is None:
        i = DOFS.index(drive.coordinate)
        body = bodies[drive.body]
        return float(body.position[i]), float(body.velocity[i])
    joint = scene.joints[drive.joint]
    names = [motion.name for motion in joint.motions]
    acting = joint.resistances[names.index(drive.coordinate)]
    return acting.position, acting.velocity


def motion_at(drive: Drive, t: float) -> tuple[float, float, float]:
    """Position, speed and acceleration of a drive at ``t`` [s]."""
    signals, pieces = compile_signals([drive.position])
    position, speed, acceleration = find_motion(
        t, signals[0], pieces[find_piece(t, signals[0], pieces)]
    )
    return float(position), float(speed), float(acceleration)


def sample_times(drive: Drive, begin: float, end: float) -> np.ndarray:
    """Times of a run at which a drive is looked at."""
    signal = drive.position
    if isinstance(signal, Harmonic):
        count = int(np.ceil(min((end - begin) / signal.period, 1.0) * SAMPLES_PER_PERIOD))
        return np.linspace(begin, min(end, begin + signal.period), count + 1)
    knots = np.clip(signal.time, begin, end)
    inside = [np.linspace(a, b, SAMPLES_PER_PIECE, endpoint=False) for a, b in pairwise(knots)]
    return np.unique(np.concatenate([*inside, [end]]))


def follow_at(t: float, y: np.ndarray, model: Model) -> None:
    """Bring driven coordinates in ``y`` and their rates to their signals at ``t``."""
    if driven_coordinates(model.elements).size:
        follow_drives(t, y, model.bodies, model.elements, new_work(model).holds)


def check_driven_start(scene: Scene, model: Model, state: State, t: float) -> None:
    """Raises InputError if an earlier run, which this one continues from ``t`` [s], was
    elsewhere."""
    if scene.initial is None:
        return
    n = model.bodies.active.size
    wanted = state.y.copy()
    follow_at(t, wanted, model)
    driven = driven_coordinates(model.elements)
    for j, (name, drive) in zip(driven, drives_of(scene).items(), strict=True):
        for k, what in ((j, "position"), (n + j, "velocity")):
            if abs(state.y[k] - wanted[k]) > AGREES * max(1.0, abs(wanted[k])):
                raise InputError(
                    f"forces.{name}: at {t:g} s it has the {what} {wanted[k]:g}, and"
                    f" {drive.driven} {state.y[k]:g} in the run to start from; expected the same."
                    " Begin its signal with the motion of that run."
                )
