"""Radiated waves: retardation functions, their state-space fit and the memory force."""

from hydrosim.radiation.build import constant_damping, input_rates, state_space_model
from hydrosim.radiation.convolution import ConvolutionKernel, convolution_model, history_for
from hydrosim.radiation.fits import (
    check,
    fit,
    free_groups,
    is_tolerable,
    is_within_tolerance,
    reduce,
)
from hydrosim.radiation.history import VelocityHistory, velocity_history
from hydrosim.radiation.memory import ConstantDamping, RadiationStates
from hydrosim.radiation.reduction import Floating
from hydrosim.radiation.retardation import (
    KernelReport,
    Retardation,
    memory_length,
    resolved_length,
    retardation,
)
from hydrosim.radiation.state_space import TOLERANCE, FitReport, StateSpace
