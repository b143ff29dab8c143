"""Files that people write: YAML with layers, quantities with units, tables in text; what is wrong
with them, in words. Knows no scene."""
