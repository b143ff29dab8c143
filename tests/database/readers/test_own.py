"""hydrosim's own format, damaged."""

import damaged

from hydrosim.database import netcdf
from hydrosim.database.load import read


def test_damaged_files_are_refused(made_up, tmp_path):
    """Each has its own name, for HDF5 remembers a file that it failed to open."""
    netcdf.write(made_up(), tmp_path / "own.nc")
    content, count = (tmp_path / "own.nc").read_bytes(), 0
    for seed in range(damaged.COUNT):
        path = tmp_path / f"own{seed}.nc"
        path.write_bytes(damaged.damaged(content, seed))
        message = damaged.message(read, path)
        assert message is None or path.name in message, seed
        count += message is not None
        path.unlink()
    assert 30 <= 100 * count // damaged.COUNT
