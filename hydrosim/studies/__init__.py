"""One question a file: one run, many, a sweep, convergence, responses."""
