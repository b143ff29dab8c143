"""Waves: spectra, components, transfer functions, and first- and second-order loads in time."""

from hydrosim.waves.body import WaveBody
from hydrosim.waves.build import first_order, second_order, wave_loads_model
from hydrosim.waves.components import WaveComponents, check_span, components, energy_outside, sea
from hydrosim.waves.database_limits import Outside, shares_outside
from hydrosim.waves.displaced_loads import following_model
from hydrosim.waves.loads import WaveLoads, elevation_at, elevations, wave_loads
from hydrosim.waves.second_order import separate_headings
from hydrosim.waves.wave_reference import (
    chosen_places,
    grid_step,
    reference_positions,
    slow_bodies,
    steps_per_block,
)
