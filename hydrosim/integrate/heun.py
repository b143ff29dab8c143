"""Heun's method (explicit trapezoid), order 2 (Heun 1900)."""

from hydrosim.integrate.method import Method
from hydrosim.integrate.runge_kutta import tableau

HEUN = Method("heun", tableau([[1.0]], [1 / 2, 1 / 2], order=2))
