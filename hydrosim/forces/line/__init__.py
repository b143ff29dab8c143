"""Lines with weight, their drag, winches with their drums, and compensators."""
