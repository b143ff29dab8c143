"""Pictures of a run: `open_run` reads it, `draw` writes them."""

from hydrosim.plot.pictures import draw
from hydrosim.studies.run.simulation import open_run
