"""What a series, a run or many runs tell: moments, extremes, figures, effects, and how sure."""
