"""Mode tables of units (contact points, springs, flows). Columns of ``modes`` (rows, 3): the mode;
the segment of the unit's curve; whether that curve is for a rising load. The margins of each row
are positive while its mode lasts."""

MODE, SEGMENT, RISING, MODE_COLUMNS = range(4)
CONTACT_MARGIN, FRICTION_MARGIN, SEGMENT_MARGIN, RISING_MARGIN, MARGINS = range(5)
ACTING, INACTIVE, UNDEFINED = range(3)
"""Modes of units without modes of their own: outside of its active time a unit is inactive. Where
its force is not defined the run ends."""
NO_INDEX = -1
"""Stands for the index of something that is not there."""
