"""Export of channels to files of other programs: one module per format."""
