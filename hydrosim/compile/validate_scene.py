"""Rules for scenes: checked before compilation, and at the first state."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.compile.closed_joints import check_closed, check_joints, describe_dropped
from hydrosim.compile.drives import check_drives
from hydrosim.compile.joints import check_trees
from hydrosim.compile.restart import start_time
from hydrosim.compile.sizes import check_sizes
from hydrosim.elements import has_kind, signals_of, undefined_units
from hydrosim.elements.contact.fender import check_contact
from hydrosim.elements.contact.law import OPEN, STICK
from hydrosim.elements.contact.laws import COULOMB
from hydrosim.elements.joint.motions import JOINT_MOTION_KIND, STUCK
from hydrosim.elements.kind import BODY_ROWS
from hydrosim.elements.line.points import line_shapes
from hydrosim.elements.link.kind import SPRING_KIND, link_kinematics
from hydrosim.elements.trigger import AFTER
from hydrosim.errors import InputError
from hydrosim.integrate.dynamics import Model, motion_at
from hydrosim.integrate.names import spring_names
from hydrosim.linear.linearise import find_constraint_rows
from hydrosim.modes import MODE
from hydrosim.results.memory import check_points
from hydrosim.scene import Kinematics, Scene
from hydrosim.scene.contacts import Contact
from hydrosim.scene.scene import ACCURACIES
from hydrosim.scene.signal import Recorded

if TYPE_CHECKING:
    from hydrosim.integrate.state import State

STRAINED = 0.2  # strain of a catenary at the start
COINCIDENT_ENDS_RTOL = 1e-9  # of a spring's length, below which its ends coincide


def check_scene(scene: Scene) -> None:
    """Raises InputError for mistakes that a case file cannot contain, but a scene written in Python
    can."""
    names = [body.name for body in scene.bodies]
    steps = scene.output_step / scene.solver.step if scene.solver.step > 0.0 else 0.0
    whole = round(steps) >= 1 and abs(steps - round(steps)) <= 1e-9 * steps
    accuracy = scene.solver.accuracy
    problems = {
        "bodies: found none, or two with the same name; expected at least one, with different"
        " names": not names or len({*names}) < len(names),
        "bodies: found no degree of freedom; expected at least one body that can move": not any(
            body.dofs for body in scene.bodies
        ),
        "solver.accuracy: must be from {:g} to {:g}".format(*ACCURACIES): accuracy is not None
        and not ACCURACIES[0] <= accuracy <= ACCURACIES[1],
        "bodies.heading: kinematics: linear allows only heading 0; rotate the rest of the scene,"
        " or choose exact": scene.solver.kinematics == Kinematics.LINEAR
        and any(body.heading for body in scene.bodies),
        "bodies.hydrostatics: kinematics: linear assumes small angles, which a hull does not;"
        " choose exact, or the matrix": scene.solver.kinematics == Kinematics.LINEAR
        and any(body.hydrostatics is not None for body in scene.bodies),
        "initial, at_rest: found both; expected only one of them": scene.at_rest
        and scene.initial is not None,
        "output.step: must be a whole multiple of solver.step": not (
            scene.solver.method.adapts or whole
        ),
    }
    for name, element in scene.forces.items():
        if not has_kind(element):
            hint = "; wrap a function as hydrosim.UserForce(BODY, FUNCTION)"
            text = f"found {type(element).__name__}; expected a force element of hydrosim"
            problems[f"forces.{name}: {text}{hint if callable(element) else ''}"] = True
            continue
        if not isinstance(element.body, str):
            text = f"found {element.body!r}; expected the name of a body"
            problems[f"forces.{name}.body: {text}"] = True
        for key, body in [("body", element.body), *element.connected_bodies()]:
            lacks = isinstance(body, str) and body not in names
            problems[f"forces.{name}.{key}: found {body}, which is no body of the scene"] = lacks
    problems_found = [problem for problem, there in problems.items() if there]
    problems_found += check_joints(scene)
    if not problems_found:
        problems_found += check_trees(scene)  # only of joints between known bodies
    if problems_found:
        raise InputError("scene: " + "; ".join(problems_found) + ".")
    for name, element in scene.forces.items():
        element.check(name)
        if isinstance(element, Contact):
            check_contact(name, element)
    if scene.initial is None or scene.initial.time is not None:  # else once its run is opened
        _check_records(scene)
        check_drives(scene, start_time(scene))
    check_points(scene)
    check_sizes(scene)


def _check_records(scene: Scene) -> None:
    """Refuse records that do not cover the whole run."""
    start = start_time(scene)
    end = start + scene.duration
    for key, signal in signals_of(scene.forces):
        if not isinstance(signal, Recorded):
            continue
        first, last = signal.time[[0, -1]]
        if first > start or last < end * (1.0 - 1e-9):
            raise InputError(
                f"{key}: found a record from {first:g} s to {last:g} s; expected a record of"
                f" the whole run, from {start:g} s to its end at {end:g} s. Shorten the duration,"
                " or record more."
            )


def check_start(scene: Scene, model: Model, state: State) -> None:
    """Raises InputError if the run cannot continue from the state at the start."""
    if scene.initial is None:
        check_closed(scene, model, state)
        _check_breaks(scene, model, state)
    _check_rigid_friction(scene, model, state)
    _check_load_friction(scene, model, state)
    _check_springs(scene, model, state)
    _check_lines(scene, model, state)
    for name, reason in undefined_units(model, scene, state.modes):
        raise InputError(f"forces.{name}: {reason}, at the start. Change its ends or axis.")


def _check_rigid_friction(scene: Scene, model: Model, state: State) -> None:
    """Refuse rigid friction in more directions than the bodies can move in."""
    fenders = model.elements.fenders
    rigid = fenders.points["law"] == COULOMB
    if not rigid.any():
        return
    held = state.modes.copy()
    held[fenders.mode :][: rigid.size, MODE] = np.where(rigid, STICK, OPEN)
    rows = find_constraint_rows(model, state.y, held)
    if not rows.size:  # no point can move along its plane
        return
    rank = _row_rank(rows)
    if rank < len(rows):
        rows_of = set(fenders.points["row"][rigid] - len(BODY_ROWS))
        names = ", ".join(name for i, name in enumerate(scene.forces) if i in rows_of)
        raise InputError(
            f"forces.{names}: rigid friction holds {len(rows)} directions at {rigid.sum()}"
            f" points, but the bodies can move in only {rank} of them. Then the shares of the"
            " points are not defined; expected fewer points, or law: stick_slip with a large"
            " stiffness."
        )


def _row_rank(rows: np.ndarray) -> int:
    scaled = rows / np.maximum(np.abs(rows).max(axis=0), 1e-12)
    return int(np.linalg.matrix_rank(scaled, tol=1e-9))


def _check_load_friction(scene: Scene, model: Model, state: State) -> None:
    """Refuse friction that grows with the load of joints whose loads, or whose friction at rest,
    are not determined."""
    p = model.elements.joint_motions
    if not p.loaded.size:
        return
    motions = JOINT_MOTION_KIND.unit_names(scene)
    rubs = p.each["static"] >= 0.0
    held = state.modes.copy()
    held[p.mode :][: rubs.size, MODE][rubs] = STUCK
    rows = find_constraint_rows(model, state.y, held)
    shared = list(describe_dropped(scene, model, state))
    if shared or _row_rank(rows) < len(rows):
        reason = "other joints or drives hold a part of what joints in a loop hold"
        if not shared:
            names = ", ".join(motions[i] for i in np.flatnonzero(rubs))
            reason = f"at rest friction holds more motions ({names}) than can move"
        raise InputError(
            f"joints: found friction that grows with the load in {motions[p.loaded[0]]}, while"
            f" {reason}, so that its shares are not defined; expected loads that are determined."
            " Let joints of the loop leave more free (ball, cylindrical), leave friction to one of"
            " its motions, or give a force or moment."
        )


def _check_lines(scene: Scene, model: Model, state: State) -> None:
    """Refuse catenaries whose ends coincide, or that would be stretched by a fifth and more."""
    time = start_time(scene)
    motion = motion_at(model, state.y)
    for line in line_shapes(model, scene, time, state.y, state.modes, model.bodies, motion):
        if line.distance <= COINCIDENT_ENDS_RTOL * line.length:
            raise _coincident_ends(line.name)
        if line.strain > STRAINED:
            raise InputError(
                f"forces.{line.name}.segments: found {line.length:g} m in all, while its ends are"
                f" {line.distance:.5g} m apart at the start, where it would have to stretch by"
                f" {line.strain:.0%}; expected less than {STRAINED:.0%}. Make it longer, bring its"
                " ends closer together, or check its stiffness EA. A curve of stiffness may hold"
                " more."
            )


def _check_breaks(scene: Scene, model: Model, state: State) -> None:
    """Refuse lines that part at a tension which they have at the start."""
    acting = {name: e.active for name, e in scene.forces.items() if e.active is not None}
    stages = state.modes[model.elements.triggers.mode :, MODE]
    for (name, active), stage in zip(acting.items(), stages, strict=False):
        end = active.until
        if end is None or end.channel is None or stage != AFTER:
            continue
        if end.channel.endswith(f"_tension.{name}"):
            raise InputError(
                f"forces.{name}.breaks_at: found {end.above:g} N, and a larger tension at the"
                " start, so that the line parts before it acts; expected a larger load. If the"
                " load is right, make the line longer or bring its ends closer together."
            )


def _check_springs(scene: Scene, model: Model, state: State) -> None:
    """Refuse springs whose ends coincide at the start."""
    motion = motion_at(model, state.y)
    p = SPRING_KIND.constants_in(model)
    for i, name in enumerate(spring_names(scene)):
        s = link_kinematics(p, i, state.y, motion, model.bodies)
        if s.place <= COINCIDENT_ENDS_RTOL * (s.place - s.x):
            raise _coincident_ends(name)


def _coincident_ends(name: str) -> InputError:
    return InputError(
        f"forces.{name}: its point and its anchor are at the same position at the start; expected"
        " different positions. `point` is in the frame of its body from the centre of gravity;"
        " `anchor` is in the earth frame, or in that of anchor_body."
    )
