"""Files that people write: YAML with layers, quantities with units, tables in text, and messages
about mistakes in them. This package knows nothing of scenes."""
