"""Call of a function of the user, for the kernels: what it is given, and what it may return."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any
from weakref import WeakValueDictionary

import numpy as np
from numpy.typing import ArrayLike

from hydrosim.forces.given.view import BodyState, body_states, read_only
from hydrosim.interrupts import catching
from hydrosim.jit.outside import register

Function = Callable[[float, Mapping[str, BodyState]], ArrayLike]
"""f(t, state): wrench (6,) [N, N m], or (k, 6) for k bodies, at the time t [s]."""


_last_callers: WeakValueDictionary[int, Caller] = WeakValueDictionary()
"""The last caller of each function that may remember, by the function's identity."""


class Caller:
    """Calls a ``function`` with the states of all bodies, called ``names``. Its wrenches act on the
    ``bodies`` (their numbers), about their centres of gravity or about the ``point`` of the first.

    After an ``error`` the function is not called again. A function that ``remembers`` may not be
    called by two runs in turn; ``owner`` is an object of its run.
    """

    def __init__(
        self,
        function: Function,
        names: Sequence[str],
        references: Sequence[np.ndarray],
        bodies: Sequence[int],
        point: Sequence[float] | None,
        remembers: bool = False,
        owner: object | None = None,
    ) -> None:
        self.error: BaseException | None = None
        self.number = register(self)
        self._function = function
        self._names = names
        self._references = [read_only(reference) for reference in references]
        self._bodies = bodies
        self._point = point
        self._remembers = remembers
        self._owner = owner
        self._has_called = False

    def answer(
        self, t: float, exact: bool, own: np.ndarray, velocity: np.ndarray, rotation: np.ndarray
    ) -> bool:
        """Replace the coordinates ``own`` (6 nb,) of all bodies by the wrenches on them. Returns
        false, and keeps the error, if the function raises or returns no wrench."""
        if self.error is not None:
            return False
        before = catching.catches
        try:
            catching.catches = True
            if self._remembers:
                self._check_owner()
            each = body_states(self._names, self._references, own, velocity, rotation, exact)
            wrench = self._wrench(self._function(t, each))
            if self._point is not None:
                first = each[self._names[self._bodies[0]]]
                wrench[0, 3:] += first.wrench(wrench[0, :3], self._point)[3:]
        except BaseException as error:  # also an interrupt: machine code knows no exceptions
            catching.catches = before
            self.error = error
            return False
        catching.catches = before
        own[:] = 0.0
        own.reshape(-1, 6)[self._bodies] = wrench
        return True

    def _check_owner(self) -> None:
        """Raises ValueError if another run has called the function since this one did."""
        key = id(self._function)  # valid while a caller keeps the function
        last = _last_callers.get(key)
        if self._has_called and last is not None and last._owner is not self._owner:
            raise ValueError(
                "another run has called the same function since, and it may remember; give each run"
                " an object of its own, or say External(..., repeatable=True) if it depends on its"
                " arguments alone"
            )
        self._has_called = True
        _last_callers[key] = self

    def _wrench(self, returned: Any) -> np.ndarray:
        """Wrenches (k, 6) that the function has returned. Raises ValueError if they are none."""
        count = len(self._bodies)
        if returned is None:
            raise ValueError("returned nothing; expected 6 numbers: force [N] and moment [N m]")
        try:
            wrench = np.array(returned, float)
        except (TypeError, ValueError):
            raise ValueError(
                f"returned {type(returned).__name__}; expected 6 numbers: force [N] and moment"
                " [N m] in the earth frame"
            ) from None
        if wrench.shape != (count, 6) and (count > 1 or wrench.shape != (6,)):
            expected = f"({count}, 6)" if count > 1 else "(6,)"
            raise ValueError(
                f"returned an array of shape {wrench.shape}; expected {expected}: force [N] and"
                " moment [N m] in the earth frame"
            )
        if not np.isfinite(wrench).all():
            raise ValueError(f"returned {wrench.tolist()}; expected finite numbers")
        return wrench.reshape(count, 6)
