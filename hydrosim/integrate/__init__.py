"""The equation of motion, a step, an event, the loop: kernels only."""
