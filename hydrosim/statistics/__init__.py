"""Statistics of series, of runs and of many runs: moments, extremes, figures, effects, and their
uncertainty."""
