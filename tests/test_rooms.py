"""The rooms of the package import what the architecture table of the README allows, and no more."""

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

ROOT = Path(__file__).parent.parent
PACKAGE = ROOT / "ccgen"
_ROW = re.compile(r"^\| (?P<places>`ccgen/[^|]*) \|[^|]*\| (?P<allowed>[^|]*) \|$", re.MULTILINE)


def table():
    """Allowed rooms by room, as the README states them, without what those may import in turn."""
    allowed = {}
    for row in _ROW.finditer((ROOT / "README.md").read_text(encoding="utf-8")):
        for place in re.findall(r"`ccgen/([a-z_0-9]+)(?:/|\.py)`", row["places"]):
            names = row["allowed"].strip()
            allowed[place] = set() if names == "–" else set(re.split(r",\s*", names))
    return allowed


def reachable():
    """Every room that a room may import, those of its imports included."""
    stated = table()
    leaves = {path.stem for path in PACKAGE.glob("*.py") if not path.stem.startswith("__")}
    full = {}
    ordered = TopologicalSorter(
        {room: names - {"everything"} for room, names in stated.items()}
    ).static_order()
    for room in ordered:
        names = set(stated) if "everything" in stated[room] else stated[room]
        full[room] = names.union(*(full.get(name, set()) for name in names)) | leaves | {room}
    return full


def modules():
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for path in PACKAGE.rglob("*.py")
    }


def imports(path, known):
    """Modules of the package that a file imports, also where it does so inside a function."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("ccgen"):
            for alias in node.names:
                name = f"{node.module}.{alias.name}"
                yield name if name in known else node.module
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name.startswith("ccgen"))


def test_rooms_that_can_be_called_are_imported_by_module_within():
    """They import their modules when they are called: `from` the room itself is a circle."""
    circles = [
        f"{name}: from {node.module} import ..."
        for name, path in modules().items()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom)
        and node.module in [f"ccgen.{own}" for own in ("cost", "export", "report", "verify")]
        and room(name) == node.module.removeprefix("ccgen.")
    ]
    assert circles == []


def room(name):
    return name.split(".")[1] if "." in name else None


def test_every_room_of_the_package_stands_in_the_table():
    rooms = {path.name for path in PACKAGE.iterdir() if (path / "__init__.py").exists()}
    assert rooms | {"errors", "outputs", "resources", "digits", "e2e"} == set(table())


def test_no_room_imports_what_the_table_does_not_allow():
    allowed, known = reachable(), modules()
    broken = [
        f"{name} imports {target}"
        for name, path in known.items()
        if room(name) in allowed
        for target in imports(path, known)
        if room(target) is not None and room(target) not in allowed[room(name)]
    ]
    assert broken == []


def test_errors_of_the_library_name_no_options_of_the_command_line():
    named = [
        f"{name}, line {node.lineno}: {word}"
        for name, path in modules().items()
        if room(name) != "cli"
        for error in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(error, ast.Raise)
        for node in ast.walk(error)
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
        for word in re.findall(r"(?<![`\w-])--[a-z][a-z-]+", node.value)
    ]
    assert named == []


def test_no_module_imports_itself_in_a_circle():
    known = modules()
    graph = {
        name: {target for target in imports(path, known) if target in known and target != "ccgen"}
        - {name}
        for name, path in known.items()
    }
    list(TopologicalSorter(graph).static_order())  # raises CycleError with the circle's names
