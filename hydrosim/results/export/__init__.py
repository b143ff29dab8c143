"""Channels of a run in the files of other programs: one format a file."""
