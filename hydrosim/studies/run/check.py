"""What `hydrosim check` says of a scene before it is run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil
from typing import TYPE_CHECKING

from rich.console import JustifyMethod, RenderableType
from rich.markup import escape
from rich.table import Table

from hydrosim.compiling import sizes
from hydrosim.compiling.calm import compile_calm, in_waves
from hydrosim.compiling.clock import compile_clock
from hydrosim.compiling.compile import compile_scene
from hydrosim.compiling.facts import solution
from hydrosim.compiling.notes import Notes
from hydrosim.compiling.restart import resume, started_from
from hydrosim.compiling.wet import in_states
from hydrosim.linear.linearise import linearise
from hydrosim.linear.modes import Kind, NaturalMode, natural_modes
from hydrosim.linear.stability import Watch, unwatched
from hydrosim.studies.ballast.loading import as_at
from hydrosim.studies.run.resolution import accuracy_limit, scene_combinations
from hydrosim.studies.run.step_limits import scene_step_limits

if TYPE_CHECKING:
    from hydrosim.compiling.compiled import Compiled
    from hydrosim.scene import Scene

CLOSE_ENOUGH = 1e-2  # tolerance of a fit for periods and damping ratios, where a run convolves


def survey(
    scene: Scene, times: Sequence[float] = (), watch: Watch = unwatched
) -> Iterator[RenderableType]:
    """Size of the problem, databases, what is skipped, warnings, step limits, natural periods; the
    limits and periods also as they are at ``times`` [s] and, if tanks change, at the end. ``watch``
    shows how far the search for step limits is."""
    own = compile_scene(scene, in_plane=True)
    compiled = linearisable(own)
    scene = compiled.scene
    model = own.model
    notes = own.notes
    clock = compile_clock(compiled)
    yield scene.title
    for key, value in started_from(scene).items():
        yield f"{key.replace('_', ' ')}: {value}"
    if compiled is not own:
        yield "radiation by convolution; states are for step limits and natural periods alone"
    yield (
        f"{len(scene.bodies)} bodies, {model.bodies.active.size} free coordinates,"
        f" {model.states.decay.size} radiation states, {len(scene.forces)} force elements,"
        f" {model.size} states in all"
    )
    memory = sizes.shown(sizes.memory(scene))
    size = sizes.shown(sizes.result(scene))
    yield f"about {memory} of memory, {size} of result"
    if notes.symmetry:
        yield f"solved {notes.symmetry}"
    yield solution(own.scene, own.facts)
    if own.facts.exact:
        yield f"{ceil(scene.duration / scene.output_step):,} records every {scene.output_step:g} s"
    elif clock.control.adaptive:
        yield f"adaptive steps by {scene.solver.method}, recorded every {clock.step:g} s"
        if notes.method:
            yield f"chosen: {notes.method}"
    else:
        yield f"{clock.points:,} steps of {clock.step:g} s by {scene.solver.method}"
    for wet in own.wet:
        yield f"{', '.join(wet.names)}:"
        for key, value in wet.provenance().items():
            yield f"  {key.replace('_', ' ')}: {value}"
    for line in own.notes.memory:
        yield f"radiation of {line}"
    for line in notes.records:
        yield f"recorded: {line}"
    for line in notes.meetings:
        yield line
    for line in notes.skipped:
        yield f"skipped: {line}"
    for line in notes.warnings:
        yield f"warning: {line}"
    whole = linearisable(own.whole) if own.whole else compiled
    yield from _linear(compiled, whole, "at the start of the run", watch)
    end = [compiled.begin + scene.duration] if model.tanks.each.size else []
    for time in sorted({*times, *end}):
        yield from _linear(as_at(compiled, time), as_at(whole, time), f"at {time:g} s", watch, time)


def _linear(
    compiled: Compiled, whole: Compiled, when: str, watch: Watch, time: float | None = None
) -> Iterator[RenderableType]:
    """Step limits of a run, and natural periods of the ``whole`` scene."""
    if not compiled.facts.exact:
        yield from (
            line if time is None else f"{when}: {line}" for line in _limits(compiled, watch)
        )
    linear = linearise(whole.model, whole.state, time=whole.begin if time is None else time)
    held = len(linear.constraints)
    when = f"{when}, {held} directions held" if held else when
    yield _periods(compiled.scene, natural_modes(linear), when)


def linearisable(compiled: Compiled) -> Compiled:
    """A compiled scene with states instead of a convolution, whose memory cannot be linearised."""
    if compiled.model.convolution.row.size == 0:
        return compiled
    scene, wet = in_states(compiled.scene, compiled.wet, CLOSE_ENOUGH)
    fresh = compile_calm(replace(scene, initial=None), wet)
    state = fresh.state
    if scene.initial is not None:
        state = resume(scene, fresh.model, fresh.facts.layout, state)
    calm = Notes(symmetry=compiled.notes.symmetry, zero=compiled.notes.zero)
    return in_waves(replace(fresh, state=state, notes=calm), scene, compiled.sea)


def _limits(compiled: Compiled, watch: Watch) -> Iterator[str]:
    found = scene_combinations(compiled, each_alone=True, watch=watch)
    limits = scene_step_limits(compiled, found)
    solver = compiled.scene.solver
    for limit in limits:
        yield limit.describe(solver.step)
    if not limits:
        yield f"no step is too large for {solver.method} to be stable"
    if not compiled.method.adapts:
        yield accuracy_limit(compiled, found)


def _periods(scene: Scene, modes: Sequence[NaturalMode], when: str) -> Table:
    table = Table(title=f"Natural periods {when}")
    for heading in ("body", "mode", "natural period [s]", "damped period [s]", "damping ratio"):
        justify: JustifyMethod = "left" if heading in ("body", "mode") else "right"
        table.add_column(escape(heading), justify=justify, no_wrap=True)
    for mode in modes:
        periods = ["free" if mode.kind == Kind.FREE else f"{mode.natural_period:.2f}", "", ""]
        if mode.kind == Kind.OSCILLATING:
            periods[1:] = [f"{mode.damped_period:.2f}", f"{mode.damping_ratio:.3f}"]
        elif mode.kind != Kind.FREE:
            periods[1] = str(mode.kind)
        table.add_row(scene.bodies[mode.coordinate // 6].name, mode.dof, *periods)
    return table
