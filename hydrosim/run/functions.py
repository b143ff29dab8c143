"""Functions of Python that act in a run: what its record says of them, and how a run that continues
another one, or a checkpoint, takes up what they remember.

A function that is called once per step may remember. It can be taken up if it has `get_state` and
`set_state`, and needs nothing if it is said to be repeatable. All others are refused.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.elements import externals_of, functions_at_stages
from hydrosim.elements.external import EXTERNAL_KIND as EXTERNALS
from hydrosim.elements.external import extrapolation_overshoots
from hydrosim.errors import InputError
from hydrosim.integrate.dynamics import new_work
from hydrosim.integrate.names import force_names
from hydrosim.integrate.record import unpack_channels
from hydrosim.integrate.state import RECORDS, Run
from hydrosim.multibody.kinematics import place_bodies
from hydrosim.results.validation import FUNCTION_STATES

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled
    from hydrosim.scene import Scene

EXTERNAL_FORCES = "external_forces"
"""Attribute: name, function, bodies and coupling of each external force, one a line."""
SEPARATOR = ": "
MAX_OVERSHOOT = 3.0
"""Extrapolated force over the largest that its function had returned. A line through the ends of
equal steps goes no further."""
WRENCH_RTOL = 1e-9  # of the largest component: wrenches this close are the same


def describe_functions(scene: Scene) -> str:
    """Description of all external forces of a scene, one a line."""
    every = externals_of(scene.forces).items()
    return "\n".join(f"{name}{SEPARATOR}{e.describe()}" for name, e in every)


def names_in(described: str) -> list[str]:
    """Names of the external forces in such a description."""
    return [line.split(SEPARATOR)[0] for line in described.splitlines()]


def states_of(scene: Scene) -> dict[str, Any]:
    """States of the functions that have them, by the name of their force. Raises InputError if
    JSON cannot hold them."""
    return {
        name: _state_of(name, function) for name, function in _functions_with_state(scene).items()
    }


def _state_of(name: str, function: Any) -> Any:
    try:
        return json.loads(json.dumps(function.get_state()))
    except Exception as error:  # of any type: the method is the user's
        raise InputError(
            f"forces.{name}: get_state fails ({type(error).__name__}: {error}); expected numbers,"
            " texts, lists and dictionaries of them, which JSON can hold."
        ) from error


def function_attributes(scene: Scene, time: float) -> dict[str, object]:
    """Attributes of a run that has reached this ``time`` [s]. States that cannot be had are left
    out: a run is not lost by them."""
    try:
        states = states_of(scene)
    except InputError:
        states = {}
    text = json.dumps({"time": float(time), "states": states}) if states else None
    return {EXTERNAL_FORCES: describe_functions(scene) or None, FUNCTION_STATES: text}


def restore_functions(
    scene: Scene, names: Iterable[str], states: Mapping[str, Any], source: str
) -> None:
    """Give the functions of the forces with these ``names`` their ``states`` back. Raises
    InputError if one of them may remember and cannot be given its state."""
    externals = externals_of(scene.forces)
    for name in names:
        e = externals.get(name)
        if e is None or not e.delayed or e.repeatable:
            continue
        if not e.restarts:
            raise InputError(
                f"forces.{name}: its function is called once per step and may remember, but"
                f" {source} does not hold what. Give it methods get_state and set_state, or say"
                " UserForce(..., repeatable=True) if it depends on its arguments alone."
            )
        if name not in states:
            raise InputError(
                f"forces.{name}: {source} holds no state of its function at that time; expected"
                " one from get_state. Continue from the end of a run whose function has it."
            )
        function: Any = e.function
        function.set_state(states[name])


def resume_functions(compiled: Compiled) -> Compiled:
    """A compiled scene that may continue an earlier run: its functions are as they were then.
    A force that acted then and is missing now is a warning. Raises InputError if the state of a
    function cannot be kept or restored."""
    scene = compiled.scene
    states_of(scene)  # before anything is computed
    start = scene.initial
    attributes = getattr(start.run, "attrs", {}) if start else {}
    before = names_in(str(attributes.get(EXTERNAL_FORCES, "")))
    if start is None or not before:
        return compiled
    states_then = json.loads(str(attributes.get(FUNCTION_STATES, "{}")))
    there = bool(states_then) and np.isclose(
        states_then["time"], compiled.begin, rtol=1e-9, atol=1e-9
    )
    restore_functions(scene, before, states_then["states"] if there else {}, "the earlier run")
    missing = [name for name in before if name not in scene.forces]
    texts = [
        f"initial.run: the function {name} gave a force in that run; here it gives none. Run the"
        f" case from Python with forces={{'{name}': hydrosim.UserForce(...)}} to go on with it."
        for name in missing
    ]
    return replace(compiled, notes=compiled.notes.with_warnings(texts))


def repeatability_warnings(compiled: Compiled, run: Run) -> Iterator[str]:
    """Warnings about functions that are called at stages and now give another wrench at the start
    than they gave then: they remember, or depend on something else."""
    scene = compiled.scene
    model = run.model
    stages = [e for e in externals_of(scene.forces).values() if not e.delayed]
    if not stages or run.counters[RECORDS] == 0:
        return
    start = unpack_channels(model, run.record, 1)
    n = model.bodies.active.size
    q, u = np.split(start["y"][: 2 * n][0], 2)
    motion = new_work(model).motion
    place_bodies(q.copy(), u.copy(), model.bodies, motion)
    time = float(start["time"][0])
    again = functions_at_stages(time, motion, model.bodies, model.elements, model.rows)
    for e in stages:
        e.clear_error()  # an error here is no error of the run
    for row, wrench in again.items():
        then = start["wrench"][0, row]
        if not np.allclose(wrench, then, rtol=WRENCH_RTOL, atol=WRENCH_RTOL * np.abs(then).max()):
            yield (
                f"the function of {force_names(scene)[row]} gives another force for the start, at"
                f" {time:g} s, when it is asked again after the run; expected the same, because it"
                " is called at every stage, in no order of time. It remembers: choose coupling"
                " held or extrapolated."
            )


def delay_warnings(compiled: Compiled, run: Run) -> Iterator[str]:
    """Warnings about external forces that were continued far beyond what their functions had
    returned."""
    for row, overshoot in extrapolation_overshoots(EXTERNALS.constants_in(run.model), run.state.y):
        if overshoot > MAX_OVERSHOOT:
            yield (
                f"the force of {force_names(compiled.scene)[row]} was continued to"
                f" {overshoot:.2g} times the largest that its function had returned; usual is up to"
                f" {MAX_OVERSHOOT:g}. Its function jumps, or changes at each call. Choose coupling"
                " held, or stage if it does not remember."
            )


def _functions_with_state(scene: Scene) -> dict[str, Any]:
    """The functions that give their state, by the name of their force."""
    every = externals_of(scene.forces).items()
    return {n: e.function for n, e in every if e.delayed and not e.repeatable and e.restarts}
