"""Modes of a contact point, CF flag values of `fender_mode`."""

OPEN, STICK, SLIP = range(3)
PASSED, ABSENT = 2, 3
"""Values of the column `RISING` for an open point: it is behind its plane, beyond the plane's edge;
or it does not exist at present."""
