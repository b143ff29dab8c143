"""Damping of a body beyond radiation: linear, with the squared velocity, and of roll."""
