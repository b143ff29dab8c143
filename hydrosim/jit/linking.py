"""Compilation of kernels at their first call, each once.

numba optimises and translates a kernel together with all kernels below it, and does so again for
every kernel above. In a tree of calls that takes most of the compile time. Here a kernel is one of
two kinds for the kernels that call it.

A `InlinedKernel` is kept as numba's intermediate code until a `CompiledKernel` links it in. It is
optimised there, once.

A `CompiledKernel` (`@root`) is machine code of its own. Its callers know only its name and its
types: they are compiled without it. They call it through a `LazySymbol`: eight bytes that hold the
address of its machine code, and zero at first.

Code that finds zero there calls `_open`, which loads the whole from the disk or compiles it, and
stores the address. So a scene without tanks never compiles a root of tanks, and nobody has to list
the roots that a scene needs. If a root cannot be compiled, all kernels above it return at once with
the status `NO_CODE_STATUS`, and the call from Python raises the error.

Addresses are valid in one process. So machine code on disk refers to doors by name; the doors are
made again before it is loaded.

This module relies on undocumented parts of numba. The list names the files of the oldest supported
version, below https://github.com/numba/numba/blob/0.61.0/numba/core/:

* codegen.py: `JITCodeLibrary`, its hooks and `_linking_libraries`; `JitEngine.finalize_object`;
  `magic_tuple`, `get_host_cpu_features`
* registry.py, dispatcher.py: `CPUDispatcher` with `get_call_template`, `get_overload`, `_cache`
* compiler.py: `compile_extra`, `Flags`, `Compiler.define_pipelines`, `CompileResult._rebuild`
* typed_passes.py, untyped_passes.py: the passes in `NEEDLESS`
* caching.py: `_Cache`
* extending.py: `_Intrinsic`; typing/templates.py: `builtin_registry`
* funcdesc.py: `ExternalFunctionDescriptor`

`hydrosim.jit.plain` takes over if one of them differs.
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

from hydrosim.files import interrupts
from hydrosim.jit.disk import KernelFiles, Name
from hydrosim.jit.ingredients import describe_type
from hydrosim.jit.refs import struct_reference
from hydrosim.jit.waiting import Torn, waiting

OPTIONS: dict[str, Any] = {
    "nopython": True,
    "error_model": "numpy",  # numpy's rules for division
    "nogil": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}

NUMBERS = {float: types.float64, bool: types.boolean, int: types.int64}
NO_CODE_STATUS = -9  # a status that numba itself does not use

# LLVM passes machine code in callbacks. An exception there would be lost, and the code with it. So
# the exception that a signal raises is delayed until the callback has returned.
JitEngine.finalize_object = interrupts.delay_interrupts()(JitEngine.finalize_object)


class _PartCode(JITCodeLibrary):
    """Code that becomes a part of other libraries: neither optimised nor executable by itself."""

    def finalize(self) -> None:
        for function in self._final_module.functions:
            if not function.is_declaration:
                function.linkage = "linkonce_odr"  # LLVM drops it where nothing calls it any more
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        self._ensure_finalized()
        return self._final_module


class _WholeCode(JITCodeLibrary):
    """Machine code of a kernel with all its parts."""

    def finalize(self) -> None:
        # a part comes after every part that may call it: LLVM links only symbols requested by then
        last_first = dict.fromkeys(reversed(list(_linked_libraries(self))))
        self._linking_libraries = list(reversed(last_first))
        super().finalize()

    def serialize_using_object_code(self) -> Any:
        # no library links this one, so the names of its functions before translation suffice
        names = [function.name for function in self.get_defined_functions()]
        empty = "\n".join(f'define void @"{name}"() {{ unreachable }}' for name in names)
        code = binding.parse_assembly(empty).as_bitcode()
        return self.name, "object", (self._get_compiled_object(), code)


def _linked_libraries(library: Any) -> Iterator[Any]:
    """All libraries linked into a library, at any depth."""
    for other in library._linking_libraries:
        yield other
        if isinstance(other, _PartCode):
            yield from _linked_libraries(other)


NEEDLESS: tuple[Any, ...] = (
    InlineClosureLikes,  # kernels define no functions
    InlineOverloads,  # LLVM alone inlines functions
    NopythonRewrites,  # these fuse operations on whole arrays, which would allocate
)
"""Passes of numba that take about 6 % of the compile time and change nothing in kernels."""


class _PartCompiler(compiler.Compiler):
    """numba's passes without `NEEDLESS`."""

    def define_pipelines(self) -> list[Any]:
        pipelines = super().define_pipelines()
        for steps in pipelines:
            steps.passes = [
                compiler_pass for compiler_pass in steps.passes if compiler_pass[0] not in NEEDLESS
            ]
        return list(pipelines)


class _WholeCompiler(_PartCompiler):
    def compile_extra(self, func: Any) -> Any:
        self.state.library = _WholeCode(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)


_doors: dict[str, LazySymbol] = {}
"""Doors by their names in machine code."""

_doors_at: dict[int, LazySymbol] = {}
"""Doors by their addresses."""


class LazySymbol:
    """The place in memory where machine code finds a ``whole`` for arguments of types ``args``."""

    def __init__(self, whole: CompiledKernel, args: tuple[Any, ...]) -> None:
        function = whole.py_func
        self.whole = whole
        self.args = args
        described = ", ".join(map(describe_type, args))
        types_digest = hashlib.sha256(described.encode()).hexdigest()[:16]
        self.name = f"{function.__module__}.{function.__qualname__}.{types_digest}"
        self.code = ctypes.c_void_p(None)
        address = ctypes.addressof(self.code)
        binding.add_symbol(self.name, address)
        _doors[self.name] = _doors_at[address] = self

    def open(self) -> None:
        """Store the address, so that machine code calls the whole directly from now on."""
        self.whole.compile(self.args)
        result: Any = self.whole.overloads[self.args]
        name = result.fndesc.llvm_func_name
        self.code.value = result.library.get_pointer_to_function(name)


def _called_kernels(library: Any) -> list[Name]:
    """The wholes whose doors this code holds."""
    names = [variable.name for variable in library._final_module.global_variables]
    doors = [_doors[name] for name in names if name in _doors]
    return [(d.whole.py_func.__module__, d.whole.py_func.__qualname__, d.args) for d in doors]


@interrupts.called_by_machine_code
def _open(address: int) -> None:
    """Load or compile the whole of a door; machine code calls this where the door holds zero."""
    begin = perf_counter()
    door = _doors_at[address]
    before = interrupts.catching.catches
    try:
        interrupts.catching.catches = True
        door.open()
    except BaseException as error:  # also for an interrupt: machine code knows no exceptions
        interrupts.catching.catches = before
        door.code.value = None
        waiting.error = error
    interrupts.catching.catches = before
    waiting.seconds += perf_counter() - begin


_OPENER_SYMBOL = "hydrosim.open"
_open_for_code = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(_open)
binding.add_symbol(_OPENER_SYMBOL, ctypes.cast(_open_for_code, ctypes.c_void_p).value)


class _Flags(compiler.Flags):
    """Options of a compilation, never changed. numba compares all of them when it looks up inferred
    types, which is slow, and copies them for safety."""

    __hash__ = object.__hash__
    __eq__ = object.__eq__

    def copy(self) -> _Flags:
        return self


def _part_flags(fastmath: frozenset[str]) -> Any:
    """Options of parts, which are not translated to machine code."""
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
        self.fastmath = fastmath
        self._cache = KernelFiles(self, folder, _called_kernels)

    def __call__(self, *args: Any) -> Any:
        try:
            returned = super().__call__(*map(struct_reference, args))
        except SystemError:  # numba raises it for a status that it does not know
            raise _reason() from None
        interrupts.raise_waiting()
        return returned

    def __reduce__(self) -> str:  # type: ignore[override]
        return str(self.py_func.__qualname__)  # pickled by name, as functions are


class _PartKernel(_Kernel):
    """numba's object for a `InlinedKernel`."""

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
        signatures = [self._parts[args].signature]
        return typing.make_concrete_template(name, name, signatures), pysig, args, {}

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


class InlinedKernel:
    """A kernel whose code becomes a part of the kernels that call it. Python calls it as machine
    code with its own parts.

    numba's object is made on first use. Of hundreds of parts few are used where machine code comes
    from the disk.
    """

    fastmath: frozenset[str] = frozenset()
    flags = _part_flags(fastmath)

    def __init__(self, function: Any, folder: Callable[[], str]) -> None:
        update_wrapper(self, function)
        self.py_func = function
        self._folder = folder

    @cached_property
    def dispatcher(self) -> Any:
        """numba's object."""
        return _PartKernel(self.py_func, self._folder, self.fastmath, self.flags)

    @property
    def _numba_type_(self) -> Any:
        """Type of the kernel in the kernels that call it."""
        return self.dispatcher._numba_type_

    def __call__(self, *args: Any) -> Any:
        return self.dispatcher(*args)

    def __reduce__(self) -> str:
        return str(self.py_func.__qualname__)  # pickled by name, as functions are


class SummingKernel(InlinedKernel):
    """A part whose sums may be taken in any order."""

    fastmath = frozenset({"reassoc", "contract"})
    flags = _part_flags(fastmath)


class CompiledKernel(_Kernel):
    """A kernel with machine code of its own, for Python and for the kernels that call it. It
    returns numbers of the types ``returns``, because callers are compiled before it."""

    def __init__(
        self, function: Any, folder: Callable[[], str], returns: Sequence[type] = ()
    ) -> None:
        super().__init__(function, folder)
        numbers = [NUMBERS[type_name] for type_name in returns]
        several = types.BaseTuple.from_types(numbers)
        self.returns = several if len(numbers) > 1 else numbers[0] if numbers else types.none
        self._doors: dict[Any, LazySymbol] = {}
        self._callable: dict[Any, Any] = {}

    def compile(self, sig: Any) -> Any:
        args, _ = sigutils.normalize_signature(sig)
        return super().compile(typing.signature(self.returns, *args))

    def get_call_template(self, args: Any, kws: Any) -> Any:
        pysig, args = self.fold_argument_types(args, kws)
        name = self.py_func.__name__
        signatures = [typing.signature(self.returns, *args)]
        return typing.make_concrete_template(name, name, signatures), pysig, args, {}

    def get_overload(self, sig: Any) -> Any:
        args = tuple(sig)
        if args not in self._callable:
            self._callable[args] = self._entrance(self.door(args))
        return self._callable[args]

    def door(self, args: tuple[Any, ...]) -> LazySymbol:
        """The door of the whole for arguments of these types."""
        if args not in self._doors:
            self._doors[args] = LazySymbol(self, args)
        return self._doors[args]

    def _entrance(self, door: LazySymbol) -> Any:
        """The function that callers link in as a part: it calls through the ``door``."""
        context: Any = self.targetctx
        word = ir.IntType(8).as_pointer()
        called = ExternalFunctionDescriptor(f"{door.name}.entrance", self.returns, door.args)
        code = _PartCode(context.codegen(), called.mangled_name)
        module = code.create_ir_module(called.mangled_name)
        function = context.declare_function(module, called)
        function.attributes.add("alwaysinline")
        place = ir.GlobalVariable(module, word, door.name)
        opener = ir.Function(module, ir.FunctionType(ir.VoidType(), [word]), _OPENER_SYMBOL)
        builder = ir.IRBuilder(function.append_basic_block())
        with cgutils.if_unlikely(builder, cgutils.is_null(builder, builder.load(place))):
            builder.call(opener, [builder.bitcast(place, word)])
            with builder.if_then(cgutils.is_null(builder, builder.load(place))):
                builder.ret(ir.Constant(function.function_type.return_type, NO_CODE_STATUS))
        whole = builder.bitcast(builder.load(place), function.function_type.as_pointer())
        builder.ret(builder.call(whole, function.args))
        code.add_ir_module(module)
        code.finalize()
        context.insert_user_function(called, called, [code])
        return called


def _reason() -> BaseException:
    """Error that kept a door closed to the kernel that this thread has just called. `_open` keeps
    all errors but one: the exception that a signal raised before it began."""
    error = waiting.error
    waiting.error = None
    if error is None or isinstance(error, KeyboardInterrupt):
        return Torn(*getattr(error, "args", ()))
    return error


kernel_classes = InlinedKernel, SummingKernel, CompiledKernel
"""Of `hydrosim.jit.kernels`: `kernel`, `summing`, and `root`."""
