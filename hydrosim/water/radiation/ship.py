"""Fits of the radiation of cases, to come with the package.

`python -m hydrosim.water.radiation.ship CASE...` makes them.

Each case is checked with an empty cache. What `kept` stored of fits there becomes its archive
`SHIPPED_FITS`. Names contain a hash of the sources: make the archive again after a change of them.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

from hydrosim.files.cache import DIGEST, SHIPPED_FITS

KINDS = ("fits", "reduced")
"""What is slow to make and small."""
ANSWERS = (0, 1)
"""Exit codes of `check` where it could compile the case."""


def ship(cases: Iterable[str], archive: Path = SHIPPED_FITS) -> list[str]:
    """Make the ``archive`` of the fits of ``cases`` anew; returns the names of its entries."""
    SHIPPED_FITS.unlink(missing_ok=True)  # what it holds would not be made
    with TemporaryDirectory() as cache:
        for case in cases:
            environment = {**os.environ, "HYDROSIM_CACHE_DIR": cache}
            command = [sys.executable, "-m", "hydrosim", "check", case]
            done = subprocess.run(command, env=environment, stdout=subprocess.DEVNULL)
            if done.returncode not in ANSWERS:
                raise SystemExit(done.returncode)  # the command has printed the reason
        return pack(Path(cache), archive)


def pack(cache: Path, archive: Path, without: Sequence[str] = ()) -> list[str]:
    """Write the fits of a ``cache`` to an ``archive``, but those ``without``; returns their
    names."""
    files = sorted(path for kind in KINDS for path in (cache / kind).glob("*.npz"))
    names = [path.relative_to(cache).as_posix() for path in files]
    chosen = [name for name in names if name not in without]
    with ZipFile(archive, "w", ZIP_DEFLATED) as entries:
        for name in chosen:
            content = (cache / name).read_bytes()[DIGEST().digest_size :]
            entries.writestr(ZipInfo(name), content, ZIP_DEFLATED)
    return chosen


def main() -> None:
    """Entry point of the command line."""
    if len(sys.argv) < 2:
        raise SystemExit("usage: python -m hydrosim.water.radiation.ship CASE...")
    names = ship(sys.argv[1:])
    print(f"{len(names)} fits, {SHIPPED_FITS.stat().st_size / 1e6:.1f} MB, in {SHIPPED_FITS}")


if __name__ == "__main__":
    main()
