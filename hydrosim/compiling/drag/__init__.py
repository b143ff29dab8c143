"""Damping that depends on the scene: the drag of lines in its waves, the mode in which it rolls."""
