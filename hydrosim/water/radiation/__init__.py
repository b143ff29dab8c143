"""Radiated waves: retardation functions, their state-space fit and the memory force."""

from hydrosim.water.radiation.convolution import ConvolutionKernel, convolution_model, new_history
from hydrosim.water.radiation.fits import (
    Floating,
    check_fits,
    fit_state_space,
    groups_free_to_reduce,
    is_tolerable,
    is_within_tolerance,
    reduce_states,
)
from hydrosim.water.radiation.history import VelocityHistory, new_velocity_history
from hydrosim.water.radiation.memory import (
    ConstantDamping,
    RadiationStates,
    constant_damping,
    input_rates,
    state_space_model,
)
from hydrosim.water.radiation.retardation import (
    KernelReport,
    Retardation,
    memory_length,
    resolved_length,
    retardation,
)
from hydrosim.water.radiation.state_space import TOLERANCE, FitReport, StateSpace
