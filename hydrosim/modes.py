"""Modes of units, such as contact points, springs and flows: the columns of the rows of ``modes``
(rows, 3), the mode itself, the segment of its curve and whether it is that of a rising load; and
the margins of each row, which are positive while its mode lasts."""

MODE, SEGMENT, RISING, COLUMNS = range(4)
CONTACT_MARGIN, FRICTION_MARGIN, SEGMENT_MARGIN, RISING_MARGIN, MARGINS = range(5)
