"""Benchmarks of hydrosim, one file per question: ``python -m benchmarks [question ...]``."""
