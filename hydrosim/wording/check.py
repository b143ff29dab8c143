"""What there is to say of a scene before it is run: `hydrosim check`, or `hydrosim.check`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil, isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from hydrosim.case import load_case
from hydrosim.compiling import sizes
from hydrosim.compiling.clock import compile_clock
from hydrosim.compiling.compile import compile_scene
from hydrosim.compiling.derived import solution
from hydrosim.compiling.hydrodynamic_groups import in_states
from hydrosim.compiling.notes import Notes
from hydrosim.compiling.restart import resumed_state, started_from
from hydrosim.compiling.without_waves import add_waves, compile_calm
from hydrosim.documents.places import add_source_lines, source_context
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import ModeKind, NaturalMode, natural_modes
from hydrosim.linear.stability import Watch, without_progress
from hydrosim.presentation.document import (
    Cell,
    Document,
    Heading,
    List,
    Node,
    Outcome,
    Part,
    Sentence,
    Table,
    Value,
    Verdict,
    warnings,
)
from hydrosim.presentation.units import units_of
from hydrosim.scene import Scene
from hydrosim.scene.trees import floating_roots
from hydrosim.stepping.names import coordinate_at
from hydrosim.studies.ballast.loading import with_contents_at
from hydrosim.studies.run.asked import check_criteria
from hydrosim.studies.run.resolution import accuracy_limit, scene_combinations
from hydrosim.studies.run.step_limits import scene_step_limits
from hydrosim.wording.joints import describe_drives, describe_joints
from hydrosim.wording.roll.damping import describe_roll_damping
from hydrosim.wording.run import radiation_verdict
from hydrosim.wording.start.floating import describe_floating, describe_lines

if TYPE_CHECKING:
    from hydrosim.case import Case
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.linear.stability import StepLimit

CLOSE_ENOUGH = 1e-2  # tolerance of a fit for periods and damping ratios, where a run convolves


def check_document(
    scene: Scene, times: Sequence[float] = (), watch: Watch = without_progress
) -> Document:
    """Verdicts on warnings, step and radiation; natural periods; in detail the size of the problem,
    databases and what is skipped. Step limits and periods are those of the start, of ``times`` [s]
    and, if tanks change, of the end. ``watch`` shows how far the search for step limits is."""
    own = compile_scene(scene, in_plane=True)
    with source_context(scene.places):
        check_criteria(own)
    compiled = with_linear_memory(own)
    whole = with_linear_memory(own.whole) if own.whole else compiled
    nodes: list[Node] = [*_verdicts(own, compiled, watch)]
    nodes += _lists({"Waves": own.notes.seas})
    nodes += describe_floating(own.whole or own)
    nodes += _lists({"Trees of joints": list(_describe_roots(own.scene))})
    nodes += describe_drives(own.scene, own.begin)
    nodes += _lists({"Wind and current": own.notes.streams, "Lines": own.notes.drag})
    nodes += describe_lines(own)
    nodes += _periods_of(whole, "at the start of the run")
    end = [compiled.begin + scene.duration] if own.model.tanks.each.size else []
    for time in sorted({*times, *end}):
        nodes += _limits_at(
            with_contents_at(compiled, time), with_contents_at(whole, time), watch, time
        )
    nodes += [Heading("Details", "details", detail=True), *_details(own, compiled)]
    return Document(scene.title, nodes, units=units_of(scene.source))


def check(case: Case | Scene | str | Path, times: Sequence[float] = ()) -> Document:
    """What `hydrosim check` prints of a case, of the case in a file or of a scene; `print` and
    notebooks show it. Step limits and natural periods are also those at ``times`` [s]. Raises
    InputError as `simulate` does."""
    read = load_case(case) if isinstance(case, str | Path) else case
    scene = read if isinstance(read, Scene) else read.scene()
    return check_document(scene, times)


def _verdicts(own: Compiled, compiled: Compiled, watch: Watch) -> Iterator[Node]:
    yield from warnings([add_source_lines(text, own.scene.places) for text in own.notes.warnings])
    if not own.facts.exact:
        yield from _of_step(compiled, watch)
    if isfinite(own.notes.radiation_error):
        yield radiation_verdict(own.notes.radiation_error)
    yield Sentence("{}.", [_capitalise(solution(own.scene, own.facts))])


def _of_step(compiled: Compiled, watch: Watch) -> Iterator[Node]:
    """Whether the step is stable, and what it resolves."""
    found = scene_combinations(compiled, each_alone=True, watch=watch)
    limits = scene_step_limits(compiled, found)
    solver = compiled.scene.solver
    yield from (_of_limit(limit, solver.step) for limit in limits)
    if not limits:
        yield Verdict(Outcome.GOOD, "{} is stable at any step.", [str(solver.method)])
    if not compiled.method.adapts:
        yield Sentence("{}.", [_capitalise(accuracy_limit(compiled, found))])


def _of_limit(limit: StepLimit, step: float) -> Verdict:
    stable = step <= limit.step
    text = (
        "The step of {} is stable: the largest stable step is {} ({}, {})."
        if stable
        else "The step of {} is UNSTABLE: the largest stable step is {} ({}, {})."
    )
    parts: list[Part] = [Value(step, "s", 3), Value(limit.step, "s", 3), limit.what, limit.contact]
    return Verdict(Outcome.GOOD if stable else Outcome.BAD, text, parts)


def _describe_roots(scene: Scene) -> Iterator[str]:
    """Roots of floating trees of bodies in water: their choice matters at second order."""
    wet = {body.name for body in scene.bodies if body.hydrodynamics is not None}
    for root, carried in floating_roots(scene).items():
        if len(wet & {root, *carried}) > 1:
            yield (
                f"{root} is the root of the floating tree with {', '.join(carried)}. Heading and"
                " restoring of the others are defined along the tree, so another root changes roll"
                " and pitch at second order. A joint makes its `to` the root"
            )


def _capitalise(text: str) -> str:
    """A text with a capital at its beginning. Names in it keep theirs."""
    return text[:1].upper() + text[1:]


def _limits_at(compiled: Compiled, whole: Compiled, watch: Watch, time: float) -> Iterator[Node]:
    """Step limits and natural periods at a ``time`` [s]."""
    yield Heading(f"At {time:g} s")
    if not compiled.facts.exact:
        yield from _of_step(compiled, watch)
    yield from _periods_of(whole, f"at {time:g} s", time)


def _periods_of(whole: Compiled, when: str, time: float | None = None) -> Iterator[Node]:
    linear = linearise(whole.model, whole.state, time=whole.begin if time is None else time)
    held = len(linear.constraints)
    when = f"{when}, {held} directions held" if held else when
    yield _periods(whole.scene, natural_modes(linear), when)


def _periods(scene: Scene, modes: Sequence[NaturalMode], when: str) -> Table:
    head = ("body", "mode", "natural period", "damped period", "damping ratio")
    return Table(head, [_mode(scene, mode) for mode in modes], f"Natural periods {when}")


def _mode(scene: Scene, mode: NaturalMode) -> list[Cell]:
    found = coordinate_at(scene, mode.coordinate)
    cells: list[Cell] = [found.body, found.dof]
    if mode.kind == ModeKind.FREE:
        return [*cells, "free", "", ""]
    cells.append(Value(mode.natural_period, "s"))
    if mode.kind != ModeKind.OSCILLATING:
        return [*cells, str(mode.kind), ""]
    return [*cells, Value(mode.damped_period, "s"), Value(mode.damping_ratio, digits=3)]


def _details(own: Compiled, compiled: Compiled) -> Iterator[Node]:
    """How large the problem is, how it is solved, what it reads and what is skipped."""
    notes = own.notes
    yield List(list(_size(own, compiled)))
    for wet in own.wet:
        said = [f"{key.replace('_', ' ')}: {value}" for key, value in wet.provenance().items()]
        yield List(said, ", ".join(wet.names))
    yield from _lists({"Joints": list(describe_joints(own.scene))})
    yield from _lists({"Roll damping": list(describe_roll_damping(own))})
    yield from _lists({"Radiation": notes.memory, "Recorded": notes.records})
    yield from _lists({"Where waves meet bodies": notes.meetings, "Skipped": notes.skipped})


def _lists(lists: dict[str, Sequence[str]]) -> Iterator[List]:
    return (List(items, title) for title, items in lists.items() if items)


def _size(own: Compiled, compiled: Compiled) -> Iterator[str]:
    scene = compiled.scene
    model = own.model
    for key, value in started_from(scene).items():
        yield f"{key.replace('_', ' ')}: {value}"
    yield (
        f"{len(scene.bodies)} bodies, {model.bodies.active.size} free coordinates,"
        f" {model.states.decay.size} radiation states, {len(scene.forces)} force elements,"
        f" {model.size} states in all"
    )
    memory = sizes.size_text(sizes.memory_needed(scene))
    yield f"about {memory} of memory, {sizes.size_text(sizes.result_size(scene))} of result"
    if own.notes.symmetry:
        yield f"solved {own.notes.symmetry}"
    if compiled is not own:
        yield "radiation by convolution; states are for step limits and natural periods alone"
    yield from _steps(own, compiled)


def _steps(own: Compiled, compiled: Compiled) -> Iterator[str]:
    scene = compiled.scene
    clock = compile_clock(compiled)
    if own.facts.exact:
        yield f"{ceil(scene.duration / scene.output_step):,} records every {scene.output_step:g} s"
    elif clock.control.adaptive:
        yield f"adaptive steps by {scene.solver.method}, recorded every {clock.step:g} s"
        if own.notes.method:
            yield f"chosen: {own.notes.method}"
    else:
        yield f"{clock.points:,} steps of {clock.step:g} s by {scene.solver.method}"


def with_linear_memory(compiled: Compiled) -> Compiled:
    """A compiled scene with states instead of a convolution, whose memory cannot be linearised."""
    if compiled.model.convolution.row.size == 0:
        return compiled
    scene, wet = in_states(compiled.scene, compiled.wet, CLOSE_ENOUGH)
    fresh = compile_calm(replace(scene, initial=None), wet)
    state = fresh.state
    if scene.initial is not None:
        state = resumed_state(scene, fresh.model, fresh.facts.layout, state)
    calm = Notes(symmetry=compiled.notes.symmetry, zero=compiled.notes.zero)
    return add_waves(replace(fresh, state=state, notes=calm), scene, compiled.sea)
