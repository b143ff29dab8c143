"""Commands of hydrosim 0.2 under their earlier names, and hints for words of other programs.

Earlier names work for one version more.
"""

from __future__ import annotations

import shlex
import sys
from typing import Any

from typer.core import TyperGroup

NEW_WORDS = {
    "linear": "analyse",
    "line": "analyse",
    "ballast": "analyse --ballast",
    "converge": "analyse --converge",
    "sweep": "study",
    "operability": "study",
    "statistics": "show --statistics",
    "explain": "show",
    "plot": "show --plot",
    "replay": "report --replay",
    "case": "export --case",
    "schema": "new --schema",
    "example": "new --example",
    "calibrate": "decay",
}
"""What is typed now, by the earlier name of a command."""
NEW_OPTIONS = {
    "explain": {"until": "to"},
    "build": {"jobs": "workers", "picture": "plot"},
}
OTHER_COMMANDS = {
    **dict.fromkeys(("simulate", "solve", "sim"), "run CASE.yaml"),
    **dict.fromkeys(("validate", "test"), "check CASE.yaml"),
    **dict.fromkeys(("modes", "modal", "rao", "raos", "frequency", "statics"), "analyse CASE.yaml"),
    **dict.fromkeys(("init", "create", "start"), "new CASE.yaml"),
    **dict.fromkeys(("examples", "list", "cases"), "new --example list"),
    **dict.fromkeys(("stats", "extremes", "extreme"), "show RUN.nc --statistics"),
    **dict.fromkeys(("open", "view", "info", "summary", "results", "print"), "show RUN.nc"),
    **dict.fromkeys(("batch", "seeds", "parameters", "many"), "study STUDY.yaml"),
    **dict.fromkeys(("csv", "convert", "save"), "export RUN.nc -o RUN.csv"),
    **dict.fromkeys(("build", "database"), "db build RECIPE.yaml"),
    **dict.fromkeys(("help",), "--help"),
    **dict.fromkeys(("version",), "--version"),
}
"""What is typed here, by the command that was probably expected."""
OTHER_OPTIONS = {
    **dict.fromkeys(("--hs", "--Hs", "--height", "--wave-height"), "--significant-height"),
    **dict.fromkeys(("--tp", "--Tp", "--period"), "--peak-period"),
    **dict.fromkeys(("--loa", "--lpp", "-l"), "--length"),
    **dict.fromkeys(("--width", "--breadth", "-b"), "--beam"),
    **dict.fromkeys(("--draft", "-t"), "--draught"),
    **dict.fromkeys(("--depth",), "--draught or --water-depth"),
    **dict.fromkeys(("--start", "--begin", "--after"), "--from"),
    **dict.fromkeys(("--end", "--until", "--stop"), "--to"),
    **dict.fromkeys(("--jobs", "-j", "-n", "--cores", "--threads", "--processes"), "--workers"),
    **dict.fromkeys(("--out", "--name", "--file"), "--output"),
    **dict.fromkeys(("--force", "-f", "--clobber"), "--overwrite"),
    **dict.fromkeys(("--stats", "--extremes"), "--statistics"),
    **dict.fromkeys(("--explain",), "--why"),
    **dict.fromkeys(("--picture", "--figure", "--plots"), "--plot"),
    **dict.fromkeys(("--seed",), "--set environment.waves.seed="),
    **dict.fromkeys(("--duration", "--time"), "--set duration="),
    **dict.fromkeys(("--dt", "--step"), "--set solver.step="),
    **dict.fromkeys(("--method",), "--set solver.method="),
    **dict.fromkeys(("--seeds",), "seeds in STUDY.yaml"),
    **dict.fromkeys(("--csv",), "hydrosim export RUN.nc -o RUN.csv"),
    **dict.fromkeys(("--title", "--client"), "report in the case"),
}
"""What is typed or written here, by the option that was probably expected."""
DEFAULT_VALUES = {"schema": "case", "example": "list"}
"""Values of arguments that are now values of options."""


def current_arguments(arguments: list[str]) -> list[str]:
    """The arguments of a command line as they are typed now."""
    name, *others = arguments
    if name == "db" and others:
        return [name, others[0], *_renamed_options(others[0], others[1:])]
    if name not in NEW_WORDS:
        return arguments
    words = NEW_WORDS[name].split()
    others = _renamed_options(name, others)
    if "--help" in others:
        return [words[0], *others]
    if name in DEFAULT_VALUES:
        value = others.pop(0) if others and not others[0].startswith("-") else DEFAULT_VALUES[name]
        folder = others[1:] if others and others[0] in ("-o", "--output") else others
        return [words[0], *folder, words[1], value]
    if name == "explain":
        parts = [_take_value(others, "body"), _take_value(others, "direction") or "surge"]
        return ["show", *others, "--why", ".".join(part for part in parts if part)]
    if name == "line" and "--case" in others:
        return ["export", *others]
    if name == "line" and not any(part.startswith("--line") for part in others):
        return [*words, *others, "--line", "all"]
    return [words[0], *others, *words[1:]]


def _take_value(arguments: list[str], name: str) -> str:
    """Take an option out of the arguments; return its value."""
    option = f"--{name}"
    for k, argument in enumerate(arguments):
        if argument.startswith(f"{option}="):
            return arguments.pop(k).partition("=")[2]
        if argument == option and k + 1 < len(arguments):
            return arguments.pop(k) and arguments.pop(k)
    return ""


def _renamed_options(name: str, arguments: list[str]) -> list[str]:
    names = {f"--{old}": f"--{new}" for old, new in NEW_OPTIONS.get(name, {}).items()}
    parts = (argument.partition("=") for argument in arguments)
    return ["".join((names.get(option, option), *rest)) for option, *rest in parts]


def _meant_options(error: Any) -> list[str]:
    """What is typed in place of an unknown option, if the command has it."""
    option = OTHER_OPTIONS.get(getattr(error, "option_name", ""), "")
    context = getattr(error, "ctx", None)
    command = getattr(context, "command", None)
    names = [name for parameter in getattr(command, "params", ()) for name in parameter.opts]
    is_there = option.split(" ")[0] in names or not option.startswith("-")
    return [option] if option and is_there else []


class CommandsWithEarlierNames(TyperGroup):
    """All commands in their order, also under their earlier names."""

    def parse_args(self, context: Any, arguments: list[str]) -> list[str]:
        current = current_arguments(arguments) if arguments else arguments
        if current != arguments:
            print(f"note      this is now: hydrosim {shlex.join(current)}", file=sys.stderr)
        return super().parse_args(context, current)

    def resolve_command(self, context: Any, arguments: list[str]) -> Any:
        word = arguments[0]
        if word in OTHER_COMMANDS and word not in self.commands:
            context.fail(f"No such command '{word}'. Type: hydrosim {OTHER_COMMANDS[word]}")
        return super().resolve_command(context, arguments)

    def invoke(self, context: Any) -> Any:
        try:
            return super().invoke(context)
        except Exception as error:
            if options := _meant_options(error):
                error.__dict__["possibilities"] = options
            raise

    def shell_complete(self, context: Any, incomplete: str) -> Any:
        items = super().shell_complete(context, incomplete)
        if not incomplete:
            return items
        item_type = type(super().shell_complete(context, "")[0])
        earlier = [name for name in NEW_WORDS if name.startswith(incomplete)]
        return [*items, *map(item_type, earlier)]

    def list_commands(self, context: Any) -> list[str]:
        return list(self.commands)
