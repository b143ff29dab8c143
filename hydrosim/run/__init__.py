"""One run: simulation, checkpoints, and checks before and after it."""
