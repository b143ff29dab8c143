"""Radiated waves: retardation functions, their state-space fit and the memory force."""

from hydrosim.radiation.build import (
    convolution_model,
    input_rates,
    state_space_model,
    velocity_history,
)
from hydrosim.radiation.fits import fit
from hydrosim.radiation.memory import ConvolutionKernel, RadiationStates, VelocityHistory
from hydrosim.radiation.retardation import KernelReport, Retardation, retardation
from hydrosim.radiation.state_space import FitReport, StateSpace
