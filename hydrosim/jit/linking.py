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
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from llvmlite import binding
from numba.core import compiler, event, typing
from numba.core.codegen import JITCodeLibrary, JitEngine
from numba.core.registry import CPUDispatcher

from hydrosim.interrupts import undisturbed
from hydrosim.jit.refs import hold

if TYPE_CHECKING:
    from hydrosim.jit.disk import Disk, Name

    Keep = Callable[[Any, Callable[[Any], list[Name]]], Disk]
    """Gives the files of a kernel; it is told how to ask which wholes code calls by name."""

OPTIONS: dict[str, Any] = {
    "nopython": True,
    "error_model": "numpy",  # its rules for division
    "nogil": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}

# LLVM hands over machine code, and asks for it, in callbacks. An exception there is lost, and with
# it the code; so the one that a signal raises comes after them.
JitEngine.finalize_object = undisturbed()(JitEngine.finalize_object)


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
        # a part comes after all that may call it: LLVM takes in what is asked for by then
        last_first = dict.fromkeys(reversed(list(_below(self))))
        self._linking_libraries = list(reversed(last_first))
        super().finalize()

    def serialize_using_object_code(self) -> Any:
        # no library links this one, so of its code before translation the names will do
        names = [function.name for function in self.get_defined_functions()]
        empty = "\n".join(f'define void @"{name}"() {{ unreachable }}' for name in names)
        code = binding.parse_assembly(empty).as_bitcode()
        return self.name, "object", (self._get_compiled_object(), code)


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
        return super().compile_extra(func)


_named: dict[str, Name] = {}
"""Wholes by the names of their machine code."""


def _called(library: Any) -> list[Name]:
    """The wholes that code calls by name."""
    return [_named[f.name] for f in library._final_module.functions if f.name in _named]


class _Flags(compiler.Flags):
    """Options of a compile, never changed: numba looks up what it inferred before by comparing all
    of them, which takes long, and makes copies to be safe."""

    __hash__ = object.__hash__
    __eq__ = object.__eq__

    def copy(self) -> _Flags:
        return self


def _part_flags(fastmath: frozenset[str]) -> Any:
    """Options of parts: they are not compiled to the end."""
    flags: Any = _Flags()
    options = {**OPTIONS, "forceinline": True, "fastmath": set(fastmath)}
    CPUDispatcher.targetdescr.options.parse_as_flags(flags, options)
    flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
    return flags


class _Kernel(CPUDispatcher):
    fastmath: frozenset[str] = frozenset()

    def __init__(self, function: Any, keep: Keep) -> None:
        options = {**OPTIONS, "fastmath": set(self.fastmath)}
        super().__init__(function, targetoptions=options, pipeline_class=_WholeCompiler)
        self._cache = keep(function, _called)

    def __call__(self, *args: Any) -> Any:
        return super().__call__(*map(hold, args))

    def __reduce__(self) -> str:  # type: ignore[override]
        return str(self.py_func.__qualname__)  # pickled by name, as functions are


class Part(_Kernel):
    """A kernel whose code becomes a part of the kernels that call it. Called from Python it is
    machine code with its own parts."""

    flags = _part_flags(frozenset())

    def __init__(self, function: Any, keep: Keep) -> None:
        super().__init__(function, keep)
        self._parts: dict[Any, Any] = {}

    def get_call_template(self, args: Any, kws: Any) -> Any:
        pysig, args = self.fold_argument_types(args, kws)
        if args not in self._parts:
            self._parts[args] = self._part(args)
        name = self.py_func.__name__
        known = [self._parts[args].signature]
        return typing.make_concrete_template(name, name, known), pysig, args, {}

    def get_overload(self, sig: Any) -> Any:
        return self._parts[tuple(sig)].fndesc

    def _part(self, args: Any) -> Any:
        context: Any = self.targetctx
        code = _PartCode(context.codegen(), self.py_func.__qualname__)
        result = compiler.compile_extra(
            self.typingctx, context, self.py_func, args, None, self.flags, {}, code
        )
        context.insert_user_function(result.fndesc, result.fndesc, [code])
        return result


class Summing(Part):
    """A part whose sums may be taken in any order."""

    fastmath = frozenset({"reassoc", "contract"})
    flags = _part_flags(fastmath)


class Whole(_Kernel):
    """A kernel that is machine code of its own, for Python and for the kernels that call it."""

    def __init__(self, function: Any, keep: Keep) -> None:
        super().__init__(function, keep)
        self._names: dict[Any, str] = {}

    def add_overload(self, cres: Any) -> None:
        super().add_overload(cres)
        here = copy.copy(cres.fndesc)
        args = tuple(cres.signature.args)
        place = f"{here.modname}.{here.qualname}"
        types = hashlib.sha256(str(cres.signature).encode()).hexdigest()[:16]
        here.mangled_name = self._names[args] = f"{place}.{types}"
        code = cres.library.get_pointer_to_function(cres.fndesc.llvm_func_name)
        binding.add_symbol(here.mangled_name, code)
        self.targetctx.insert_user_function(here.mangled_name, here)
        _named[here.mangled_name] = (here.modname, here.qualname, args)

    def get_overload(self, sig: Any) -> Any:
        return self._names[tuple(sig)]


class _First(event.Listener):
    """Calls ``act`` at the first event of a kind."""

    def __init__(self, act: Callable[[], None]) -> None:
        self._waiting = [act]

    def on_start(self, event: Any) -> None:
        while self._waiting:
            self._waiting.pop()()

    def on_end(self, event: Any) -> None:
        pass


@contextmanager
def at_first_compile(act: Callable[[], None]) -> Iterator[None]:
    """Call ``act`` before the first kernel is compiled meanwhile, if any is: those that come from
    the disk are not."""
    with event.install_listener("numba:compile", _First(act)):
        yield
