"""Lines with weight: catenaries, their shape, their drag."""
