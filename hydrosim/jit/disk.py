"""Machine code of kernels on disk: a file for each kernel and the types of its arguments.

numba's own disk cache takes what it finds for code, notices an edit of the file that a kernel is in
but not of those that it calls into, and knows a file by its place and time. Here all names begin
with a hash of all sources that may hold kernels, so that any edit there makes others, and what is
damaged is compiled again (`hydrosim.cache`).
"""

from __future__ import annotations

import hashlib
import os
import pickle
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from hydrosim.cache import store, stored
from hydrosim.jit.shipped import NO_MORE_FEATURES, PROCESSOR, shipped, shipped_files
from hydrosim.program import digest_of_sources

Name = tuple[str, str, Any]
"""Module and name of a whole, and the types of its arguments."""

Machine = tuple[str, str, str]
"""Platform, processor and its features, as LLVM names them."""


class Disk(_Cache):
    """The files of one kernel; ``folder`` names that of all, ``calls`` says of compiled code which
    wholes it calls: their doors are made first."""

    def __init__(
        self,
        function: Callable[..., Any],
        folder: Callable[[], str],
        calls: Callable[[Any], list[Name]],
    ) -> None:
        self._function = function
        self._folder = folder
        self._calls = calls

    @property
    def cache_path(self) -> str:
        return self._folder()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The code for these types, None if there is none. Nothing is loaded that only compilers
        need, which would take a quarter of a second."""
        rtsys.initialize(target_context)
        content = self._content(sig, target_context.codegen().magic_tuple())
        if content is None:
            return None
        needed, code = pickle.loads(content)
        for module, name, args in needed:
            getattr(import_module(module), name).door(args)
        return CompileResult._rebuild(target_context, *code)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled, unless it holds addresses of this process."""
        if not data.library.has_dynamic_globals:
            content = dumps((self._calls(data.library), _lean(data._reduce())))
            name = self._name(sig, data.codegen.magic_tuple())
            store(f"{self._folder()}/{name}", content)

    def enable(self) -> None: ...

    def disable(self) -> None: ...

    def flush(self) -> None: ...

    def _content(self, sig: Any, machine: Machine) -> bytes | None:
        """What came with the package, or else what was compiled here before."""
        platform, _, features = machine
        folder = self._folder()
        if files := shipped_files(folder, features):
            name = self._name(sig, (platform, PROCESSOR, NO_MORE_FEATURES))
            content = shipped(name, files[name]) if name in files else None
            if content is not None:
                return content
        return stored(f"{folder}/{self._name(sig, machine)}")

    def _name(self, sig: Any, machine: Machine) -> str:
        function = self._function
        what = repr((sig, machine, _source(function.__code__.co_filename)))
        digest = hashlib.sha256(what.encode() + function.__code__.co_code).hexdigest()[:32]
        return f"{function.__module__}.{function.__qualname__}-{digest}.nbc"


def _lean(reduced: tuple[Any, ...]) -> tuple[Any, ...]:
    """What numba writes of a result, without its report of types and without the environments of
    all functions in it: they hold constants that are Python objects, which kernels have none of.
    To read them takes longer than the code, and loads modules that only compilers need."""
    *code, _types, reload_init, _environments = reduced
    return (*code, "", reload_init, ())


def _source(file: str) -> str:
    """Of a kernel that may be in no folder of this package."""
    home, name = os.path.split(file)
    return digest_of_sources(Path(home), name)
