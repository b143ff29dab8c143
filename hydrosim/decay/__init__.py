"""Decay tests of roll: the equation of a decay, and its damping fitted to recordings."""
