"""Forces that other programs and functions of the user give."""
