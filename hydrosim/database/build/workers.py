"""Worker processes that end when their parent process ends.

Like those of `hydrosim.studies.many.executors`, they hold one end of a pipe, and the parent holds
the other. It closes however the parent ends. A thread watches it, because workers are in long calls
then.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from threading import Thread
from typing import Any

import joblib

WATCHED_END, HELD_END = Pipe(duplex=False)
"""Reading end that workers watch, and writing end that this process holds open."""


def compute_all(calls: Iterable[Any], jobs: int) -> Iterator[Any]:
    """Results of delayed ``calls`` in order, by ``jobs`` processes."""
    watch = {"initializer": _end_with, "initargs": (WATCHED_END,)} if jobs != 1 else {}
    return iter(joblib.Parallel(n_jobs=jobs, return_as="generator", **watch)(calls))


def _end_with(parent: Connection) -> None:
    """End this process as soon as the other end of a pipe is closed."""
    Thread(target=_wait_and_end, args=(parent,), daemon=True).start()


def _wait_and_end(parent: Connection) -> None:
    parent.poll(None)
    os._exit(1)
