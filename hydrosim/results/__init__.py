"""From the record of a run to a dataset, and to figures of it."""
