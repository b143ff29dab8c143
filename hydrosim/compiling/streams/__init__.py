"""Wind and current on the bodies of a scene."""
