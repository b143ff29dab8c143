"""Checkpoints of unfinished runs, and digests of what they belong to.

A killed run continues from its checkpoint to the same numbers, to the bit. All data that change in
a run are in its arrays; a checkpoint is a copy of them. It is valid only for one model, start and
program, which it identifies by digests.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, is_dataclass
from difflib import unified_diff
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from hydrosim.elements import without_numbers
from hydrosim.errors import InputError, WritingError
from hydrosim.files.cache import program_version, versions
from hydrosim.files.outputs import Output, has_mark
from hydrosim.integrate.state import GRID_POINT, IN_PROGRESS, RECORDS, STATUS, Run
from hydrosim.jit.kernels import sources_digest
from hydrosim.jit.waiting import running_time
from hydrosim.results.validation import FUNCTION_STATES
from hydrosim.run.functions import describe_functions, restore_functions, states_of

if TYPE_CHECKING:
    from hydrosim.compile.compiled import Compiled

# `digest`: a checksum of all data in a model or a scene.

IGNORED_FIELDS = {"title", "source", "places"}  # texts of a scene: they change no number


def digest(tree: Any) -> str:
    """SHA-256 (hex) of nested tuples, lists, mappings and dataclasses with arrays, numbers and
    texts. Databases count by their checksum, datasets by their values."""
    checksum = hashlib.sha256()
    for leaf in _digest_leaves(tree):
        if isinstance(leaf, np.ndarray) and not leaf.dtype.hasobject:
            checksum.update(f"{leaf.shape} {leaf.dtype.str};".encode())
            checksum.update(np.ascontiguousarray(leaf).tobytes())
        else:
            text = repr(leaf.tolist() if isinstance(leaf, np.ndarray) else leaf)
            checksum.update(f"{len(text)} {text};".encode("utf-8", "backslashreplace"))
    return checksum.hexdigest()


def _digest_leaves(tree: Any) -> Iterator[Any]:
    if hasattr(tree, "checksum") and isinstance(tree.checksum, str):
        yield tree.checksum
    elif hasattr(tree, "data_vars"):  # a dataset; xarray is slow to load
        for name, variable in tree.variables.items():
            yield name
            yield variable.values
    elif is_dataclass(tree):
        yield type(tree).__name__
        for item in fields(tree):
            value = getattr(tree, item.name)
            is_text = isinstance(value, str | Mapping)
            if not (is_text and item.name in IGNORED_FIELDS):
                yield item.name
                yield from _digest_leaves(value)
    elif isinstance(tree, Mapping):
        yield from _digest_leaves([part for item in tree.items() for part in item])
    elif isinstance(tree, tuple | list):
        yield len(tree)
        for branch in tree:
            yield from _digest_leaves(branch)
    else:
        yield tree


CHECKPOINT_INTERVAL_S = 60.0  # s of wall time
MAX_COST_SHARE = 0.01  # of the wall time: largest cost of checkpoints
CASE_KEY = "case"


@dataclass(frozen=True)
class Checkpoint:
    """Settings of checkpoints. A run is saved ``every`` so many seconds of wall time, but at most
    one hundredth of the time is spent on it. With ``resume``, the run continues from an existing
    checkpoint. ``say`` receives messages."""

    output: Output
    every: float = CHECKPOINT_INTERVAL_S
    resume: bool = False
    say: Callable[[str], None] = field(default=lambda _: None)


def checkpoint_of(result: Output) -> Output:
    """Output for the checkpoints of a run that is to be written to ``result``. Raises InputError if
    another kind of file stands there; that is never replaced."""
    path = result.path.with_name(f"{result.path.name}.checkpoint")
    if os.path.lexists(path) and not has_mark(path, "checkpoint"):
        raise InputError(
            f"{path}: is not a checkpoint of this program; expected a checkpoint or no file"
            " beside the result of a run. Move it away, or give the result another name."
        )
    return result.output_at(path, "checkpoint").checked_output()


def program_identity() -> str:
    """Versions and digests of all parts of the program that numbers depend on."""
    return f"hydrosim {program_version()}, {versions()}, {sources_digest()}"


class CheckpointWriter:
    """Checkpoints of a ``run`` of a compiled scene."""

    def __init__(self, settings: Checkpoint, compiled: Compiled, run: Run) -> None:
        self._kept = settings
        self._compiled = compiled
        self._run = run
        self._before = 0.0
        self._start = running_time()
        self._next = perf_counter() + settings.every

    def begin(self) -> None:
        """Start the clock."""
        self._start = running_time()
        self._next = perf_counter() + self._kept.every

    @property
    def wall_time(self) -> float:
        """Seconds that the run has taken, including those before the checkpoint."""
        return self._before + running_time() - self._start

    def resume_run(self) -> None:
        """Restore the run from its checkpoint, if it is to continue. Raises InputError if the
        checkpoint is damaged, or belongs to another case, database or program."""
        path = self._kept.output.path
        if not path.exists():
            if self._kept.resume:
                self._kept.say(f"there is no checkpoint {path}: the run starts at the beginning")
        elif not self._kept.resume:
            self._kept.say(f"{path} belongs to an unfinished run: --resume continues it")
        else:
            self._before = self._restore(*_read_checkpoint(self._kept.output))
            done = self._run.counters[GRID_POINT] / self._run.clock.points
            self._kept.say(f"the run continues from {path}, {done:.1%} complete")

    def save_if_due(self) -> None:
        """Save the run if it is due."""
        if perf_counter() > self._next:
            self.save()

    def save(self) -> None:
        """Save the run, unless it has failed. A failure to write is reported."""
        begun = perf_counter()
        if self._run.counters[STATUS] != IN_PROGRESS:
            return
        try:
            self.write()
        except (WritingError, InputError) as error:
            self._kept.say(f"warning: {error} The run continues without a new checkpoint.")
        cost = perf_counter() - begun
        self._next = perf_counter() + max(self._kept.every, cost / MAX_COST_SHARE)

    def write(self) -> None:
        """Save the run; raises WritingError or InputError if that cannot be."""
        output = self._kept.output
        mark = np.frombuffer(output.mark.encode(), dtype=np.uint8)
        states = states_of(self._compiled.scene)
        texts_by_name = {**self._identity(), "wall_time": self.wall_time, FUNCTION_STATES: states}
        texts = json.dumps(texts_by_name)
        arrays = {f"a{k}": array for k, array in enumerate(_stored_arrays(self._run))}
        arrays = {"mark": mark, "texts": np.frombuffer(texts.encode(), dtype=np.uint8), **arrays}
        with output.write_complete() as path, path.open("wb") as file:
            np.savez(file, allow_pickle=False, **arrays)

    def _restore(self, texts: dict[str, Any], stored: dict[str, np.ndarray]) -> float:
        """Copy the ``stored`` arrays into the run; return the wall time until then."""
        self._check(texts)
        # the number of records comes first: it gives the length of the record
        self._run.counters[:] = stored["a0"]
        for k, array in enumerate(_stored_arrays(self._run)):
            array_then = stored.get(f"a{k}")
            if array_then is None or (array_then.shape, array_then.dtype) != (
                array.shape,
                array.dtype,
            ):
                raise _damage_error(self._kept.output, f"a{k} has changed")
            array[...] = array_then
        scene = self._compiled.scene
        restore_functions(scene, scene.forces, texts.get(FUNCTION_STATES, {}), "the checkpoint")
        return float(texts["wall_time"])

    def _identity(self) -> dict[str, str]:
        """Digests that must agree, by their names in messages."""
        compiled = self._compiled
        run = self._run
        databases = {
            f"the database of {', '.join(wet.names)}": wet.read.checksum for wet in compiled.wet
        }
        model = run.model._replace(elements=without_numbers(run.model.elements))
        return {
            "the program": program_identity(),
            **databases,
            "the case": digest((run.clock, model, run.method, compiled.state)),
            "the external forces": describe_functions(compiled.scene),
            CASE_KEY: compiled.scene.source.get(CASE_KEY, ""),
        }

    def _check(self, stored: dict[str, str]) -> None:
        identity = self._identity()
        changed = [
            name for name in identity if name != CASE_KEY and stored.get(name) != identity[name]
        ]
        if not changed:
            return
        lines = _changes_text(stored.get(CASE_KEY, ""), identity[CASE_KEY])
        raise InputError(
            f"--resume: {' and '.join(changed)} changed after {self._kept.output.path} was"
            f" written; expected no change.{lines} Undo the change, or run from the start without"
            " --resume."
        )


def _stored_arrays(run: Run) -> Iterator[np.ndarray]:
    """All arrays of a run that change, counters first; of the record, the part in use."""
    yield run.counters
    count = int(run.counters[RECORDS])
    yield run.record.channels[:count]
    yield run.record.modes[:count]
    for part in (run.state, run.scratch, run.work):
        yield from (leaf for leaf in _leaves_of_tree(part) if isinstance(leaf, np.ndarray))
    record = run.record
    yield record.accelerations[:count]
    rows = -(-count // record.spacing)
    for rare in (record.remembered, record.memory):
        yield rare[:rows]
        yield rare[-1:]


def _leaves_of_tree(tree: Any) -> Iterator[Any]:
    if isinstance(tree, tuple):
        for branch in tree:
            yield from _leaves_of_tree(branch)
    else:
        yield tree


def _read_checkpoint(output: Output) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Texts and arrays of a checkpoint. Raises InputError if it is damaged or no checkpoint."""
    try:
        with np.load(output.path, allow_pickle=False) as stored:
            arrays = {name: stored[name] for name in stored.files}
        return dict(json.loads(arrays["texts"].tobytes())), arrays
    except Exception as error:  # a damaged archive raises exceptions of many types
        raise _damage_error(output, error) from None


def _damage_error(output: Output, problem_text: object) -> InputError:
    text = f"--resume: {output.path} is damaged ({problem_text}). Run again without --resume."
    return InputError(text)


def _changes_text(before: str, now: str) -> str:
    """First lines that differ between two texts of a case."""
    lines = unified_diff(before.splitlines(), now.splitlines(), n=0, lineterm="")
    changed = [line for line in lines if line[0] in "+-" and line[:3] not in ("+++", "---")]
    told = "; ".join(
        f"{'now' if line[0] == '+' else 'then'}: {line[1:].strip()}" for line in changed[:2]
    )
    return f" Differences of the case: {told}." if told else ""
