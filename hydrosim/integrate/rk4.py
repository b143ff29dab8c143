"""The classical Runge-Kutta method, order 4 (Kutta 1901)."""

from hydrosim.integrate.method import method_of
from hydrosim.integrate.runge_kutta import tableau

RK4 = method_of(
    "rk4", tableau([[1 / 2], [0.0, 1 / 2], [0.0, 0.0, 1.0]], [1 / 6, 1 / 3, 1 / 3, 1 / 6], order=4)
)
