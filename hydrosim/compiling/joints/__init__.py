"""Joints of a scene as constants, and their start."""
