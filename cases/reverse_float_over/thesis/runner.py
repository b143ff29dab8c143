"""Computes the figures of every table, variant and seed on all cores, and keeps them.

A line of ``benchmarks/results/thesis/TABLE.jsonl`` has the figures of one run. A run is not made
again while the program, the cases, the table's module and the settings are the same.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass
from functools import cache
from hashlib import sha256
from importlib import import_module
from multiprocessing import get_context
from pathlib import Path
from statistics import median
from time import perf_counter, process_time
from typing import Any

from benchmarks.report import RESULTS, ROOT
from hydrosim.errors import SimulationError
from hydrosim.files.cache import digest_of_sources, versions

KEPT = RESULTS / "thesis"
MEASURED = Path(__file__).parent / "measured"
EVERY = 10.0  # s between two lines of progress

Figures = Mapping[str, float]


@dataclass(frozen=True)
class Task:
    """One run: the ``table`` it belongs to, its ``variant`` and the ``seed`` of its waves."""

    table: str
    variant: str
    seed: int

    def __str__(self) -> str:
        return f"{self.table}, {self.variant}, seed {self.seed}"


@dataclass(frozen=True)
class Record:
    """Figures of a run, the ``cpu`` time it took [s], and the digest of what it was made with."""

    table: str
    variant: str
    seed: int
    made_with: str
    cpu: float
    figures: Figures

    @property
    def task(self) -> Task:
        """The run that the figures are of."""
        return Task(self.table, self.variant, self.seed)


def table_module(table: str) -> Any:
    """The module of a table."""
    return import_module(f"cases.reverse_float_over.thesis.{table}")


def compute_missing(
    tables: Sequence[str], seeds: Iterable[int], workers: int, folder: Path = KEPT
) -> list[Record]:
    """Records of all runs of the tables. Runs that ``folder`` lacks are made, the first seed of all
    variants before the second."""
    tasks = list(_tasks(tables, seeds))
    known = {record.task: record for table in tables for record in read_records(table, folder)}
    missing = [task for task in tasks if task not in known]
    for record in _with_progress(_compute(missing, workers), len(missing)):
        _append(record, folder)
        known[record.task] = record
    return [known[task] for task in tasks]


def complete_seeds(tables: Sequence[str], folder: Path = KEPT) -> list[Record]:
    """Records of the seeds that ``folder`` has all variants of a table of."""
    records = [record for table in tables for record in read_records(table, folder)]
    made: dict[tuple[str, int], int] = {}
    for record in records:
        key = record.table, record.seed
        made[key] = made.get(key, 0) + 1
    wanted = {table: len(table_module(table).VARIANTS) for table in tables}
    found = [r for r in records if made[r.table, r.seed] == wanted[r.table]]
    return sorted(found, key=_order)


def read_records(table: str, folder: Path = KEPT) -> list[Record]:
    """Records in the file of a table that this program would make again in the same way, the last
    of each run."""
    path = folder / f"{table}.jsonl"
    lines = path.read_text().splitlines() if path.exists() else []
    decoded = [_decoded(line) for line in lines]
    records = [record for record in decoded if record is not None and _holds(record)]
    return list({record.task: record for record in records}.values())


def compute(task: Task) -> Record:
    """Make the run. It is called in another process. A run that cannot continue has no figures."""
    start = process_time()
    try:
        figures = table_module(task.table).figures(task.variant, task.seed)
    except SimulationError as error:
        print(f"{task}: {error}", file=sys.stderr)
        figures = {}
    cpu = process_time() - start
    made = made_with(task.table, task.variant)
    return Record(task.table, task.variant, task.seed, made, cpu, figures)


@cache
def made_with(table: str, variant: str) -> str:
    """Digest of the settings of a variant and of all that turns them into figures."""
    settings = json.dumps(table_module(table).VARIANTS[variant], sort_keys=True, default=str)
    return sha256(f"{_digest_of_code(table)} {settings}".encode()).hexdigest()


def cpu_of_seed(records: Iterable[Record]) -> float:
    """CPU time of one seed of all variants [s]: the sum of their medians."""
    times: dict[str, list[float]] = {}
    for record in records:
        times.setdefault(record.variant, []).append(record.cpu)
    return sum(map(median, times.values()))


@cache
def _digest_of_code(table: str) -> str:
    """Digest of the program, the cases, the databases and the modules of a table."""
    here = Path(__file__).parent.relative_to(ROOT).as_posix()
    sources = [f"{here}/{name}.py" for name in sorted(_modules_of(table, set()))]
    data = [*ROOT.glob("cases/*/*.yaml"), *ROOT.glob("hydro_db/*.nc")]
    files = sorted(path.relative_to(ROOT).as_posix() for path in data)
    return f"{digest_of_sources(ROOT, 'hydrosim', *sources, *files)} {versions()}"


def _modules_of(name: str, known: set[str]) -> set[str]:
    """The ``known`` modules, a module of this package, and those that define functions and classes
    which it or they import."""
    package = f"{__package__}."
    known.add(name)
    values = vars(import_module(package + name)).values()
    names = {str(getattr(value, "__module__", "")) for value in values}
    own = {each.removeprefix(package) for each in names if each.startswith(package)}
    for other in own - known:
        _modules_of(other, known)
    return known


def _order(record: Record) -> tuple[str, int, int]:
    """Seed by seed, variants as the table has them."""
    variants = list(table_module(record.table).VARIANTS)
    return record.table, record.seed, variants.index(record.variant)


def _holds(record: Record) -> bool:
    """Whether this program would make the record again in the same way."""
    if record.variant not in table_module(record.table).VARIANTS:
        return False
    return record.made_with == made_with(record.table, record.variant)


def _tasks(tables: Sequence[str], seeds: Iterable[int]) -> Iterator[Task]:
    """Seed by seed. A table that says ``WITHOUT_SEA`` has one run of each variant."""
    for number, seed in enumerate(seeds):
        for table in tables:
            module = table_module(table)
            if number > 0 and getattr(module, "WITHOUT_SEA", False):
                continue
            for variant in module.VARIANTS:
                yield Task(table, variant, seed)


def _compute(tasks: Sequence[Task], workers: int) -> Iterator[Record]:
    """Records as they are done. The first run that fails ends all; what was done is kept."""
    if not tasks:
        return
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    with ProcessPoolExecutor(workers, mp_context=get_context("spawn")) as pool:
        futures = {pool.submit(compute, task): task for task in tasks}
        try:
            for future in as_completed(futures):
                try:
                    yield future.result()
                except Exception as error:
                    raise RuntimeError(f"the run of {futures[future]} failed: {error}") from error
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _append(record: Record, folder: Path) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / f"{record.table}.jsonl").open("a") as file:
        file.write(json.dumps(asdict(record)) + "\n")


def _decoded(line: str) -> Record | None:
    """None of a line that was cut short when the computer stopped."""
    try:
        return Record(**json.loads(line))
    except (ValueError, TypeError):
        return None


def _with_progress(records: Iterable[Record], total: int) -> Iterator[Record]:
    start = said = perf_counter()
    for done, record in enumerate(records, 1):
        now = perf_counter()
        if now - said > EVERY or done == total:
            said = now
            left = (now - start) / done * (total - done) / 60.0
            print(f"{done} of {total} runs, {left:.0f} min left: {record.task}", file=sys.stderr)
        yield record
