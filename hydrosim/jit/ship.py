"""Machine code for wheels: `python -m hydrosim.jit.ship FOLDER CASE...`.

FOLDER receives the kernels that `hydrosim check`, `run` and `linear` of these cases call, and runs
with `solver.method: automatic`, compiled for any processor of the kind `PROCESSOR`. A wheel
includes them if it is built with ``HYDROSIM_SHIPPED=FOLDER`` in the environment.
`hydrosim.jit.shipped` says how they are used.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from hydrosim.files.cache import DIGEST, versions
from hydrosim.jit.kernels import kernel_folder
from hydrosim.jit.shipped import MANIFEST, NO_MORE_FEATURES, PROCESSOR

AUTOMATIC = ("--set", "solver.method=automatic", "--set", "solver.tolerance=1e-6")
REFUSED = 2  # exit code of the commands for input that they refuse


def ship(folder: Path, cases: Sequence[str]) -> dict[str, str]:
    """Fill an empty or new ``folder``; returns SHA-256 (hex) of its files by name."""
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise SystemExit(f"{folder} is not an empty folder; give a new one")
    with TemporaryDirectory() as name:
        for case in cases:
            result = ("--output", f"{name}/run.nc", "--overwrite")
            _run_command(Path(name), "check", case)
            _run_command(Path(name), "run", case, *result)
            _run_command(Path(name), "run", case, *AUTOMATIC, *result, may_refuse=True)
            _run_command(Path(name), "linear", case, *result, may_refuse=True)
        compiled = _compiled_files(Path(name))
        if not compiled:
            raise SystemExit("no kernels to ship: hydrosim.jit.linking does not support this numba")
        folder.mkdir(parents=True, exist_ok=True)
        files = {path.name: _copy_file(path, folder) for path in compiled}
    manifest = {
        "kernels": kernel_folder(),
        "made with": versions(),
        "processor": PROCESSOR,
        "files": files,
    }
    (folder / MANIFEST).write_text(json.dumps(manifest, indent=1))
    return files


def _run_command(cache: Path, *command: str, may_refuse: bool = False) -> None:
    """Run a command that compiles for the processor `PROCESSOR`, with this folder as cache. It
    ``may_refuse`` the case, as `linear` does with some: there is nothing to ship then."""
    processor = {"NUMBA_CPU_NAME": PROCESSOR, "NUMBA_CPU_FEATURES": NO_MORE_FEATURES}
    ours = {"HYDROSIM_CACHE_DIR": str(cache), "HYDROSIM_JIT": "linked"}
    environment = {**os.environ, **processor, **ours}
    done = subprocess.run([sys.executable, "-m", "hydrosim", *command], env=environment)
    if done.returncode and not (may_refuse and done.returncode == REFUSED):
        raise SystemExit(done.returncode)  # the command has printed the reason


def _compiled_files(cache: Path) -> list[Path]:
    return sorted((cache / kernel_folder()).glob("*.nbc"))


def _copy_file(path: Path, folder: Path) -> str:
    """Copy the cached kernels of these sources; returns SHA-256 (hex) of each copy."""
    content = path.read_bytes()[DIGEST().digest_size :]
    (folder / path.name).write_bytes(content)
    return hashlib.sha256(content).hexdigest()


def main() -> None:
    """Entry point of the command line."""
    if len(sys.argv) < 3:
        raise SystemExit("usage: python -m hydrosim.jit.ship FOLDER CASE...")
    folder = Path(sys.argv[1])
    files = ship(folder, sys.argv[2:])
    size = sum(path.stat().st_size for path in folder.iterdir())
    print(f"{len(files)} kernels, {size / 1e6:.1f} MB, in {folder}")


if __name__ == "__main__":
    main()
