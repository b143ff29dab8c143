"""Compilation of a scene to arrays."""
