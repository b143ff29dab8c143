"""Comparison of a run with a recording, channel by channel: `compare`."""

from hydrosim.compare.comparison import Comparison, compare
from hydrosim.compare.mapping import MappingFile, read_mapping
