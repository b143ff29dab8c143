"""Time stepping without physics: methods as tableaux, stages, error control, event location."""

from hydrosim.integrate.control import Control, error_norm, step_factor
from hydrosim.integrate.dopri5 import DOPRI5
from hydrosim.integrate.esdirk4 import ESDIRK4
from hydrosim.integrate.events import guard_defect, linear_value, next_trial
from hydrosim.integrate.heun import HEUN
from hydrosim.integrate.implicit import (
    Filters,
    Newton,
    factorise_iteration_matrix,
    new_newton,
    newton_iteration,
)
from hydrosim.integrate.method import IntegrationMethod
from hydrosim.integrate.rk2 import RK2
from hydrosim.integrate.rk4 import RK4
from hydrosim.integrate.runge_kutta import Tableau, advance_state, hermite, stage_state

METHODS = {method.name: method for method in (RK2, HEUN, RK4, DOPRI5, ESDIRK4)}


def method_named(name: str) -> IntegrationMethod:
    """The method with the name that a scene gives."""
    return METHODS[name]


def methods_for_any_step() -> list[IntegrationMethod]:
    """Methods that are stable for any step."""
    return [method for method in METHODS.values() if method.any_step]
