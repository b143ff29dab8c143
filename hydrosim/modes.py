"""Mode tables of units (contact points, springs, flows). Columns of ``modes`` (rows, 3): the mode;
the segment of the unit's curve; whether that curve is for a rising load. The margins of each row
are positive while its mode lasts."""

MODE, SEGMENT, RISING, COLUMNS = range(4)
CONTACT_MARGIN, FRICTION_MARGIN, SEGMENT_MARGIN, RISING_MARGIN, MARGINS = range(5)
