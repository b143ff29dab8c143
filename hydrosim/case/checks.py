"""What must agree between parts of a case that each are right by themselves."""

from __future__ import annotations

import os
from collections.abc import Iterator
from math import inf
from pathlib import Path

from hydrosim.case.hydrodynamics import accepted_of, files_of
from hydrosim.case.lines.element import Lines
from hydrosim.case.schema import CaseFile
from hydrosim.case.waves import (
    Components,
    ComponentsFile,
    DirectionalSea,
    RecordedSea,
    TableSea,
)
from hydrosim.files.messages import Keys, Problem, suggestion
from hydrosim.files.units import value_text
from hydrosim.files.yaml_nodes import with_hint
from hydrosim.scene.environment import CurrentPower, IrregularWaves
from hydrosim.scene.links import CoordinateElement
from hydrosim.scene.restraints import Drive
from hydrosim.scene.scene import arrange_joints
from hydrosim.scene.signal import RecordedColumns

# The output has forces of these names (`hydrosim.elements.kind`, which would load numba).
RESERVED = ("hydrostatic", "radiation", "wave_first_order", "wave_second_order", "weight")


RELATIVE = "relative paths begin at the folder of the file that they are in"


def check(case: CaseFile, folder: Path) -> Iterator[Problem]:
    """All contradictions in ``case``; relative paths in it are relative to ``folder``."""
    yield from _check_names(case)
    yield from _check_bodies(case)
    yield from _check_joints(case)
    yield from _check_accepted(case)
    yield from _check_waves(case)
    yield from _check_streams(case)
    yield from _check_files(case, folder)
    yield from _check_records(case, folder)
    yield from _check_steps(case)


def _check_names(case: CaseFile) -> Iterator[Problem]:
    for name in case.forces:
        if name in RESERVED:
            text = f'found the name "{name}"; expected another; the output has a force of that name'
            yield Problem(("forces", name), text)


def _check_bodies(case: CaseFile) -> Iterator[Problem]:
    if not any(body.dofs for body in case.bodies.values()):
        text = "found no degree of freedom in any body; expected one or more; nothing would move"
        yield Problem(("bodies",), text)
    for name, element in case.forces.items():
        if element.body is not None:  # what acts in a joint has none
            yield from _check_body(case, ("forces", name, "body"), element.body)
        if isinstance(element, Drive | CoordinateElement) and element.joint is not None:
            yield from _check_joint(case, ("forces", name, "joint"), element.joint)
        for keys, other, remedy in element.body_references():
            yield from _check_other(case, name, keys, other, remedy)


def _check_joint(case: CaseFile, keys: Keys, joint: str) -> Iterator[Problem]:
    if joint not in case.joints:
        joint_names = ", ".join(case.joints) or "there is none"
        text = f"found {value_text(joint)}; expected a joint of this case: {joint_names}"
        yield Problem(keys, with_hint(text, suggestion(joint, case.joints)))


def _check_other(
    case: CaseFile, name: str, keys: Keys, other: str | None, remedy: str
) -> Iterator[Problem]:
    """The body at the other side of an element, if there is one."""
    if other is None:
        return
    yield from _check_body(case, ("forces", name, *keys), other)
    if other == case.forces[name].body:
        text = f"found {value_text(other)} on both sides; expected another body, or none"
        yield Problem(("forces", name, *keys), f"{text}; {remedy}")


def _check_joints(case: CaseFile) -> Iterator[Problem]:
    """Bodies of joints, and degrees of freedom that joints give."""
    for name, joint in case.joints.items():
        if name in case.forces or name in RESERVED:
            text = f'found the name "{name}" of a force; expected another; both are in the output'
            yield Problem(("joints", name), text)
        yield from _check_body(case, ("joints", name, "body"), joint.body)
        if joint.to is not None:
            yield from _check_body(case, ("joints", name, "to"), joint.to)
        if joint.to == joint.body:
            text = f"found {value_text(joint.to)} on both sides; expected another body, or none"
            yield Problem(("joints", name, "to"), f"{text}; a joint without to is to the earth")
    body_names = {*case.bodies, None}
    if all({joint.body, joint.to} <= body_names for joint in case.joints.values()):
        yield from _check_tree(case)


def _check_tree(case: CaseFile) -> Iterator[Problem]:
    """Keys that bodies on joints, and joints that close loops, do not have."""
    joint_tree = arrange_joints(case.joints, list(case.bodies))
    for branch in joint_tree.branches:
        body = case.bodies[branch.child]
        if body.has_key("dofs"):
            text = f"found dofs of {branch.child}, which the joint {branch.name} carries; expected"
            remedy = "none; the joint leaves its motions free"
            yield Problem(("bodies", branch.child, "dofs"), f"{text} {remedy}")
        if body.has_key("initial"):
            text = f"found a start of {branch.child}, which the joint {branch.name} carries"
            remedy = f"expected none; give joints.{branch.name}.initial"
            yield Problem(("bodies", branch.child, "initial"), f"{text}; {remedy}")
    for name in joint_tree.loops:
        acting = [r for r in case.joints[name].resistances if r.acts or r.position or r.velocity]
        if acting:
            text = "found a spring, damping, stops, friction or a start in a joint that closes a"
            expected = "loop; expected none; give them to another joint of the loop, or list this"
            yield Problem(("joints", name), f"{text} {expected} joint first")


def _check_body(case: CaseFile, keys: Keys, body: str) -> Iterator[Problem]:
    if body not in case.bodies:
        text = f"found {value_text(body)}; expected a body of this case: {', '.join(case.bodies)}"
        yield Problem(keys, with_hint(text, suggestion(body, case.bodies)))


def _check_accepted(case: CaseFile) -> Iterator[Problem]:
    """Names of findings about databases, of which the checks know."""
    for name, body in case.bodies.items():
        for keys, finding in accepted_of(body.hydrodynamics):
            from hydrosim.database.checks import unknown_name_message  # loads numba

            if wrong := unknown_name_message(finding):
                yield Problem(("bodies", name, "hydrodynamics", *keys), wrong)


def _check_waves(case: CaseFile) -> Iterator[Problem]:
    wet = [name for name, body in case.bodies.items() if body.hydrodynamics is not None]
    if wet and case.environment is None:
        text = f"found no environment; expected one, because {wet[0]} has hydrodynamics"
        yield Problem((), f'{text}; add "environment: {{water_depth: infinite}}"')
    begin = case.begins.time or 0.0 if case.begins else 0.0
    end = begin + case.duration
    what = "the end of the run" if begin else "the duration"
    for i, waves in enumerate(case.environment.waves if case.environment else ()):
        if isinstance(waves, IrregularWaves) and waves.repeat_period < end:
            text = f"found {waves.repeat_period:g} s; expected {what} or more"
            keys = ("environment", "waves", i, "repeat_period")
            yield Problem(keys, f"{text}, {end:g} s; a shorter sea would repeat itself")
    gusts = case.environment and case.environment.wind and case.environment.wind.gusts
    if gusts and gusts.repeat_period < end:
        text = f"found {gusts.repeat_period:g} s; expected {what} or more"
        place = ("environment", "wind", "gusts", "repeat_period")
        yield Problem(place, f"{text}, {end:g} s; shorter gusts would repeat themselves")


def _check_streams(case: CaseFile) -> Iterator[Problem]:
    """A load, and nothing that makes it; a current over a depth that is not known."""
    water = case.environment
    profile = water.current.profile if water and water.current else None
    endless = isinstance(profile, CurrentPower) and profile.depth is None
    if water and endless and water.water_depth == inf:
        text = "found a power law in water of infinite depth; expected depth in it"
        place = ("environment", "current", "profile")
        yield Problem(place, f"{text}, that at which the current ends")
    for name, element in case.forces.items():
        stream = element.stream
        if stream and (case.environment is None or getattr(case.environment, stream) is None):
            text = f"found a {element.type} and no environment.{stream}; expected its speed and"
            yield Problem(("forces", name), f"{text} heading; a speed of 0 leaves the drag alone")


def _check_files(case: CaseFile, folder: Path) -> Iterator[Problem]:
    if case.begins is not None:
        wanted = "the result of `hydrosim run`"
        yield from _check_file(("initial", "run"), folder / case.begins.run, wanted)
    for name, body in case.bodies.items():
        for keys, file in files_of(body.hydrodynamics):
            place = ("bodies", name, "hydrodynamics", *keys)
            yield from _check_file(place, folder / file, "a hydrodynamic database")
    for name, element in case.forces.items():
        if isinstance(element, Lines):
            wanted = "an input file of MoorDyn or MoorPy"
            yield from _check_file(("forces", name, "file"), folder / element.file, wanted)
    for i, waves in enumerate(case.environment.waves if case.environment else ()):
        if isinstance(waves, TableSea | DirectionalSea) and waves.file is not None:
            keys = ("environment", "waves", i, "file")
            yield from _check_file(keys, folder / waves.file, "a wave spectrum")
        if isinstance(waves, Components) and isinstance(waves.components, ComponentsFile):
            place = ("environment", "waves", i, "components", "file")
            wanted = "components of a sea"
            yield from _check_file(place, folder / waves.components.file, wanted)


def _check_file(keys: Keys, path: Path, wanted: str) -> Iterator[Problem]:
    place = os.path.normpath(path)
    if not os.path.isfile(place):
        found_text = "a directory" if os.path.isdir(place) else "no such file"
        yield Problem(keys, f"found {found_text} at {place}; expected {wanted}; {RELATIVE}")


def recorded_series(case: CaseFile) -> Iterator[tuple[Keys, RecordedColumns]]:
    """All recorded series of a case, with the keys to them."""
    for name, element in case.forces.items():
        yield from ((("forces", name, *keys), form) for keys, form in element.recorded_series())
    for i, waves in enumerate(case.environment.waves if case.environment else ()):
        if isinstance(waves, RecordedSea):
            yield ("environment", "waves", i), waves


def _check_records(case: CaseFile, folder: Path) -> Iterator[Problem]:
    """Files that must be there; the run of a case need not be, but the case and a folder for it."""
    cases: dict[str, str | None] = {}
    for keys, form in recorded_series(case):
        if cases.setdefault(form.file, form.case) != form.case:
            text = f"found {form.file} as the run of {form.case} and of {cases[form.file]}"
            yield Problem((*keys, "case"), f"{text}; expected the same case wherever it is read")
        key, name = ("file", form.file) if form.case is None else ("case", form.case)
        path = os.path.normpath(folder / name)
        if not os.path.isfile(path):
            found_text = "a directory" if os.path.isdir(path) else "no such file"
            expected = {"file": "a recorded series", "case": "the case that the file is a run of"}
            text = f"found {found_text} at {path}; expected {expected[key]}"
            yield Problem((*keys, key), f"{text}; {RELATIVE}")
        elif not os.path.isdir(home := (folder / form.file).parent):
            yield Problem((*keys, "file"), f"found no folder {home}; expected it; make it first")


def _check_steps(case: CaseFile) -> Iterator[Problem]:
    step = case.solver.step
    if step > case.duration:
        text = f"found {step:g} s; expected no more than the duration, {case.duration:g} s"
        yield Problem(("solver", "step"), text)
    if case.output.step is not None and not case.solver.method.adapts:
        steps = case.output.step / step
        if round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps:
            near = max(1, round(steps)) * step
            text = f"found {case.output.step:g} s; expected a multiple of solver.step, {step:g} s"
            yield Problem(("output", "step"), f'{text}; "{near:g} s" is one')
