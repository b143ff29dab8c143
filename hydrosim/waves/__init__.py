"""Waves: spectra, components, transfer functions, and first- and second-order loads in time."""

from hydrosim.waves.body import WaveBody
from hydrosim.waves.build import first_order, second_order, wave_loads_model
from hydrosim.waves.components import WaveComponents, check_span, components, energy_outside, sea
from hydrosim.waves.displaced_loads import following_model
from hydrosim.waves.elevation import elevation_at, elevations
from hydrosim.waves.frequency_truncation import Outside, shares_outside
from hydrosim.waves.loads import WaveLoads, wave_loads
from hydrosim.waves.quadratic import separate_headings
from hydrosim.waves.wave_reference import (
    chosen_places,
    grid_step,
    reference_positions,
    slow_bodies,
    steps_per_block,
)
