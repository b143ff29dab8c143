"""Mooring lines from the files of other programs: MoorDyn's and MoorPy's."""
