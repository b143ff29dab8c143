"""Tasks of a set of runs, data that they share, and the journal of an unfinished set.

Databases are read once, and a scene that differs from the one before it in its waves alone takes
over its compiled model."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import netCDF4
import numpy as np

from hydrosim.compile.compile import compile_calm, without_symmetric_motions
from hydrosim.compile.databases import Source, database_groups, open_database
from hydrosim.compile.families import scene_groups
from hydrosim.compile.questions.waters import OUTSIDE_REFUSED, outside_range_text
from hydrosim.compile.restart import memory_before, opened_start
from hydrosim.compile.symmetry import wave_asymmetries
from hydrosim.compile.validate_scene import check_scene
from hydrosim.database.database import HydroDatabase, all_headings
from hydrosim.errors import HydrosimError, InputError, unwritable
from hydrosim.files.outputs import Output, check_folder
from hydrosim.files.yaml_nodes import source_context
from hydrosim.results.journal import (
    Journal,
    identity_of,
    is_earlier,
    is_empty,
    is_part,
    remove_journal,
)
from hydrosim.results.runs_file import NOT_RUN
from hydrosim.run.checkpoint import IGNORED_FIELDS, digest, program_identity
from hydrosim.run.step_limits import add_step_warnings
from hydrosim.scene import Body, Coefficients, Family, Question, Scene, Start
from hydrosim.study.run_layout import are_scenes_equal
from hydrosim.water.components import WaveComponents, sea
from hydrosim.water.database_limits import shares_outside

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled
    from hydrosim.compile.hydrodynamic_groups import HydrodynamicGroup

# `RunTask`: data to make one run of many, here or in another process.


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
        self._wet = self._wet or tuple(scene_groups(scene, drawn, memory_before(scene)))
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


# Unfinished sets of runs: complete runs are in the folder `RUNS.nc.partial`.


def folder_of(result: Output) -> Path:
    """Where a set is kept until it is done."""
    return Path(f"{result.path}.partial")


@contextmanager
def locked_folder(result: Output) -> Iterator[Path]:
    """The folder of a set, of this process alone. Raises InputError where another one writes the
    same."""
    folder = folder_of(result)
    with result.hold_lock():
        check_folder(folder, is_part)
        yield folder


@contextmanager
def locked_journal(result: Output, resume: bool, identity: Mapping[str, str]) -> Iterator[Journal]:
    """The journal of the set with this ``identity``, of this process alone. Nothing
    stays of a set without a run. Raises WritingError where it cannot be written."""
    with locked_folder(result):
        try:
            journal = open_journal(result, resume, identity)
            try:
                yield journal
            finally:
                journal.close()
                if not len(journal):
                    journal.remove()
        except (OSError, RuntimeError) as error:  # netCDF raises RuntimeError
            raise unwritable(result.path, error) from None


def open_journal(result: Output, resume: bool, identity: Mapping[str, str]) -> Journal:
    """The journal of the set with this ``identity``: with what is there if it is to ``resume``,
    else a new one. Raises InputError where runs would be lost, or are of another set."""
    folder = folder_of(result)
    stored = identity_of(folder)
    if not (is_empty(folder) or resume or result.overwrite):
        raise InputError(
            f"{folder}: holds runs of a set that did not come to its end; --resume goes on from"
            " them (resume=True in Python), --overwrite begins anew."
        )
    if not resume:
        remove_journal(folder)
    elif is_earlier(folder):
        raise InputError(
            f"--resume: the runs in {folder} were kept by an earlier version of the program, in"
            " another form. Go on with that program, or begin anew with --overwrite."
        )
    elif stored and (changed := [name for name in identity if stored.get(name) != identity[name]]):
        raise InputError(
            f"--resume: these have changed since the runs in {folder} were made:"
            f" {'; '.join(changed)}. Restore them to go on, or begin anew with --overwrite, which"
            " replaces the finished runs."
        )
    folder.mkdir(exist_ok=True)
    return Journal(folder, identity)


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


def is_complete(path: Path) -> bool:
    """Whether all runs in the file of a set came to an end."""
    try:
        with netCDF4.Dataset(path) as runs:  # xarray reads all texts when it opens a file
            return not {NOT_RUN, "interrupted"} & {*runs["status"][:].tolist()}
    except (OSError, ValueError, RuntimeError, IndexError):
        return False
