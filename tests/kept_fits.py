"""Fits of radiation that the tests need, as data in `ARCHIVE`.

    HYDROSIM_CACHE_DIR=NEW python -m pytest -n logical --dist worksteal -m "not slow"
    python tests/kept_fits.py NEW

makes them anew, after a change of `hydrosim/water/radiation` or of tests. Without that, tests fit
again, which takes minutes. Fits that come with the package are left out.
"""

import sys
from pathlib import Path
from zipfile import ZipFile

from hydrosim.files.cache import SHIPPED_FITS, store, stored
from hydrosim.water.radiation.ship import pack

ARCHIVE = Path(__file__).parent / "data" / "fits.zip"


def names(archive: Path) -> list[str]:
    """The names of the entries of an archive."""
    with ZipFile(archive) as entries:
        return entries.namelist()


def unpack() -> None:
    """Put the fits of `ARCHIVE` into the cache."""
    with ZipFile(ARCHIVE) as entries:
        for name in entries.namelist():
            if stored(name) is None:
                store(name, entries.read(name))


if __name__ == "__main__":
    kept = pack(Path(sys.argv[1]), ARCHIVE, without=names(SHIPPED_FITS))
    print(f"{len(kept)} fits, {ARCHIVE.stat().st_size / 1e6:.1f} MB, in {ARCHIVE}")
