"""In which seas a scene holds its criteria."""
