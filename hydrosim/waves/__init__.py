"""Waves: spectra, components, transfer functions, and first- and second-order loads in time."""

from hydrosim.waves.build import TrainLoads, WaveBody, train_loads, wave_loads_model
from hydrosim.waves.components import Components, check_span, components, energy_outside, sea
from hydrosim.waves.elevation import elevation_at, elevations
from hydrosim.waves.loads import WaveLoads, wave_loads
