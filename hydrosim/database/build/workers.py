"""Processes that compute beside each other, and end when the one that asked them does.

As those of `hydrosim.studies.many.processes`, they hold one end of a pipe whose other end is here:
it closes however this process ends. They are in the midst of long calls then, so a thread watches.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from threading import Thread
from typing import Any

import joblib

WATCHED, HELD = Pipe(duplex=False)
"""The end that workers watch, and the one that nobody writes to: this process holds it open."""


def compute_all(calls: Iterable[Any], jobs: int) -> Iterator[Any]:
    """The results of delayed ``calls`` in their order, by ``jobs`` processes."""
    watch = {"initializer": _end_with, "initargs": (WATCHED,)} if jobs != 1 else {}
    return iter(joblib.Parallel(n_jobs=jobs, return_as="generator", **watch)(calls))


def _end_with(parent: Connection) -> None:
    """End this process as soon as the other end of a pipe is closed."""
    Thread(target=_wait_and_end, args=(parent,), daemon=True).start()


def _wait_and_end(parent: Connection) -> None:
    parent.poll(None)
    os._exit(1)
