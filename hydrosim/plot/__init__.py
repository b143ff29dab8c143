"""Pictures of a run: `open_run` reads it, `draw` writes them."""

from hydrosim.plot.draw import draw
from hydrosim.plot.load import open_run
