"""Pictures of a run: `open_run` reads it, `draw` writes them."""
