"""Benchmarks of hydrosim, one file per question: ``python -m benchmarks [question ...]``."""

ELSEWHERE = {"chain": "cases.chain.comparison", "flume": "cases.flume.comparison"}
"""Modules of questions that stand beside the cases that they are about."""
