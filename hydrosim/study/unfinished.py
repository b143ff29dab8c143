"""Sets of runs on their way: what is complete of them is in the folder `RUNS.nc.partial`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import netCDF4

from hydrosim.errors import HydrosimError, InputError, unwritable
from hydrosim.files.outputs import check_folder
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
from hydrosim.scene import Scene

if TYPE_CHECKING:
    from hydrosim.files.outputs import Output


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
    """The journal of the set with this ``identity``, of this process alone, see `begun`. Nothing
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
