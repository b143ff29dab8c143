"""Dormand and Prince's pair of orders 5 and 4 (Dormand & Prince 1980), for adaptive steps."""

from hydrosim.integrate.method import method_of
from hydrosim.integrate.runge_kutta import tableau

DOPRI5 = method_of(
    "dopri5",
    tableau(
        [
            [1 / 5],
            [3 / 40, 9 / 40],
            [44 / 45, -56 / 15, 32 / 9],
            [19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729],
            [9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656],
            [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84],
        ],
        [35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84, 0.0],
        order=5,
        embedded=[5179 / 57600, 0.0, 7571 / 16695, 393 / 640, -92097 / 339200, 187 / 2100, 1 / 40],
    ),
    "chooses its own steps",
)
