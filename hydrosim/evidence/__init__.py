"""Lines of evidence: what was held against what, and the features of scenes that they are about."""

from hydrosim.evidence.features import Feature, features_of
from hydrosim.evidence.lines import Kind, Line, known_lines, lines_about
