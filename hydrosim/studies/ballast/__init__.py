"""Bodies with tanks: loading conditions, and plans of their pumps."""
