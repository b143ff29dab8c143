"""Lines: elastic catenaries on the seabed and off it."""
