"""Midpoint rule, order 2 (Runge 1895): the reference method of the founding study."""

from hydrosim.integrate.method import Method
from hydrosim.integrate.runge_kutta import tableau

RK2 = Method("rk2", tableau([[1 / 2]], [0.0, 1.0], order=2))
