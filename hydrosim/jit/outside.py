"""Calls from kernels to functions of Python.

Machine code knows one symbol, ``hydrosim.outside``, and calls it with the number of an `Answer`. So
the address of no function becomes part of machine code or of a model, and the disk cache works. The
call takes the interpreter's lock; it costs some microseconds.

An exception must not pass through machine code. An answer that raises keeps its error and returns
false; so does a number that is not known, in another process for example. The kernel then goes on
with NaN, and whoever called it asks for the error.
"""

from __future__ import annotations

import ctypes
from itertools import count
from typing import TYPE_CHECKING, Any, Protocol
from weakref import WeakValueDictionary

import numpy as np
from llvmlite import binding, ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from hydrosim.files.interrupts import called_by_machine_code
from hydrosim.jit.kernels import WAY

if TYPE_CHECKING:
    from collections.abc import Callable

SYMBOL = "hydrosim.outside"


class Answer(Protocol):
    """Something that kernels may ask."""

    def answer(
        self,
        t: float,
        exact: bool,
        coordinates: np.ndarray,
        velocity: np.ndarray,
        rotation: np.ndarray,
    ) -> bool:
        """Replace the content of ``coordinates`` (n,), given ``velocity`` (n,) and ``rotation`` (3
        n / 2,). Returns false if that fails. Raises nothing."""


_answers: WeakValueDictionary[int, Answer] = WeakValueDictionary()
_numbers = count(1)


def register(answer: Answer) -> int:
    """Number of an answer, valid in this process while the answer lives."""
    number = next(_numbers)
    _answers[number] = answer
    return number


@called_by_machine_code
def _call_registered(
    number: int, t: float, size: int, exact: int, coordinates: int, velocity: int, rotation: int
) -> int:
    caller = _answers.get(number)
    if caller is None:
        return 0
    arrays = (
        _array_at(coordinates, size),
        _array_at(velocity, size),
        _array_at(rotation, 3 * size // 2),
    )
    return int(caller.answer(t, bool(exact), *arrays))


def _array_at(address: int, size: int) -> np.ndarray:
    """View of ``size`` numbers in memory."""
    return np.ctypeslib.as_array((ctypes.c_double * size).from_address(address))


_WORD = ctypes.c_int64
_ask_for_code = ctypes.CFUNCTYPE(_WORD, _WORD, ctypes.c_double, _WORD, _WORD, _WORD, _WORD, _WORD)(
    _call_registered
)
binding.add_symbol(SYMBOL, ctypes.cast(_ask_for_code, ctypes.c_void_p).value)


def _compiled_call() -> Callable[..., Any]:
    """`call_python` for machine code."""

    def type_and_code(
        typingctx: Any,
        number: Any,
        t: Any,
        exact: Any,
        coordinates: Any,
        velocity: Any,
        rotation: Any,
    ) -> Any:
        def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
            word = ir.IntType(64)
            arrays = [
                context.make_array(kind)(context, builder, value)
                for kind, value in zip(signature.args[3:], args[3:], strict=True)
            ]
            size = builder.extract_value(arrays[0].shape, 0)
            places = [builder.ptrtoint(array.data, word) for array in arrays]
            argument_types = [word, ir.DoubleType(), *[word] * 5]
            called = ir.FunctionType(word, argument_types)
            function = cgutils.get_or_insert_function(builder.module, called, SYMBOL)
            return builder.call(function, [args[0], args[1], size, args[2], *places])

        arguments = (types.int64, types.float64, types.int64, coordinates, velocity, rotation)
        return types.int64(*arguments), generate

    return intrinsic(type_and_code)


def _interpreted_call(
    number: int, t: float, exact: int, coordinates: Any, velocity: Any, rotation: Any
) -> int:
    """`call_python` for kernels that Python runs."""
    places = (coordinates.ctypes.data, velocity.ctypes.data, rotation.ctypes.data)
    return _call_registered(number, t, coordinates.size, exact, *places)


call_python: Any = _interpreted_call if WAY == "python" else _compiled_call()
"""call_python(number, t, exact, own, velocity, rotation) lets an `Answer` replace the content of
``own``; gives 0 if that fails. ``exact`` is 0 or 1."""
