"""`read_recording`: recognises the kind of file from its beginning, and reads it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from hydrosim.documents.text import Source
from hydrosim.recordings import hdf5, matlab, netcdf, text
from hydrosim.recordings.recording import Recording

Reader = Callable[[Source], Recording]
READERS: Mapping[bytes, Reader] = {  # by the first bytes of a file; all other files are text
    b"MATLAB 5.0 MAT-file": matlab.read,
    b"MATLAB 7.3 MAT-file": hdf5.read_matlab,
    b"\x89HDF": hdf5.read,
    b"CDF": netcdf.read,
}


def read_recording(path: Path | str) -> Recording:
    """Read all columns of a recorded series: text, MATLAB (v5, v7.3), HDF5, or netCDF, such as a
    run.

    Raises InputError with the file, the line of a text, the value found and the value expected.
    """
    source = Source(Path(path))
    head = source.head(max(map(len, READERS)))
    return next((read for mark, read in READERS.items() if head.startswith(mark)), text.read)(
        source
    )
