"""Waves: spectra, components, transfer functions, and first- and second-order loads in time."""
