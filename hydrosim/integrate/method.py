"""A method of time integration, and what it answers about itself.

Kernels get its `Tableau`, arrays and numbers; whoever else asks, asks a `Method`. A method that is
more than its tableau, as an exponential one, is a subclass with its own answers.
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
class Method(ABC):
    """A method by its ``name`` and ``tableau``. ``why_any_step`` says why no step is too large for
    it; empty of methods with a limit."""

    name: str
    tableau: Tableau
    why_any_step: str

    @property
    def order(self) -> int:
        """Order of the error in the step."""
        return self.tableau.order

    @property
    def adapts(self) -> bool:
        """Whether it chooses its own steps, by an embedded error."""
        return bool(self.tableau.error.any())

    @property
    def any_step(self) -> bool:
        """Whether no step is too large for it to be stable."""
        return bool(self.why_any_step)

    @abstractmethod
    def stability(self, z: np.ndarray) -> np.ndarray:
        """R(z), what one step h makes of y' = lambda y with z = h lambda."""

    def new_newton(self, states: np.ndarray, filters: Filters, size: int) -> Newton:
        """Scratch for its steps: of ``size`` states, ``states`` (m,) act on others, among them the
        ``filters``."""
        if self.tableau.code != IMPLICIT:
            return new_newton(np.zeros(0, dtype=np.int64), size)
        together = np.setdiff1d(states, np.concatenate([filters.one, filters.other]))
        return new_newton(together, size, filters)


@dataclass(frozen=True, eq=False)
class RungeKutta(Method):
    """A method that is its tableau. ``numerator`` and ``denominator`` are the coefficients of those
    of its `stability`, constants first."""

    numerator: np.ndarray
    denominator: np.ndarray

    def stability(self, z: np.ndarray) -> np.ndarray:
        """R(z) = det(I - z A + z 1 b^T) / det(I - z A) (Hairer & Wanner 1996, IV.3.5)."""
        above = np.polyval(self.numerator[::-1], z)
        return np.asarray(above / np.polyval(self.denominator[::-1], z))


def method_of(name: str, tableau: Tableau, why_any_step: str = "") -> Method:
    """The method of a ``tableau``."""
    a = tableau.a
    b = tableau.b
    numerator = np.poly(a - np.outer(np.ones(b.size), b))
    denominator = np.trim_zeros(np.poly(a), "b")  # 1 of an explicit method
    return RungeKutta(name, tableau, why_any_step, numerator, denominator)
