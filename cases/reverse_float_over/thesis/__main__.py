"""``python -m cases.reverse_float_over.thesis``, the command."""

from __future__ import annotations

import os
import sys

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as in hydrosim's own command line

from cases.reverse_float_over.thesis.command import main

main(sys.argv[1:])
