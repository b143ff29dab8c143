"""From a scene to arrays, each part once."""
