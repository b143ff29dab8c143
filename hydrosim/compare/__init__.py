"""A run against what was recorded elsewhere: `compare`, channel by channel, with what differs."""

from hydrosim.compare.comparison import Comparison, compare
from hydrosim.compare.mapping import MappingFile, read_mapping
