"""Response to gusts in the frequency domain, linear about the mean wind.

    D(w) q = sum_z F_z u_z(w),   F_z = dF / du_z

D(w): dynamic stiffness of the scene (`hydrosim.studies.linear.response`), with the damping that the
mean wind gives; u_z: amplitudes of the gusts at each height that a load feels; F_z: change of all
loads with the wind speed there. Gusts and waves are independent, so their variances add.

Limits: the square of the gusts is left out, |U + u|^2 = U^2 + 2 U u. The mean load is larger than
that of the mean wind by (s / U)^2, with the standard deviation s of the gusts.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from hydrosim.forces import heights_of_wind, in_gusts
from hydrosim.stepping.dynamics import new_work, rhs
from hydrosim.streams.gusts import GustTable

if TYPE_CHECKING:
    from hydrosim.linear.linearise import Linear
    from hydrosim.stepping.dynamics import Model
    from hydrosim.stepping.state import State

WIND_SPEED_STEP = 1e-3  # m/s, of differences


def change_with_wind(linear: Linear, model: Model, state: State, time: float) -> np.ndarray:
    """Change (nh, n) [N s/m, N s] of the generalised loads with the wind speed at each height."""
    n = model.bodies.active.size
    count = len(heights_of_wind(model.elements))
    work = new_work(model)
    slope = np.empty(model.size)
    change = np.zeros((count, n))
    for column in range(count):
        for sign in (1.0, -1.0):
            values = np.zeros((1, count))
            values[0, column] = sign * WIND_SPEED_STEP
            steady = GustTable(time, 1.0, 0.0, 0.0, values)
            there = model._replace(elements=in_gusts(model.elements, steady))
            rhs(time, state.y, state.modes, state.history, there, work, slope)
            change[column] += sign * slope[n : 2 * n]
    return np.asarray(change @ linear.inertia.T / (2.0 * WIND_SPEED_STEP))
