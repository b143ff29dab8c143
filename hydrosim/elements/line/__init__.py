"""Lines: winches with their drums, compensators, and lines with weight and their drag."""
