"""One question a folder: a run, many runs, a sweep, linear analysis, ballast, operability."""
