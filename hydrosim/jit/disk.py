"""Machine code of kernels on disk: one file for each kernel and the types of its arguments.

numba's own disk cache trusts every file that it finds. It notices an edit of the file that defines
a kernel, but not of the files that this kernel calls into. It identifies a file by its path and
time.

Here the name of a file holds a hash of all that its code is made of (`hydrosim.jit.ingredients`).
So an edit gives new names to the kernels that it changes, and to no others. A damaged file is
compiled again (`hydrosim.files.cache`).
"""

from __future__ import annotations

import hashlib
import pickle
from collections.abc import Callable
from importlib import import_module
from typing import Any

from numba.core import sigutils
from numba.core.caching import _Cache
from numba.core.compiler import CompileResult
from numba.core.runtime import rtsys
from numba.core.serialize import dumps

from hydrosim.files.cache import limit_size, store, stored
from hydrosim.jit.ingredients import describe_type, digest_of_kernel
from hydrosim.jit.shipped import NO_MORE_FEATURES, PROCESSOR, read_shipped, shipped_files

MAX_STORED_BYTES = 500_000_000
"""Size of all stored kernels, also those of other versions: some ten times what all cases need."""

Name = tuple[str, str, Any]
"""Module and name of a `CompiledKernel`, and the types of its arguments."""

Machine = tuple[str, str, str]
"""Platform, processor and its features, as LLVM names them."""


class KernelFiles(_Cache):
    """The files of one kernel. ``folder`` returns the name of their common folder. ``calls``
    returns the wholes that compiled code calls: their doors are made first."""

    _limited = False  # whether this process has removed files beyond the size

    def __init__(
        self,
        kernel: Any,
        folder: Callable[[], str],
        calls: Callable[[Any], list[Name]],
    ) -> None:
        self._kernel = kernel
        self._folder = folder
        self._calls = calls

    @property
    def cache_path(self) -> str:
        return self._folder()

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the code for these types, or None if there is none. This loads no module that only
        the compiler needs, which would take a quarter of a second."""
        rtsys.initialize(target_context)
        content = self._content(sig, target_context.codegen().magic_tuple())
        if content is None:
            return None
        needed, code = pickle.loads(content)
        for module, name, args in needed:
            getattr(import_module(module), name).door(args)
        return CompileResult._rebuild(target_context, *code)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Store compiled code, unless it holds addresses of this process."""
        if not data.library.has_dynamic_globals:
            content = dumps((self._calls(data.library), _without_reports(data._reduce())))
            name = self._name(sig, data.codegen.magic_tuple())
            store(f"{self._folder()}/{name}", content)
            self._limit()

    def enable(self) -> None: ...

    def disable(self) -> None: ...

    def flush(self) -> None: ...

    def _limit(self) -> None:
        if not KernelFiles._limited:
            KernelFiles._limited = True
            limit_size("kernels-*/*", MAX_STORED_BYTES)

    def _content(self, sig: Any, machine: Machine) -> bytes | None:
        """Content of the file shipped with the package, or else of the file compiled here
        earlier."""
        platform, _, features = machine
        folder = self._folder()
        if files := shipped_files(folder, features):
            name = self._name(sig, (platform, PROCESSOR, NO_MORE_FEATURES))
            content = read_shipped(name, files[name]) if name in files else None
            if content is not None:
                return content
        return stored(f"{folder}/{self._name(sig, machine)}")

    def _name(self, sig: Any, machine: Machine) -> str:
        function = self._kernel.py_func
        args, returns = sigutils.normalize_signature(sig)
        described = [*map(describe_type, args), "" if returns is None else describe_type(returns)]
        made_of = repr((digest_of_kernel(self._kernel), described, machine))
        digest = hashlib.sha256(made_of.encode()).hexdigest()[:32]
        return f"{function.__module__}.{function.__qualname__}-{digest}.nbc"


def _without_reports(reduced: tuple[Any, ...]) -> tuple[Any, ...]:
    """Reduced form of numba's result, without its report of types and without the environments of
    its functions. Environments hold constants that are Python objects; kernels have none. Reading
    them takes longer than reading the code, and loads modules that only the compiler needs."""
    *code, _types, reload_init, _environments = reduced
    return (*code, "", reload_init, ())
