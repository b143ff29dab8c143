"""What the runs of a set have in common is made once: databases are read once, and a scene that
differs from the one before it in its waves alone takes over its compiled model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from hydrosim.compile.compile import compile_calm, without_symmetric_motions
from hydrosim.compile.databases import Source, database_groups, open_database
from hydrosim.compile.families import all_groups
from hydrosim.compile.questions.waters import OUTSIDE_REFUSED, outside_range_text
from hydrosim.compile.restart import memory_before, opened_start
from hydrosim.compile.symmetry import wave_asymmetries
from hydrosim.compile.validate_scene import check_scene
from hydrosim.database.database import HydroDatabase, all_headings
from hydrosim.errors import InputError
from hydrosim.files.yaml_nodes import source_context
from hydrosim.run.step_limits import add_step_warnings
from hydrosim.scene import Body, Coefficients, Family, Question, Scene, Start
from hydrosim.study.run_layout import scenes_equal
from hydrosim.water.components import WaveComponents, sea
from hydrosim.water.database_limits import shares_outside

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled
    from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup

# `RunTask`: what it takes to make one run of many, here or in another process.


class RunTask(NamedTuple):
    """A scene, the sea drawn of its waves, and all else compiled; whether its run ``estimates`` its
    error."""

    scene: Scene
    sea: tuple[WaveComponents, ...]
    calm: Compiled
    estimates: bool = False


class PackedTask(NamedTuple):
    """What another process must be sent of a work, beside its compiled model."""

    scene: Scene
    estimates: bool


def pack_task(work: RunTask) -> PackedTask:
    """The work without its sea and its compiled model."""
    return PackedTask(replace(work.scene, bodies=(), initial=None), work.estimates)


def unpack_task(packed: PackedTask, calm: Compiled) -> RunTask:
    """A work that was packed. Its sea is drawn again from its seeds."""
    scene = replace(packed.scene, bodies=calm.scene.bodies, initial=calm.scene.initial)
    return RunTask(scene, sea(scene.environment), calm, packed.estimates)


class SceneCache:
    """Compiles what each scene has in common with the one before it only once; reads databases, and
    the run to start from, only once."""

    def __init__(self) -> None:
        self._databases: dict[Source, HydroDatabase] = {}
        self._start: tuple[Start, Start] | None = None
        self._calm: Scene | None = None
        self._wet: tuple[HydrodynamicGroup, ...] = ()
        self._made: tuple[list[str], Compiled | Exception] | None = None
        self._known: dict[bytes, list[str]] = {}

    def compile_task(self, scene: Scene, estimates: bool = False) -> RunTask | Exception:
        """A scene in calm water and its sea, or why there is none. Its run ``estimates`` its error,
        or does not."""
        calm = replace(scene, title="", source={})
        calm = replace(calm, environment=scene.environment.without_waves())
        if self._calm is None or not scenes_equal(calm, self._calm):
            self._calm = calm
            self._wet = ()
            self._made = None
            self._known.clear()
        try:
            with source_context(scene.places):
                check_scene(scene)
                scene = self.open_sources(scene)
                drawn = sea(scene.environment)
                compiled = self._compile_without_waves(scene, drawn)
        except Exception as error:
            return error
        # what is read from files is read: netCDF knows no threads
        compiled_scene = compiled.scene
        scene = replace(
            scene,
            bodies=compiled_scene.bodies,
            initial=compiled_scene.initial,
            solver=compiled_scene.solver,
        )
        return RunTask(scene, drawn, compiled, estimates)

    def _compile_without_waves(self, scene: Scene, drawn: Sequence[WaveComponents]) -> Compiled:
        """A scene in calm water, in the plane of symmetry that its sea leaves. What is wrong with
        it is found once for all of its seeds."""
        self._wet = self._wet or tuple(all_groups(scene, drawn, memory_before(scene)))
        asymmetries = self._find_asymmetries(scene, drawn)
        if self._made is None or self._made[0] != asymmetries:
            self._made = asymmetries, self._try_compiling(scene, drawn)
        compiled = self._made[1]
        if isinstance(compiled, Exception):
            raise compiled
        return compiled

    def _try_compiling(self, scene: Scene, drawn: Sequence[WaveComponents]) -> Compiled | Exception:
        """A scene in calm water, or why there is none."""
        try:
            return add_step_warnings(
                without_symmetric_motions(compile_calm(scene, self._wet), drawn)
            )
        except Exception as error:
            return error

    def _find_asymmetries(self, scene: Scene, drawn: Sequence[WaveComponents]) -> list[str]:
        """`wave_asymmetries`, which scenes with waves to the same headings have in common."""
        headings = np.unique([heading for waves in drawn for heading in waves.heading]).tobytes()
        if headings not in self._known:
            self._known[headings] = list(wave_asymmetries(scene, self._wet, drawn))
        return self._known[headings]

    def open_sources(self, scene: Scene) -> Scene:
        """A scene with its databases, and the run to start from, in memory."""
        bodies = tuple(map(self._open_body, scene.bodies))
        scene = replace(scene, bodies=bodies)
        if scene.initial is None:
            return scene
        if self._start is None or not scenes_equal(self._start[0], scene.initial):
            self._start = scene.initial, opened_start(scene.initial)
        return replace(scene, initial=self._start[1])

    def _open_body(self, body: Body) -> Body:
        source = body.hydrodynamics
        if source is None or isinstance(source, HydroDatabase | Coefficients):
            return body
        if isinstance(source, Family):
            members = [
                replace(member, source=self._open_database(member.source))
                for member in source.members
            ]
            return replace(body, hydrodynamics=Family(tuple(members)))
        return replace(body, hydrodynamics=self._open_database(source))

    def _open_database(self, source: Source) -> HydroDatabase:
        if source not in self._databases:
            self._databases[source] = open_database(source)
        return self._databases[source]


# What of the seas of many runs is outside the frequencies of a database, said once for all.

MIN_REPORTED_SHARE = 1e-3  # share of the energy of the loads that is worth a word


def describe_outside_ranges(scenes: Sequence[Scene]) -> list[str]:
    """Of each sea, whatever its seed, what is outside, in words, and in how many of the ``scenes``.
    Raises InputError where in all of them it is too much, and not accepted."""
    run_counts: Counter[str] = Counter()
    texts_by_sea: dict[object, list[tuple[str, float]]] = {}
    refused, shared = 0, SceneCache()
    for scene in scenes:
        key = _sea_and_hulls(scene)
        if key not in texts_by_sea:
            texts_by_sea[key] = _outside_ranges(scene, shared)
        accepted = Question.RANGE in scene.accept
        run_counts.update(
            _range_message(text, share, accepted) for text, share in texts_by_sea[key]
        )
        refused += any(share > OUTSIDE_REFUSED and not accepted for _, share in texts_by_sea[key])
    total = len(scenes)
    lines = [f"environment.waves: in {n} of {total} runs {text}" for text, n in run_counts.items()]
    if refused == total > 0:
        raise InputError("\n".join(lines))
    return lines


def _range_message(text: str, share: float, accepted: bool) -> str:
    if share <= OUTSIDE_REFUSED or accepted:
        return f"{text}: no first-order loads there"
    return (
        f"found {text}; usual is up to {OUTSIDE_REFUSED:.0%} of what loads it. These runs are"
        " refused. Use a database with a wider range, or other waves. If this is intended, accept:"
        " [range]."
    )


def _sea_and_hulls(scene: Scene) -> object:
    trains = tuple(replace(train, seed=0) for train in scene.environment.waves)
    return trains, tuple((body.hydrodynamics, body.wave_forces) for body in scene.bodies)


def _outside_ranges(scene: Scene, shared: SceneCache) -> list[tuple[str, float]]:
    """Texts and shares of what is left out, of each body that waves load; nothing where a run will
    say what is wrong with its databases or its sea."""
    try:
        seas = sea(scene.environment)
        used = database_groups(shared.open_sources(scene)) if seas else []
    except InputError:
        return []
    texts = []
    for group in used:
        range_loss = shares_outside(all_headings(group.database), seas)
        for body in group.bodies:
            if body.wave_forces.first_order and range_loss.share > MIN_REPORTED_SHARE:
                texts.append(
                    (outside_range_text(range_loss, body, group.database), range_loss.share)
                )
    return texts
