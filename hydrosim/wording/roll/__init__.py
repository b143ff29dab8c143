"""Roll damping in words: what fits of decay tests found, and what dampings of a scene are."""
