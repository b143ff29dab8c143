"""The three modes of a contact point; CF flag values of `fender_mode`."""

OPEN, STICK, SLIP = range(3)
