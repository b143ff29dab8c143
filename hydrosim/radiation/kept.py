"""Arrays stored on disk, so that slow computations run once.

A damaged file is made again, see `hydrosim.cache`.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping
from io import BytesIO
from typing import Any, TypeVar

import numpy as np

from hydrosim.cache import store, stored
from hydrosim.program import PACKAGE, digest_of_sources

Arrays = Mapping[str, np.ndarray]
T = TypeVar("T")


def kept(
    kind: str,
    settings: tuple[object, ...],
    make: Callable[[], T],
    to_arrays: Callable[[T], Arrays],
    of_arrays: Callable[[Arrays], T],
) -> T:
    """The result of ``make`` for the ``settings``, or the stored one from the folder ``kind`` of
    the cache.

    The file's name is a hash of the settings and of this package's sources. So the settings must
    include everything that the content depends on.
    """
    key = hashlib.sha256(repr((*settings, _version())).encode()).hexdigest()[:24]
    name = f"{kind}/{key}.npz"
    found = stored(name)
    if found is not None:
        with np.load(BytesIO(found), allow_pickle=False) as arrays:
            return of_arrays(dict(arrays))
    made = make()
    content = BytesIO()
    np.savez(content, **dict[str, Any](to_arrays(made)))
    store(name, content.getvalue())
    return made


def _version() -> str:
    """Hash of this package's sources: a change of the computation changes the file."""
    return digest_of_sources(PACKAGE, "radiation")
