"""What the site is made of besides `docs/`.

Pages of the keys and commands from the program itself; what benchmarks measured, as they wrote it;
READMEs of cases, databases, benchmarks with their pictures; links that hold in both places.
"""

from __future__ import annotations

import json
import re
from os.path import relpath
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
BESIDE = ("cases", "hydro_db", "benchmarks")
SHOWN = {".md", ".png", ".yaml"}
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")
PLAIN = {"string": "a text", "boolean": "true or false", "integer": "a whole number"}


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Adds the pages that are made, and those beside `docs/`."""
    made = {"keys.md": keys, "studies_keys.md": study_keys, "commands.md": commands}
    made |= {"measured.md": measured}
    for name, text in made.items():
        files.append(File.generated(config, name, content=text()))
    files.append(File.generated(config, "index.md", abs_src_path=str(ROOT / "README.md")))
    for path in (p for folder in BESIDE for p in sorted((ROOT / folder).rglob("*"))):
        if path.suffix in SHOWN:
            own = path.relative_to(ROOT).as_posix()
            files.append(File.generated(config, own, abs_src_path=str(path)))
    return files


def on_page_markdown(text: str, page: Page, files: Files, **_: Any) -> str:
    """Links as they hold in the repository, changed to hold in the site; those to files that the
    site has not become plain text. PluginError where a link leads nowhere."""
    real = Path(page.file.abs_src_path or DOCS / page.file.src_uri)

    def changed(found: re.Match[str]) -> str:
        picture, words, target, anchor = found.groups()
        if "://" in target or target.startswith("mailto:"):
            return found[0]
        place = (real.parent / target).resolve()
        own = place.relative_to(ROOT).as_posix().removeprefix("docs/")
        there = files.get_file_from_path(own) is not None
        if not (place.exists() or there):
            raise PluginError(f"{page.file.src_uri}: a link leads to {target}, which is not there")
        if not there:
            return words
        way = relpath(own, Path(page.file.src_uri).parent)
        return f"{picture}[{words}]({way}{anchor or ''})"

    return LINK.sub(changed, text)


def keys() -> str:
    """The keys of case files, from their schema."""
    from hydrosim.commands.schema import Kind

    said = (
        "What a case file may hold, as the program reads it: `hydrosim schema case` prints the same"
    )
    return _keys(Kind.CASE, f"# Keys of a case file\n\n{said} for editors.\n")


def study_keys() -> str:
    """The keys of study files."""
    from hydrosim.commands.schema import Kind

    return _keys(Kind.STUDY, "# Keys of a study file\n\nWhat `hydrosim sweep` and others take.\n")


def _keys(kind: Any, title: str) -> str:
    from hydrosim.commands.schema import schema_of

    shared = schema_of(kind)["$defs"]
    others = [n for n in shared if n not in ("Whole", "Over") and "Part_" not in n]
    names = ["Whole", *sorted(n for n in others if "allOf" not in shared[n])]
    parts = [title]
    for name in names:
        each = shared[name]
        if each.get("type") != "object" or "properties" not in each:
            continue
        head = "The file" if name == "Whole" else name
        parts.append(f"\n## {head}\n\n{each.get('description', '')}\n")
        parts.append("| key | meaning | value | default |\n| --- | --- | --- | --- |")
        needed = set(each.get("required", ()))
        for key, value in each["properties"].items():
            if value is not False:
                default = "needed" if key in needed else _default(value.get("default"))
                meaning = value.get("description", "")
                parts.append(f"| `{key}` | {meaning} | {_holds(value, shared)} | {default} |")
    return "\n".join(parts) + "\n"


def _default(value: object) -> str:
    return "" if value in (None, [], {}) else f"`{value}`" if not isinstance(value, dict) else ""


def _holds(value: dict[str, Any], shared: dict[str, Any]) -> str:
    """What a value is, in words."""
    examples = value.get("examples", [])
    example = f", such as `{examples[0]}`" if examples and isinstance(examples[0], str) else ""
    if "$ref" in value:
        name = value["$ref"].rsplit("/", 1)[1]
        target = shared[name]
        is_mapping = "properties" in target and "allOf" not in target
        return f"[{name}](#{name.lower()})" if is_mapping else _holds(target, shared)
    if "quantity" in value:
        return f"{value['quantity']}{example}"
    if "enum" in value:
        return ", ".join(f"`{x}`" for x in value["enum"])
    if "const" in value:
        return f"`{value['const']}`"
    if "allOf" in value:
        return " or ".join(_holds(each["then"], shared) for each in value["allOf"])
    if "anyOf" in value:
        found = [_holds(each, shared) for each in value["anyOf"] if each.get("type") != "null"]
        return " or ".join(dict.fromkeys(x for x in found if x))
    if value.get("type") == "array":
        inner = value.get("items") or (value.get("prefixItems") or [{}])[0]
        count = value.get("minItems")
        times = f"{count} times " if count and count > 1 else ""
        return f"a list of {times}{_holds(inner, shared)}"
    if isinstance(value.get("additionalProperties"), dict):
        return f"by name, {_holds(value['additionalProperties'], shared)}"
    return PLAIN.get(value.get("type", ""), value.get("type", "")) + example


def measured() -> str:
    """What benchmarks have written to be kept, each with what it was made with."""
    parts = [
        "# As measured\n\nTables as `python -m benchmarks --keep QUESTION` wrote them;"
        " what the questions are is said with the [benchmarks](benchmarks/README.md).\n"
    ]
    for path in sorted((ROOT / "benchmarks" / "measured").glob("*.json")):
        found = json.loads(path.read_text("utf-8"))
        made_with = "; ".join(f"{name}: {value}" for name, value in found["machine"].items())
        parts.append(f"\n## {path.stem}\n\n{made_with}\n")
        parts += [f"\n{title}\n\n{_table(rows)}" for title, rows in found["tables"].items()]
        parts.append("".join(f"\n* {remark}" for remark in found["remarks"]))
    return "\n".join(parts) + "\n"


def _table(rows: list[dict[str, Any]]) -> str:
    """Rows with the same keys as a table in markdown."""
    lines = [list(rows[0]), ["---"] * len(rows[0]), *(map(_cell, row.values()) for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def _cell(value: object) -> str:
    shown = f"{value:.3g}" if isinstance(value, float) else str(value)
    return shown.replace("|", "\\|")


def commands() -> str:
    """The commands with their options, as `--help` says them."""
    from typer.main import get_command

    from hydrosim.__main__ import app

    return "# Commands\n" + "".join(_command(get_command(app), "hydrosim"))


def _command(command: Any, name: str) -> list[str]:
    if hasattr(command, "commands"):
        each = sorted(command.commands.items())
        return [part for own, one in each for part in _command(one, f"{name} {own}")]
    table = "| option | what it does | if not given |\n| --- | --- | --- |\n"
    lines = [f"\n## {name}\n\n{command.help}\n\n{table}"]
    for option in command.params:
        names = ", ".join(f"`{x}`" for x in getattr(option, "opts", [option.name]))
        default = option.default
        told = "" if default in (None, False, [], ()) or callable(default) else f"`{default}`"
        text = (getattr(option, "help", "") or "").replace("|", "or")
        lines.append(f"| {names} | {text} | {'needed' if option.required else told} |\n")
    return lines
