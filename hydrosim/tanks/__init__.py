"""Tanks, flows between tanks and the sea, and their effect on the body that has them."""
