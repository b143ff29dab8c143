"""What floats and what is in it: hulls, weights, tanks that change, as constants of a model."""
