"""Rigid bodies without fluids: vectors, rotations, kinematics, mass. Kernels only."""
