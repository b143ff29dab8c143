"""Lines with weight: elastic catenaries on the seabed and off it, and their drag."""
