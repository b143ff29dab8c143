"""hydrosim."""
