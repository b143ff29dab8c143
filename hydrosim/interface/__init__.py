"""What commands and Python have in common: each command line ends in one of these functions."""
