"""From the record of a run to a dataset, its channels, and files of one run or many."""
