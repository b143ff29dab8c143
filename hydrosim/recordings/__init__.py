"""Recordings of other programs and tests: `read_recording` reads all formats; `write_recording`
writes text."""

from hydrosim.recordings.load import read_recording
from hydrosim.recordings.recording import RecordedColumn, Recording
from hydrosim.recordings.write import write_recording
