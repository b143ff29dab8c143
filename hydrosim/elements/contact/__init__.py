"""Contact of points with planes: geometry, normal force and friction."""
