"""`digest`: a checksum of all data in a model or a scene, which changes with any bit."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

IGNORED_FIELDS = {"title", "source", "places"}  # of a scene: they change no number


def digest(tree: Any) -> str:
    """SHA-256 (hex) of nested tuples, lists, mappings and dataclasses with arrays, numbers and
    texts. Databases count by their checksum, datasets by their values."""
    checksum = hashlib.sha256()
    for leaf in _leaves(tree):
        if isinstance(leaf, np.ndarray) and not leaf.dtype.hasobject:
            checksum.update(f"{leaf.shape} {leaf.dtype.str};".encode())
            checksum.update(np.ascontiguousarray(leaf).tobytes())
        else:
            text = repr(leaf.tolist() if isinstance(leaf, np.ndarray) else leaf)
            checksum.update(f"{len(text)} {text};".encode("utf-8", "backslashreplace"))
    return checksum.hexdigest()


def _leaves(tree: Any) -> Iterator[Any]:
    if hasattr(tree, "checksum") and isinstance(tree.checksum, str):
        yield tree.checksum
    elif hasattr(tree, "data_vars"):  # a dataset; xarray is slow to load
        for name, variable in tree.variables.items():
            yield name
            yield variable.values
    elif is_dataclass(tree):
        yield type(tree).__name__
        for item in fields(tree):
            if item.name not in IGNORED_FIELDS:
                yield item.name
                yield from _leaves(getattr(tree, item.name))
    elif isinstance(tree, Mapping):
        yield from _leaves([part for item in tree.items() for part in item])
    elif isinstance(tree, tuple | list):
        yield len(tree)
        for branch in tree:
            yield from _leaves(branch)
    else:
        yield tree
