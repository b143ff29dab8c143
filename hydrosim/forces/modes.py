"""Modes of a contact point, CF flag values of `fender_mode`; the columns of ``modes`` (nf + ns, 3):
the mode, the segment of the normal curve, and whether the stretch is that of a rising load; and the
margins of each row. Rows of contact points come first, then those of springs (`forces.spring`)."""

OPEN, STICK, SLIP = range(3)
MODE, SEGMENT, RISING, COLUMNS = range(4)
PASSED, ABSENT = 2, 3
"""Of an open point in the column `RISING`: it is behind its plane, beyond the edge of that, or is
not there at all."""
CONTACT_MARGIN, FRICTION_MARGIN, SEGMENT_MARGIN, RISING_MARGIN, MARGINS = range(5)
