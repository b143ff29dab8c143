"""Heun's method (explicit trapezoid), order 2 (Heun 1900)."""

from hydrosim.integrate.method import method_of
from hydrosim.integrate.runge_kutta import tableau

HEUN = method_of("heun", tableau([[1.0]], [1 / 2, 1 / 2], order=2))
