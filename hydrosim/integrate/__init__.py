"""Time stepping without physics: methods as tableaux, stages, error control, event location."""

from hydrosim.integrate.implicit import (
    Filters,
    Newton,
    factorise_iteration_matrix,
    new_newton,
    newton_iteration,
)
from hydrosim.integrate.methods import (
    DOPRI5,
    ESDIRK4,
    HEUN,
    RK2,
    RK4,
    IntegrationMethod,
    Tableau,
    advance_state,
    hermite,
    stage_state,
)
from hydrosim.integrate.step_control import (
    Control,
    error_norm,
    guard_defect,
    linear_value,
    next_trial,
    step_factor,
)

METHODS = {method.name: method for method in (RK2, HEUN, RK4, DOPRI5, ESDIRK4)}


def method_named(name: str) -> IntegrationMethod:
    """The method with the name that a scene gives."""
    return METHODS[name]


def methods_for_any_step() -> list[IntegrationMethod]:
    """Methods that are stable for any step."""
    return [method for method in METHODS.values() if method.any_step]
