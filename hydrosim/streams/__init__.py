"""Current over the depth, wind over the height, and gusts."""
