"""How kernels become machine code: every piece of them is compiled once.

numba optimises and translates a kernel together with all kernels below it, once more for each
kernel above: for a tree of calls that is most of the time to compile. Here a kernel is one of two
things to the kernels that call it. A `Part` is kept as numba wrote it, until one that is run takes
it in; so it is optimised there, once. A `Whole` is machine code of its own, and others know no more
of it than its name and its types.

Names of machine code hold in one process. So what is cached on disk of a whole says also which
others it calls by name, and those are loaded first.
"""

from __future__ import annotations

import copy
import hashlib
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from typing import Any

from llvmlite import binding
from numba.core import compiler, typing
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.registry import CPUDispatcher

from hydrosim.refs import Ref

OPTIONS: dict[str, Any] = {
    "nopython": True,
    "error_model": "numpy",  # its rules for division
    "nogil": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}


class _PartCode(JITCodeLibrary):
    """Code that is to become a part of others: neither optimised nor executable."""

    def finalize(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration:
                function.linkage = "linkonce_odr"  # gone where nothing calls it any more
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        self._ensure_finalized()
        return self._final_module


class _WholeCode(JITCodeLibrary):
    """Machine code of a kernel with all its parts."""

    def finalize(self) -> None:
        self._linking_libraries = list(dict.fromkeys(_below(self)))
        super().finalize()


def _below(library: Any) -> Iterator[Any]:
    """All that is linked into a library, parts of parts included."""
    for other in library._linking_libraries:
        yield other
        if isinstance(other, _PartCode):
            yield from _below(other)


class _WholeCompiler(compiler.Compiler):
    def compile_extra(self, func: Any) -> Any:
        self.state.library = _WholeCode(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        if any(isinstance(arg, Ref) for arg in self.state.args):  # not for Python
            self.state.flags.no_cpython_wrapper = True
        return super().compile_extra(func)


class _Cached(CompileResultCacheImpl):
    """What is on disk of a whole: its code, and before it the wholes that it calls by name."""

    def reduce(self, cres: Any) -> Any:
        functions = cres.library._final_module.functions
        return [_named[f.name] for f in functions if f.name in _named], super().reduce(cres)

    def rebuild(self, target_context: Any, payload: Any) -> Any:
        needed, code = payload
        for module, name, args in needed:
            getattr(import_module(module), name).compile(args)
        return super().rebuild(target_context, code)


class _Cache(FunctionCache):
    _impl_class = _Cached


_named: dict[str, tuple[str, str, Any]] = {}
"""Module, name and types of the arguments of wholes, by the names of their machine code."""


class _Flags(compiler.Flags):
    """Options of a compile, never changed: numba looks up what it inferred before by comparing all
    of them, which takes long, and makes copies to be safe."""

    __hash__ = object.__hash__
    __eq__ = object.__eq__

    def copy(self) -> _Flags:
        return self


@cache
def _part_flags(fastmath: frozenset[str]) -> Any:
    """Options of parts: they are not compiled to the end."""
    flags: Any = _Flags()
    options = {**OPTIONS, "forceinline": True, "fastmath": set(fastmath)}
    CPUDispatcher.targetdescr.options.parse_as_flags(flags, options)
    flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    return flags


class Part(CPUDispatcher):
    """A kernel whose code becomes a part of the kernels that call it. Called from Python it is
    machine code with its own parts."""

    fastmath: frozenset[str] = frozenset()

    def __init__(self, function: Any) -> None:
        options = {**OPTIONS, "fastmath": set(self.fastmath)}
        super().__init__(function, targetoptions=options, pipeline_class=_WholeCompiler)
        self._parts: dict[Any, Any] = {}
        self._cache = _Cache(function)

    def get_call_template(self, args: Any, kws: Any) -> Any:
        pysig, args = self.fold_argument_types(args, kws)
        if args not in self._parts:
            self._parts[args] = self._part(args)
        name, known = self.py_func.__name__, [self._parts[args].signature]
        return typing.make_concrete_template(name, name, known), pysig, args, {}

    def get_overload(self, sig: Any) -> Any:
        return self._parts[tuple(sig)].fndesc

    def _part(self, args: Any) -> Any:
        context: Any = self.targetctx
        code = _PartCode(context.codegen(), self.py_func.__qualname__)
        result = compiler.compile_extra(
            self.typingctx, context, self.py_func, args, None, _part_flags(self.fastmath), {}, code
        )
        context.insert_user_function(result.fndesc, result.fndesc, [code])
        return result


class Summing(Part):
    """A part whose sums may be taken in any order."""

    fastmath = frozenset({"reassoc", "contract"})


class Whole(CPUDispatcher):
    """A kernel that is machine code of its own, for Python and for the kernels that call it."""

    def __init__(self, function: Any) -> None:
        super().__init__(function, targetoptions=OPTIONS, pipeline_class=_WholeCompiler)
        self._names: dict[Any, str] = {}
        self._cache = _Cache(function)

    def add_overload(self, cres: Any) -> None:
        super().add_overload(cres)
        here, args = copy.copy(cres.fndesc), tuple(cres.signature.args)
        place = f"{here.modname}.{here.qualname}"
        types = hashlib.sha256(str(cres.signature).encode()).hexdigest()[:16]
        here.mangled_name = self._names[args] = f"{place}.{types}"
        code = cres.library.get_pointer_to_function(cres.fndesc.llvm_func_name)
        binding.add_symbol(here.mangled_name, code)
        self.targetctx.insert_user_function(here.mangled_name, here)
        _named[here.mangled_name] = (here.modname, here.qualname, args)

    def get_overload(self, sig: Any) -> Any:
        return self._names[tuple(sig)]
