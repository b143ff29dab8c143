"""Comparison of a run with a recording, channel by channel: `compare`."""

from hydrosim.compare.align import MappingFile, read_mapping
from hydrosim.compare.comparison import Comparison, compare
