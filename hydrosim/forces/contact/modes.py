"""Modes of a contact point, CF flag values of `fender_mode`, and the columns of ``modes`` (nf, 3):
the mode, the segment of the normal curve, and whether the stretch is that of a rising load."""

OPEN, STICK, SLIP = range(3)
MODE, SEGMENT, RISING, COLUMNS = range(4)
