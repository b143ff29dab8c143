"""A method of time integration and its properties.

Kernels receive its `Tableau`, arrays and numbers; all other code asks a `IntegrationMethod`. A
method that needs more than a tableau, such as an exponential one, is a subclass.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from hydrosim.integrate.implicit import Filters, Newton, new_newton
from hydrosim.integrate.runge_kutta import IMPLICIT

if TYPE_CHECKING:
    from hydrosim.integrate.runge_kutta import Tableau


@dataclass(frozen=True, eq=False)
class IntegrationMethod(ABC):
    """A method with its ``name`` and ``tableau``. ``why_any_step`` says why it is stable for any
    step; it is empty for methods with a limit."""

    name: str
    tableau: Tableau
    why_any_step: str

    @property
    def order(self) -> int:
        """Order of the error in the step."""
        return self.tableau.order

    @property
    def adapts(self) -> bool:
        """True if the method chooses its own steps by an embedded error."""
        return bool(self.tableau.error.any())

    @property
    def any_step(self) -> bool:
        """True if the method is stable for any step."""
        return bool(self.why_any_step)

    @abstractmethod
    def stability(self, z: np.ndarray) -> np.ndarray:
        """R(z), the factor by which one step h multiplies y for y' = lambda y with z = h lambda."""

    def new_newton(self, states: np.ndarray, filters: Filters, size: int) -> Newton:
        """Scratch for its steps with ``size`` states. The right hand side depends on ``states``
        (m,), which include the ``filters``."""
        if self.tableau.code != IMPLICIT:
            return new_newton(np.zeros(0, dtype=np.int64), size)
        together = np.setdiff1d(states, np.concatenate([filters.one, filters.other]))
        return new_newton(together, size, filters)


@dataclass(frozen=True, eq=False)
class RungeKutta(IntegrationMethod):
    """A method that its tableau defines. ``numerator`` and ``denominator`` are the coefficients of
    the polynomials in its `stability`, constants first."""

    numerator: np.ndarray
    denominator: np.ndarray

    def stability(self, z: np.ndarray) -> np.ndarray:
        """R(z) = det(I - z A + z 1 b^T) / det(I - z A) (Hairer & Wanner 1996, IV.3.5)."""
        above = np.polyval(self.numerator[::-1], z)
        return np.asarray(above / np.polyval(self.denominator[::-1], z))


def method_of(name: str, tableau: Tableau, why_any_step: str = "") -> IntegrationMethod:
    """The method of a ``tableau``."""
    a = tableau.a
    b = tableau.b
    numerator = np.poly(a - np.outer(np.ones(b.size), b))
    denominator = np.trim_zeros(np.poly(a), "b")  # 1 for an explicit method
    return RungeKutta(name, tableau, why_any_step, numerator, denominator)
