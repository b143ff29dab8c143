"""The door for other programs: a simulation that a caller steps, and forces that a caller gives."""
