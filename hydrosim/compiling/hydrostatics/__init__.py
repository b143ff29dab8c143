"""Hulls, weights and changing tanks as constants of a model."""
