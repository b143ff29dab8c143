"""What `hydrosim check` says of a scene before it is run."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import ceil

from rich.console import JustifyMethod, RenderableType
from rich.markup import escape
from rich.table import Table

from hydrosim.compiling.model import compile_clock, compile_scene
from hydrosim.compiling.notes import Notes
from hydrosim.compiling.restart import begin, opened, resume, started_from
from hydrosim.compiling.symmetry import planar
from hydrosim.compiling.wet import radiation_of, with_states
from hydrosim.database import check as check_database
from hydrosim.linear.linearise import NaturalMode, linearise, natural_modes
from hydrosim.linear.linearity import propagated, solution
from hydrosim.scene import ConvolutionRadiation, Scene
from hydrosim.stepping.dynamics import Model
from hydrosim.stepping.stepper import State
from hydrosim.studies.simulation import scene_step_limits

CLOSE_ENOUGH = 1e-2  # tolerance of a fit for periods and damping ratios, where a run convolves


def survey(scene: Scene) -> Iterator[RenderableType]:
    """Size of the problem, databases, what is skipped, warnings, step limits, natural periods."""
    decided, given = Notes(), opened(scene)
    scene = planar(given, decided)
    if scene.initial is not None:
        compile_scene(scene)  # refuses what does not fit
    notes = Notes(symmetry=decided.symmetry, zero=decided.zero)
    model, state = _with_states(scene, notes)
    clock = compile_clock(scene, model)
    yield scene.title
    for key, value in started_from(scene).items():
        yield f"{key.replace('_', ' ')}: {value}"
    if any(isinstance(radiation_of(body), ConvolutionRadiation) for body in scene.bodies):
        yield "radiation by convolution; states are for step limits and natural periods alone"
    yield (
        f"{len(scene.bodies)} bodies, {model.bodies.active.size} free coordinates,"
        f" {model.states.decay.size} radiation states, {len(scene.forces)} force elements,"
        f" {model.size} states in all"
    )
    if notes.symmetry:
        yield f"solved {notes.symmetry}"
    yield solution(scene, model)
    if propagated(scene, model):
        yield f"{ceil(scene.duration / scene.output_step):,} records every {scene.output_step:g} s"
    elif clock.control.adaptive:
        yield f"adaptive steps by {scene.solver.method}, recorded every {clock.step:g} s"
    else:
        yield f"{clock.points:,} steps of {clock.step:g} s by {scene.solver.method}"
    for wet in notes.wet:
        yield f"{', '.join(wet.names)}:"
        for key, value in wet.provenance().items():
            yield f"  {key.replace('_', ' ')}: {value}"
        for finding in check_database(wet.database):
            if not finding.passed:
                figures = f"{finding.figure:.3g} > {finding.limit:.3g}"
                yield f"  {finding.name}: {figures}, {finding.advice}"
    for line in notes.records:
        yield f"recorded: {line}"
    for line in notes.skipped:
        yield f"skipped: {line}"
    for line in notes.warnings:
        yield f"warning: {line}"
    if not propagated(scene, model):
        yield from _limits(scene, model, state)
    if scene is not given:
        model, state = _with_states(given, Notes())
    yield _periods(scene, natural_modes(linearise(model, state, time=begin(scene))))


def _with_states(scene: Scene, notes: Notes) -> tuple[Model, State]:
    """The compiled scene, and its state at the start, with states instead of a convolution."""
    bodies = tuple(with_states(body, CLOSE_ENOUGH) for body in scene.bodies)
    model, state = compile_scene(replace(scene, bodies=bodies, initial=None), notes)
    return model, state if scene.initial is None else resume(scene, model, state)


def _limits(scene: Scene, model: Model, state: State) -> Iterator[str]:
    limits = scene_step_limits(scene, model, state, each_alone=True)
    for limit in limits:
        yield limit.describe(scene.solver.step)
    if not limits:
        yield f"no step is too large for {scene.solver.method} to be stable"


def _periods(scene: Scene, modes: Sequence[NaturalMode]) -> Table:
    table = Table(title="Natural periods at the start of the run")
    for heading in ("body", "mode", "natural period [s]", "damped period [s]", "damping ratio"):
        justify: JustifyMethod = "left" if heading in ("body", "mode") else "right"
        table.add_column(escape(heading), justify=justify, no_wrap=True)
    for mode in modes:
        table.add_row(
            scene.bodies[mode.coordinate // 6].name,
            mode.dof,
            f"{mode.natural_period:.2f}",
            f"{mode.damped_period:.2f}",
            f"{mode.damping_ratio:.3f}",
        )
    return table
