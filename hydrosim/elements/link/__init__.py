"""Links: a law of force along one coordinate, a distance, a twist or a motion of a joint."""
