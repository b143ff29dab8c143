"""Compilation of kernels, each once, and the passing of wide tuples to them."""
