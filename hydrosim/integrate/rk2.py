"""Midpoint rule, order 2 (Runge 1895): the reference method of the founding study."""

from hydrosim.integrate.method import method_of
from hydrosim.integrate.runge_kutta import tableau

RK2 = method_of("rk2", tableau([[1 / 2]], [0.0, 1.0], order=2))
