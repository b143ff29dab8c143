"""Modes of a contact point, CF flag values of `fender_mode`."""

OPEN, STICK, SLIP = range(3)
PASSED, ABSENT = 2, 3
"""Of an open point in the column `RISING`: it is behind its plane, beyond the edge of that, or is
not there at all."""
