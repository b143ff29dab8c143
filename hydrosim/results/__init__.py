"""Datasets of runs, their channels, and files of one run or many."""
