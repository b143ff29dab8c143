"""Tasks of a set of runs, the data that they share, and what must be the same for a set to go on.

Databases are read once, and a scene that differs from the one before it in its waves alone takes
over its compiled model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from hydrosim.compile.compile import compile_calm, without_symmetric_motions
from hydrosim.compile.databases import Source, database_groups, open_database
from hydrosim.compile.families import scene_groups
from hydrosim.compile.questions.waters import OUTSIDE_REFUSED, outside_range_text
from hydrosim.compile.restart import memory_before, opened_start
from hydrosim.compile.symmetry import wave_asymmetries
from hydrosim.compile.validate_scene import check_scene
from hydrosim.database.database import HydroDatabase, all_headings
from hydrosim.errors import HydrosimError, InputError
from hydrosim.files.yaml_nodes import source_context
from hydrosim.run.checkpoint import IGNORED_FIELDS, digest, program_identity
from hydrosim.run.step_limits import add_step_warnings
from hydrosim.scene import Body, Coefficients, Family, Question, Scene, Start
from hydrosim.water.components import WaveComponents, sea
from hydrosim.water.database_limits import shares_outside

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled
    from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup


def are_scenes_equal(first: object, second: object) -> bool:
    """Whether two scenes, or parts of them, have the same data. What is no data, such as a
    function, is the same only if it is one object."""
    if first is second:
        return True
    if is_dataclass(first) and type(first) is type(second):
        compared = (field.name for field in fields(first) if field.compare)
        return all(are_scenes_equal(getattr(first, n), getattr(second, n)) for n in compared)
    return digest(first) == digest(second)


def without_waves(scene: Scene) -> Scene:
    """The scene without what its model and its names do not depend on."""
    return replace(scene, title="", source={}, environment=scene.environment.without_waves())


class RunTask(NamedTuple):
    """A run to make, here or in another process: its scene without bodies and start, which the
    compiled scene ``calm`` has; whether it ``estimates`` its error. What is compiled is sent
    apart."""

    scene: Scene
    calm: Compiled | None
    estimates: bool = False


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
        """The task of a scene, or why there is none. Its run ``estimates`` its error, or does
        not."""
        calm = without_waves(scene)
        if self._calm is None or not are_scenes_equal(calm, self._calm):
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
        # what is read from files is in the compiled scene: netCDF knows no threads
        scene = replace(scene, bodies=(), initial=None, solver=compiled.scene.solver)
        return RunTask(scene, compiled, estimates)

    def _compile_without_waves(self, scene: Scene, drawn: Sequence[WaveComponents]) -> Compiled:
        """A scene in calm water, in the plane of symmetry that its sea leaves. What is wrong with
        it is found once for all of its seeds."""
        self._wet = self._wet or tuple(scene_groups(scene, drawn, memory_before(scene)))
        asymmetries = self._find_asymmetries(scene, drawn)
        if self._made is None or self._made[0] != asymmetries:
            compiled: Compiled | Exception
            try:
                calm = without_symmetric_motions(compile_calm(scene, self._wet), drawn)
                compiled = add_step_warnings(calm)
            except Exception as error:
                compiled = error
            self._made = asymmetries, compiled
        compiled = self._made[1]
        if isinstance(compiled, Exception):
            raise compiled
        return compiled

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
        if self._start is None or not are_scenes_equal(self._start[0], scene.initial):
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


# Energy of seas outside the frequencies of a database, told once for all runs.

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


# What must be the same for a set to go on.


def identity(
    scenes: Sequence[Scene],
    opened: Callable[[Scene], Scene],
    labels: Mapping[str, Any],
    asked: Mapping[str, Any],
) -> dict[str, str]:
    """What must be the same for a set to go on, by what it is called in a message: of the scenes,
    what they have in common looked at once; the ``labels`` of the runs; what is ``asked`` of
    each."""
    read: dict[int, Any] = {}
    hulls: dict[tuple[int, int], str] = {}
    parts: dict[int, str] = {}
    names = [f.name for f in fields(Scene) if f.name not in {*IGNORED_FIELDS, "bodies", "initial"}]
    cases = []
    for scene in scenes:
        key = id(scene.bodies), id(scene.initial)
        if key not in hulls:
            hulls[key] = digest(_body_data(scene, opened, read))
        values = [getattr(scene, name) for name in names]
        parts.update((id(value), digest(value)) for value in values if id(value) not in parts)
        cases.append(" ".join([hulls[key], *(parts[id(value)] for value in values)]))
    return {
        "the program": program_identity(),
        "a database, or the run to start from": digest(list(read.values())),
        "what is kept of the runs": digest(dict(asked)),
        "the seeds or parameters": digest((len(scenes), dict(labels))),
        "the cases": digest(cases),
    }


def _body_data(scene: Scene, opened: Callable[[Scene], Scene], read: dict[int, Any]) -> Any:
    """Bodies, and the numbers of the files that they and the start are ``read`` from; or what is
    wrong with these."""
    try:
        opened_scene = opened(scene)
    except HydrosimError as error:
        return str(error)
    files = [*(body.hydrodynamics for body in opened_scene.bodies), opened_scene.initial]
    read.update({id(file): file for file in files})
    bodies = tuple(replace(body, hydrodynamics=None) for body in opened_scene.bodies)
    return bodies, [list(read).index(id(file)) for file in files]
