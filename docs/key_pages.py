"""The pages of `docs/reference/`: keys of files from their JSON schema, and commands.

``python docs/key_pages.py`` writes them. Each key has its meaning, unit, default and example. A
section is a mapping of the file. Its title is the first place where the mapping may stand, such as
``bodies.NAME.tanks.NAME``. Mappings with the same keys share a section.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import yaml

Schema = dict[str, Any]

DIRECTIONS = {"surge", "sway", "heave", "roll", "pitch", "yaw"}
PREFIX = re.compile(r"^(With|Without)_")  # of definitions in the schema of files of two kinds
PLAIN = {"string": "a text", "boolean": "true or false", "integer": "a whole number"}
QUOTE = "'"
FOLDER = Path(__file__).parent / "reference"
INTRODUCTIONS = {
    "keys.md": """# Keys of a case file

Here you look up what a key of a case means, its unit, its default and an example. `hydrosim new`
writes a case to begin with, and `hydrosim check` names the line of a mistake.
""",
    "study_keys.md": """# Keys of a study file

Here you look up the keys of a study, which `hydrosim study` takes. [Many runs](../studies.md) says
what it is for.
""",
    "recipe_keys.md": """# Keys of a recipe

Here you look up how to describe a hull of which `hydrosim db build` computes a database.
[Recipes](../recipes.md) shows whole ones.
""",
}
READING = """A number without a unit is in the unit of the third column. A text may carry any other
unit of that kind, such as `"12.4 m"`. `NAME` stands for a name that you choose. A key without a
default may be left out unless it is needed. `hydrosim new --schema {kind}` prints the same for
editors. This page is written by `python docs/key_pages.py`.
"""
COMMANDS = """# Commands

Here you look up a command and its options, as `hydrosim COMMAND --help` prints them. The
[cookbook](../cookbook.md) shows them at work. This page is written by `python docs/key_pages.py`.
"""
HEAD = "| key | meaning | unit | if not given | example |\n| --- | --- | --- | --- | --- |"


@dataclass
class Section:
    """A mapping of the file: its title, its schema, and others with the same keys."""

    title: str
    schema: Schema
    level: int
    alike: list[Schema] = field(default_factory=list)

    @property
    def anchor(self) -> str:
        """Its name in links, as GitHub and mkdocs make it from the title."""
        return re.sub(r"[^\w -]", "", self.title.lower()).replace(" ", "-")


class Pages:
    """Sections of all mappings that can be reached from the whole file."""

    def __init__(self, shared: dict[str, Schema]) -> None:
        self.shared = shared
        self.sections: dict[str, Section] = {}

    def text(self) -> str:
        """All sections in markdown."""
        return "\n".join(self._section(section) for section in self.sections.values())

    def collect(self, schema: Schema, title: str, path: str, level: int = 2) -> None:
        """Adds the section of a mapping, and those of the mappings in it."""
        identity = self._identity(schema)
        if known := self.sections.get(identity):
            known.alike.append(schema)
            return
        self.sections[identity] = Section(self._unused(title, schema), schema, level)
        for key, value in _keys(schema):
            own = f"{path}.{key}" if path else key
            self._collect_inside(value, own, level + 1)

    def _collect_inside(self, value: Schema, path: str, level: int) -> None:
        """Adds the sections of mappings that the ``value`` of a key may be."""
        for target, way, choice in self._mappings(value, path):
            if self._is_by_direction(target):
                for _, part in _keys(target):
                    self._collect_inside(part, way, level)
            else:
                self.collect(target, f"{way}, {choice}" if choice else way, way, min(level, 4))

    def _mappings(
        self, value: Any, path: str, choice: str = ""
    ) -> Iterator[tuple[Schema, str, str]]:
        """Mappings with keys that a value may be or hold, with their path and what tells them from
        others, such as "type: fender"."""
        if not isinstance(value, dict):
            return
        found = self._target(value)
        if "properties" in found and "allOf" not in found:
            yield found, path, choice
        for then, said in _choices(found).items():
            yield from self._mappings({"$ref": then}, path, said)
        for each in (*found.get("anyOf", ()), *found.get("prefixItems", ())):
            yield from self._mappings(each, path, choice)
        yield from self._mappings(found.get("items"), path, choice)
        yield from self._mappings(found.get("additionalProperties"), f"{path}.NAME", choice)

    def _target(self, value: Schema) -> Schema:
        """The definition that a value refers to, or the value."""
        while "$ref" in value:
            value = self.shared[value["$ref"].rsplit("/", 1)[1]]
        return value

    def _is_by_direction(self, schema: Schema) -> bool:
        return set(schema["properties"]) <= DIRECTIONS

    def _identity(self, schema: Schema) -> str:
        """The same for mappings that have the same keys with the same meanings."""
        told = {key: _meaning(value)[0] or self._kind(value) for key, value in _keys(schema)}
        kinds = [value["const"] for _, value in _keys(schema) if "const" in value]
        return json.dumps([told, kinds, sorted(schema.get("required", ()))])

    def _unused(self, title: str, schema: Schema) -> str:
        """A title that no other section has: with keys that are needed, or a number."""
        needed = schema.get("required") or [key for key, _ in _keys(schema)]
        tried = [title, f"{title}, with {', '.join(needed)}"]
        tried += [f"{tried[1]} ({k})" for k in range(2, 100)]
        taken = {section.title for section in self.sections.values()}
        return next(each for each in tried if each not in taken)

    def _section(self, section: Section) -> str:
        lines = [f"\n{'#' * section.level} {section.title}\n"]
        if said := section.schema.get("description", ""):
            lines.append(f"{' '.join(said.split())}\n")
        lines.append(HEAD)
        needed = section.schema.get("required", ())
        for key, value in _keys(section.schema):
            units = [_meaning(value)[1]]
            units += [_meaning(other["properties"][key])[1] for other in section.alike]
            cells = (
                f"`{key}`",
                self._holds(value),
                ", or ".join(dict.fromkeys(unit for unit in units if unit)),
                "needed" if key in needed else _shown(value.get("default")),
                self._example(key, value),
            )
            lines.append(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in cells)} |")
        return "\n".join(lines) + self._whole_example(section.schema)

    def _holds(self, value: Schema) -> str:
        """Meaning of a key, with links to the sections of mappings that it may hold."""
        meaning = _meaning(value)[0]
        found = self._target(value)
        kind = "" if found.keys() & {"examples", "quantity", "const"} else self._kind(value)
        parts = [meaning or _meaning(found)[0], kind[:1].upper() + kind[1:] if kind else ""]
        links = _linked(list(self._links(value)))
        names = self._names(value)
        parts += [f"By name: {', '.join(f'`{name}`' for name in names)}"] if names else []
        parts += [f"Keys: {', '.join(links)}"] if links else []
        return " ".join(part if part.endswith(".") else f"{part}." for part in parts if part)

    def _links(self, value: Schema) -> Iterator[Section]:
        for target, _, _ in self._mappings(value, ""):
            if self._is_by_direction(target):
                for _, part in _keys(target):
                    yield from self._links(part)
            else:
                yield self.sections[self._identity(target)]

    def _names(self, value: Schema) -> list[str]:
        """Directions that a value may be given by."""
        found = (target for target, _, _ in self._mappings(value, ""))
        named = (target for target in found if self._is_by_direction(target))
        return list(dict.fromkeys(key for target in named for key, _ in _keys(target)))

    def _kind(self, value: Schema) -> str:
        """What a value is, where it is a word or a plain kind of value."""
        found = self._target(value)
        if "enum" in found:
            return f"one of {', '.join(f'`{each}`' for each in found['enum'])}"
        if "const" in found:
            return f"`{found['const']}`"
        if "anyOf" in found and "quantity" not in found:
            kinds = (self._kind(each) for each in found["anyOf"])
            words = [kind for kind in dict.fromkeys(kinds) if kind.startswith(("`", "one of"))]
            return " or ".join(words)
        items = found.get("items")
        if isinstance(items, dict) and "enum" in self._target(items):
            return f"a list of {self._kind(items).removeprefix('one of ')}"
        return PLAIN.get(found.get("type", ""), "")

    def _example(self, key: str, value: Schema) -> str:
        """A key with a value, as in a file."""
        found = self._value(value)
        if found is None:
            return ""
        text = yaml.safe_dump([found], default_flow_style=True, width=math.inf, sort_keys=False)
        return f"`{key}: {text.strip()[1:-1].strip(QUOTE)}`"

    def _value(self, value: Schema) -> Any:
        """An example of a value, None where nobody gave one."""
        if examples := value.get("examples"):
            return examples[0]
        found = self._target(value)
        if examples := found.get("examples"):
            return examples[0] if "properties" not in found else None
        if "const" in found:
            return found["const"]
        if "enum" in found:
            return next((each for each in found["enum"] if each != value.get("default")), None)
        if "prefixItems" in found:
            each = [self._value(part) for part in found["prefixItems"]]
            return each if len(each) == 3 and all(map(_is_quantity, each)) else None
        if isinstance(found.get("items"), dict):
            one = self._value(found["items"])
            return None if one is None else [one]
        tried = (self._value(each) for each in found.get("anyOf", ()))
        if found_one := next((each for each in tried if each is not None), None):
            return found_one
        if found.get("type") == "boolean":
            return not value.get("default", False)
        return None

    def _whole_example(self, schema: Schema) -> str:
        examples = schema.get("examples")
        if not examples:
            return "\n"
        text = yaml.safe_dump(examples[0], sort_keys=False, default_flow_style=None, width=90)
        return f"\n\n```yaml\n{text}```\n"


def pages_of(schema: Schema) -> str:
    """Sections of a file in markdown. Files of two kinds have the keys of both."""
    shared = schema["$defs"]
    pages = Pages(shared)
    for branch in ("else", "then"):
        for name in re.findall(r'"#/\$defs/(\w*Whole)"', json.dumps(schema.get(branch, {}))):
            kind = schema["if"]["required"][0]
            several = PREFIX.match(name) is not None and branch == "then"
            pages.collect(shared[name], f"The file, with {kind}" if several else "The file", "")
    return pages.text()


def _linked(sections: list[Section]) -> list[str]:
    """Links to sections; of several kinds of one mapping, by what tells them apart."""
    kinds = [re.sub(r".*, \w+: ", "", each.title) for each in sections]
    shown = kinds if len(kinds) > 2 else [each.title for each in sections]
    links = (f"[{text}](#{each.anchor})" for text, each in zip(shown, sections, strict=True))
    return list(dict.fromkeys(links))


def _choices(schema: Schema) -> dict[str, str]:
    """Definitions that a mapping may follow, and what tells them: "type: fender", or "type: strut
    or power_take_off"."""
    names: dict[str, list[str]] = {}
    for each in schema.get("allOf", ()):
        ((key, said),) = each["if"]["properties"].items()
        names.setdefault(each["then"]["$ref"], [f"{key}: "]).append(said["const"])
    return {then: key + " or ".join(every) for then, (key, *every) in names.items()}


def _keys(schema: Schema) -> Iterator[tuple[str, Schema]]:
    """Keys of a mapping with what they hold; no key that only says that it must not stand there."""
    return ((key, value) for key, value in schema["properties"].items() if value is not False)


def _meaning(value: Schema) -> tuple[str, str]:
    """Meaning of a key and its unit, which ends its description."""
    meaning, _, unit = " ".join(value.get("description", "").split()).partition("Unit: ")
    return meaning.strip(), unit.removesuffix(".")


def _shown(value: object) -> str:
    """The default of a key; none where the section of a mapping tells its parts."""
    if value in (None, [], {}, "") or isinstance(value, dict):
        return ""
    if isinstance(value, float) and math.isinf(value):
        return "`infinite`"
    return f"`{_plain(value)}`"


def _is_quantity(value: object) -> bool:
    """Whether an example is a number with its unit; words and lists need examples of their own."""
    return isinstance(value, str) and " " in value


def _plain(value: object) -> object:
    """A value as it may be written in a file."""
    if isinstance(value, list):
        return f"[{', '.join(str(_plain(each)) for each in value)}]"
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else value


def reference_pages() -> dict[Path, str]:
    """All pages of the reference: file and text."""
    from hydrosim.interface.new import FileKind, schema_of

    pages = {}
    for kind, name in zip(FileKind, INTRODUCTIONS, strict=True):
        reading = READING.format(kind=kind.value)
        pages[FOLDER / name] = f"{INTRODUCTIONS[name]}\n{reading}\n{pages_of(schema_of(kind))}"
    pages[FOLDER / "commands.md"] = COMMANDS + "".join(_all_commands())
    return {path: f"{text.rstrip()}\n" for path, text in pages.items()}


def _all_commands() -> list[str]:
    from typer.main import get_command

    from hydrosim.__main__ import app

    return _command(get_command(app), "hydrosim")


def _command(command: Any, name: str) -> list[str]:
    """A section of a command, or those of the commands below it, in the order of use."""
    if hasattr(command, "commands"):
        commands = command.commands.items()
        return [part for word, inner in commands for part in _command(inner, f"{name} {word}")]
    table = "| option | what it does | if not given |\n| --- | --- | --- |\n"
    lines = [f"\n## {name}\n\n{command.help}\n\n{table}"]
    for option in command.params:
        names = ", ".join(f"`{x}`" for x in getattr(option, "opts", [option.name]))
        default = option.default
        shown = "" if default in (None, False, "", [], ()) or callable(default) else f"`{default}`"
        text = (getattr(option, "help", "") or "").replace("|", "or")
        lines.append(f"| {names} | {text} | {'needed' if option.required else shown} |\n")
    return lines


if __name__ == "__main__":
    FOLDER.mkdir(exist_ok=True)
    for path, text in reference_pages().items():
        path.write_text(text, "utf-8")
