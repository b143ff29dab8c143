"""Tanks, what flows between them and the sea, and what that does to the body that has them."""
