"""Are random moored scenes right where they are complete and unwarned?

    python -m benchmarks.moored_scenes --number 200 [--from 0] [--write FOLDER]

Cases are those of `moored_cases`, judged as `scene_trials` says. A line is printed for each.
"""

from __future__ import annotations

from benchmarks.moored_cases import moored_case
from benchmarks.scene_trials import run_trials

if __name__ == "__main__":
    run_trials(moored_case, __doc__, 200)
