"""Contact: where a point meets a plane, how hard it is pressed, and how friction holds it."""
