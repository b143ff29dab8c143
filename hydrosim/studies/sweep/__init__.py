"""Studies over parameters and seeds, as a file says."""
