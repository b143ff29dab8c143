"""Are random articulated scenes right where they are complete and unwarned?

    python -m benchmarks.articulated_scenes --number 300 [--from 0] [--write FOLDER]

Cases are those of `articulated_cases`, judged as `scene_trials` says. A line is printed for each.
"""

from __future__ import annotations

from benchmarks.articulated_cases import articulated_case
from benchmarks.scene_trials import run_trials

if __name__ == "__main__":
    run_trials(articulated_case, __doc__, 300)
