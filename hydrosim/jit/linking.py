"""How kernels become machine code: what is called, when it is first called, once.

numba optimises and translates a kernel together with all kernels below it, once more for each
kernel above: for a tree of calls that is most of the time to compile. Here a kernel is one of two
things to the kernels that call it.

A `Part` is kept as numba wrote it, until a kernel that is run takes it in. So it is optimised
there, once.

A `Whole` (`@root`) is machine code of its own. Its callers know its name and its types, no more:
they are compiled without it. They call it through a `_Door`: eight bytes that hold the address of
its machine code, and nothing at first. Code that finds nothing there calls `_open`, which loads the
whole from the disk or compiles it, and stores the address. So a scene without tanks never compiles
a root of tanks, nobody has to say which scene needs which root, and none is called before it is
there. If a root cannot be compiled, all kernels above it return at once with the status `CLOSED`,
and the call from Python raises the error.

Addresses hold in one process. So machine code on disk has names of doors, which are made again
before it is loaded.

What is relied on of numba and documented nowhere, by files of its oldest version that is allowed,
below https://github.com/numba/numba/blob/0.61.0/numba/core/:

* codegen.py: `JITCodeLibrary`, its hooks and `_linking_libraries`; `JitEngine.finalize_object`;
  `magic_tuple`, `get_host_cpu_features`
* registry.py, dispatcher.py: `CPUDispatcher` with `get_call_template`, `get_overload`, `_cache`
* compiler.py: `compile_extra`, `Flags`, `Compiler.define_pipelines`, `CompileResult._rebuild`
* typed_passes.py, untyped_passes.py: the passes that are `NEEDLESS`
* caching.py: `_Cache`
* funcdesc.py: `ExternalFunctionDescriptor`

Where one of them is another, `hydrosim.jit.plain` takes over.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property, update_wrapper
from time import perf_counter
from typing import Any

from llvmlite import binding, ir
from numba.core import cgutils, compiler, sigutils, types, typing
from numba.core.codegen import JITCodeLibrary, JitEngine
from numba.core.funcdesc import ExternalFunctionDescriptor
from numba.core.registry import CPUDispatcher
from numba.core.typed_passes import InlineOverloads, NopythonRewrites
from numba.core.untyped_passes import InlineClosureLikes

from hydrosim.interrupts import raise_if_interrupted, undisturbed
from hydrosim.jit.disk import Disk, Name
from hydrosim.jit.refs import hold
from hydrosim.jit.waiting import Torn, waiting

OPTIONS: dict[str, Any] = {
    "nopython": True,
    "error_model": "numpy",  # its rules for division
    "nogil": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}

NUMBERS = {float: types.float64, bool: types.boolean, int: types.int64}
CLOSED = -9  # none of numba's own

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


NEEDLESS: tuple[Any, ...] = (
    InlineClosureLikes,  # kernels define no functions
    InlineOverloads,  # nor is any function inlined before LLVM does it
    NopythonRewrites,  # they join operations on whole arrays, which would allocate
)
"""Steps of numba that take about 6 % of the time to compile, and change nothing in kernels."""


class _PartCompiler(compiler.Compiler):
    """numba's steps, but for those that are `NEEDLESS`."""

    def define_pipelines(self) -> list[Any]:
        found = super().define_pipelines()
        for steps in found:
            steps.passes = [each for each in steps.passes if each[0] not in NEEDLESS]
        return list(found)


class _WholeCompiler(_PartCompiler):
    def compile_extra(self, func: Any) -> Any:
        self.state.library = _WholeCode(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)


_doors: dict[str, _Door] = {}
"""By their names in machine code."""

_doors_at: dict[int, _Door] = {}
"""By their addresses."""


class _Door:
    """The place in memory where machine code finds a ``whole`` for arguments of types ``args``."""

    def __init__(self, whole: Whole, args: tuple[Any, ...]) -> None:
        function = whole.py_func
        self.whole = whole
        self.args = args
        types_digest = hashlib.sha256(str(args).encode()).hexdigest()[:16]
        self.name = f"{function.__module__}.{function.__qualname__}.{types_digest}"
        self.code = ctypes.c_void_p(None)
        address = ctypes.addressof(self.code)
        binding.add_symbol(self.name, address)
        _doors[self.name] = _doors_at[address] = self

    def open(self) -> None:
        """Let machine code through from now on."""
        self.whole.compile(self.args)
        result: Any = self.whole.overloads[self.args]
        name = result.fndesc.llvm_func_name
        self.code.value = result.library.get_pointer_to_function(name)


def _called(library: Any) -> list[Name]:
    """The wholes that code has doors of."""
    names = [variable.name for variable in library._final_module.global_variables]
    doors = [_doors[name] for name in names if name in _doors]
    return [(d.whole.py_func.__module__, d.whole.py_func.__qualname__, d.args) for d in doors]


def _open(address: int) -> None:
    """Called by machine code that finds nothing behind the door at an address."""
    begin = perf_counter()
    door = _doors_at[address]
    try:
        door.open()
    except BaseException as error:  # an interrupt, too: machine code knows no exceptions
        door.code.value = None
        waiting.error = error
    waiting.seconds += perf_counter() - begin


_OPEN = "hydrosim.open"
_open_for_code = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(_open)
binding.add_symbol(_OPEN, ctypes.cast(_open_for_code, ctypes.c_void_p).value)


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
    def __init__(
        self, function: Any, folder: Callable[[], str], fastmath: frozenset[str] = frozenset()
    ) -> None:
        options = {**OPTIONS, "fastmath": set(fastmath)}
        super().__init__(function, targetoptions=options, pipeline_class=_WholeCompiler)
        self._cache = Disk(function, folder, _called)

    def __call__(self, *args: Any) -> Any:
        try:
            return super().__call__(*map(hold, args))
        except SystemError as error:  # as numba has it for a status that it does not know
            raise _reason() or error from None

    def __reduce__(self) -> str:  # type: ignore[override]
        return str(self.py_func.__qualname__)  # pickled by name, as functions are


class _PartKernel(_Kernel):
    """numba's object for a `Part`."""

    def __init__(
        self, function: Any, folder: Callable[[], str], fastmath: frozenset[str], flags: Any
    ) -> None:
        super().__init__(function, folder, fastmath)
        self._flags = flags
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
            self.typingctx, context, self.py_func, args, None, self._flags, {}, code, _PartCompiler
        )
        context.insert_user_function(result.fndesc, result.fndesc, [code])
        return result


class Part:
    """A kernel whose code becomes a part of the kernels that call it. Called from Python it is
    machine code with its own parts.

    numba's object is made when it is first asked for: of hundreds of parts few are, where machine
    code comes from the disk.
    """

    fastmath: frozenset[str] = frozenset()
    flags = _part_flags(fastmath)

    def __init__(self, function: Any, folder: Callable[[], str]) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._folder = folder

    @cached_property
    def compiled(self) -> Any:
        """numba's object."""
        return _PartKernel(self.py_func, self._folder, self.fastmath, self.flags)

    @property
    def _numba_type_(self) -> Any:
        """Type of the kernel where others call it."""
        return self.compiled._numba_type_

    def __call__(self, *args: Any) -> Any:
        return self.compiled(*args)

    def __reduce__(self) -> str:
        return str(self.py_func.__qualname__)  # pickled by name, as functions are


class Summing(Part):
    """A part whose sums may be taken in any order."""

    fastmath = frozenset({"reassoc", "contract"})
    flags = _part_flags(fastmath)


class Whole(_Kernel):
    """A kernel that is machine code of its own, for Python and for the kernels that call it. It
    returns numbers of the types ``returns``: callers are compiled before it."""

    def __init__(
        self, function: Any, folder: Callable[[], str], returns: Sequence[type] = ()
    ) -> None:
        super().__init__(function, folder)
        found = [NUMBERS[each] for each in returns]
        several = types.BaseTuple.from_types(found)
        self._returns = several if len(found) > 1 else found[0] if found else types.none
        self._doors: dict[Any, _Door] = {}
        self._callable: dict[Any, Any] = {}

    def compile(self, sig: Any) -> Any:
        args, _ = sigutils.normalize_signature(sig)
        return super().compile(typing.signature(self._returns, *args))

    def get_call_template(self, args: Any, kws: Any) -> Any:
        pysig, args = self.fold_argument_types(args, kws)
        name = self.py_func.__name__
        known = [typing.signature(self._returns, *args)]
        return typing.make_concrete_template(name, name, known), pysig, args, {}

    def get_overload(self, sig: Any) -> Any:
        args = tuple(sig)
        if args not in self._callable:
            self._callable[args] = self._entrance(self.door(args))
        return self._callable[args]

    def door(self, args: tuple[Any, ...]) -> _Door:
        """The door of the whole for arguments of these types."""
        if args not in self._doors:
            self._doors[args] = _Door(self, args)
        return self._doors[args]

    def _entrance(self, door: _Door) -> Any:
        """What callers take in as a part: a function that goes through the ``door``."""
        context: Any = self.targetctx
        word = ir.IntType(8).as_pointer()
        called = ExternalFunctionDescriptor(f"{door.name}.entrance", self._returns, door.args)
        code = _PartCode(context.codegen(), called.mangled_name)
        module = code.create_ir_module(called.mangled_name)
        function = context.declare_function(module, called)
        function.attributes.add("alwaysinline")
        place = ir.GlobalVariable(module, word, door.name)
        opener = ir.Function(module, ir.FunctionType(ir.VoidType(), [word]), _OPEN)
        builder = ir.IRBuilder(function.append_basic_block())
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, builder.load(place))):
            builder.call(opener, [builder.bitcast(place, word)])
            with builder.if_then(cgutils.is_null(builder, builder.load(place))):
                builder.ret(ir.Constant(function.function_type.return_type, CLOSED))
        whole = builder.bitcast(builder.load(place), function.function_type.as_pointer())
        builder.ret(builder.call(whole, function.args))
        code.add_ir_module(module)
        code.finalize()
        context.insert_user_function(called, called, [code])
        return called


def _reason() -> BaseException | None:
    """Why a door has stayed closed to the kernel that this thread has just called."""
    error = waiting.error
    waiting.error = None
    if isinstance(error, KeyboardInterrupt):
        return Torn(*error.args)
    if error is None:
        raise_if_interrupted()  # by a signal so early that the exception was lost
    return error
