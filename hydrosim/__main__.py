"""The command line: thin commands over the functions of `hydrosim.interface`.

Exit codes: 0 done; 1 a strict check failed or a comparison is out of tolerance; 2 the input is
wrong; 3 the simulation failed or a file cannot be written; 130 interrupted.
"""

from __future__ import annotations

import atexit
import gc
import os
import signal
import sys
import warnings
from collections.abc import Callable, Sequence
from typing import Annotated, Any

if sys.excepthook is sys.__excepthook__:

    def _end_silently(kind: type[BaseException], error: BaseException, trace: Any) -> None:
        """Ignore Ctrl-C while modules are loaded: nothing has begun."""
        if not issubclass(kind, KeyboardInterrupt):
            sys.__excepthook__(kind, error, trace)

    sys.excepthook = _end_silently

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # more threads are slower on small matrices

import typer
from rich.console import Console

from hydrosim.cli import case, db, results, run, terminal
from hydrosim.cli.earlier import CommandsWithEarlierNames
from hydrosim.errors import HydrosimError, InputError
from hydrosim.files.interrupts import (
    ENDING_SIGNALS,
    install_signal_handlers,
    raise_if_interrupted,
)

# in the order in which one uses them, which is that of `hydrosim --help`
COMMANDS: tuple[Callable[..., None], ...] = (
    *(case.new, case.check, case.analyse, run.run, run.study),
    *(results.show, results.report, results.compare, results.export, case.decay),
)
MEMORY = (
    "error: not enough memory ({}). Close other programs or raise the limit of this shell or job"
    " (ulimit -v). A larger output.step reduces the memory of a long run."
)
NEEDED = 900_000_000  # bytes of address space, to load all libraries and run a small case
LACKS = "failed to map segment", "Cannot allocate memory"  # dynamic linker, operating system

app = typer.Typer(
    cls=CommandsWithEarlierNames,
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    help="Simulates floating bodies in time, with exact stick-slip contact. The commands stand in"
    " the order in which one uses them: write a case, check and analyse it, run it, look at the"
    " result, hand it on.",
)
for command in COMMANDS:
    app.command(cls=terminal.Command, help=terminal.reflow_help(command))(command)
app.add_typer(db.app, name="db")
err = Console(stderr=True)


def _print_version(asked: bool) -> None:
    if asked:
        from hydrosim.files.cache import program_version

        terminal.print_lines(f"hydrosim {program_version()}", *_shipped_kernels(), *_shipped_fits())
        raise typer.Exit


def _shipped_kernels() -> list[str]:
    """Line on the machine code that came with the package; empty without such code."""
    from hydrosim.jit.shipped import SHIPPED, describe_shipped

    if not SHIPPED:
        return []
    from numba.core.codegen import get_host_cpu_features  # slow to load

    from hydrosim.jit.kernels import kernel_folder

    return [describe_shipped(kernel_folder(), get_host_cpu_features())]


def _shipped_fits() -> list[str]:
    """Line on the fits of radiation that came with the package; empty if they cannot be read."""
    from zipfile import BadZipFile, ZipFile

    from hydrosim.files.cache import SHIPPED_FITS

    try:
        with ZipFile(SHIPPED_FITS) as archive:
            return [f"{len(archive.namelist())} fits of radiation came with the package"]
    except (OSError, BadZipFile):
        return []


@app.callback()
def _of_all(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_print_version, is_eager=True, help="Print the version."
        ),
    ] = False,
) -> None:
    pass


# Loading makes many objects that stay. Garbage collection need not visit them, which would take a
# tenth of a second while they are made, and a third at the end.
gc.set_threshold(500_000)
atexit.register(gc.freeze)


def main() -> None:
    """Run the command line. An error meant for the user ends it with the exit code of that
    error."""
    for number in ENDING_SIGNALS:
        atexit.register(signal.signal, number, signal.SIG_IGN)  # the exit code is known by then
    try:
        _run_command()
    except KeyboardInterrupt:  # raised while an error or the end of a command was told
        raise SystemExit(130) from None


def _run_command() -> None:
    install_signal_handlers()
    terminal.make_streams_last()
    warnings.showwarning = lambda message, *_, **__: terminal.print_status(f"warning   {message}")
    try:
        try:
            _require_memory_limit()
            _require_text([*sys.argv[1:], os.getcwd()])
            app(prog_name="hydrosim")
        finally:
            sys.stdout.flush()
    except KeyboardInterrupt:  # raised before a command began
        raise SystemExit(130) from None
    except HydrosimError as error:
        err.print(f"[bold red]error[/] {_plain_message(error)}", highlight=False, soft_wrap=True)
        raise SystemExit(error.exit_code) from None
    except Exception as error:
        raise_if_interrupted()  # pydantic raises an error of its own for it
        if lack := _lack_of_memory(error):
            print(MEMORY.format(lack), file=sys.stderr)  # colours would need more memory
            raise SystemExit(3) from None
        if not isinstance(error, OSError):
            raise
        err.print(f"[bold red]error[/] {_plain_message(error)}", highlight=False, soft_wrap=True)
        os._exit(3)  # the remaining output cannot be printed


def _require_text(arguments: Sequence[str]) -> None:
    """Raises InputError for an argument, or a folder to work in, that is no UTF-8: libraries cannot
    open such a file, and no result can name it."""
    for argument in arguments:
        try:
            argument.encode()
        except UnicodeEncodeError:
            name = os.fsencode(argument).decode(errors="backslashreplace")
            raise InputError(
                f"{name}: found a name whose bytes are no UTF-8; expected UTF-8. Rename it."
            ) from None


def _require_memory_limit() -> None:
    """Refuse a limit of memory below which OpenBLAS and LLVM end the process, or hang, without a
    message."""
    if sys.platform != "win32":
        import resource

        limit, _ = resource.getrlimit(resource.RLIMIT_AS)
        if 0 < limit < NEEDED:  # negative: no limit
            raise MemoryError(f"the limit is {limit / 1e6:.0f} MB; {NEEDED / 1e6:.0f} are needed")


def _lack_of_memory(error: BaseException | None) -> str:
    """Message on missing memory of an error or of its causes; empty if the error has another
    reason. Libraries that cannot be loaded name the reason. Modules in C that fail without a
    message raise SystemError."""
    while error is not None:
        text = str(error)
        if isinstance(error, MemoryError | SystemError) or any(word in text for word in LACKS):
            return text or "no memory is left"
        error = error.__cause__ or error.__context__
    return ""


def _plain_message(error: Exception) -> str:
    from hydrosim.files.document import printable  # loads numpy

    return printable(str(error)).replace("[", "\\[")


if __name__ == "__main__":
    main()
