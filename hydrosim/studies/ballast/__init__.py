"""Bodies with tanks: loading conditions, and pump plans."""
