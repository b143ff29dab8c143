"""Pictures of a run: `open_run` reads it, `draw` writes them."""

from hydrosim.plot.load import open_run
from hydrosim.plot.pictures import draw
