"""Who collects garbage while many runs are made."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def collected_here() -> Iterator[None]:
    """Leaves the collection of garbage to this thread: netCDF knows no threads, and a worker might
    come upon a file that somebody left open, and close it, while this thread writes. What is there
    before stays: to look through it again and again would take longer than short runs."""
    gc.collect()
    enabled = gc.isenabled()
    gc.disable()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
        if enabled:
            gc.enable()
