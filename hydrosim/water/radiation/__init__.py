"""Radiated waves: retardation functions, their state-space fit and the memory force."""

from hydrosim.water.radiation.convolution import ConvolutionKernel, convolution_model, history_for
from hydrosim.water.radiation.fits import (
    check,
    fit,
    free_groups,
    is_tolerable,
    is_within_tolerance,
    reduce,
)
from hydrosim.water.radiation.history import VelocityHistory, velocity_history
from hydrosim.water.radiation.memory import (
    ConstantDamping,
    RadiationStates,
    constant_damping,
    input_rates,
    state_space_model,
)
from hydrosim.water.radiation.reduction import Floating
from hydrosim.water.radiation.retardation import (
    KernelReport,
    Retardation,
    memory_length,
    resolved_length,
    retardation,
)
from hydrosim.water.radiation.state_space import TOLERANCE, FitReport, StateSpace
