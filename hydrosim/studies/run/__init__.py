"""One run: simulated, kept on its way, checked before and judged after."""
