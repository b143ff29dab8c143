"""Recordings of other programs and tests: `read_recording`, whatever the format of the file;
`write_recording` writes one."""

from hydrosim.recordings.load import read_recording
from hydrosim.recordings.recording import Column, Recording
from hydrosim.recordings.write import write_recording
