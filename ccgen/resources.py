"""Where templates, C runtime and licence lie: in the installed package or beside the sources."""

import functools
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from jinja2 import Environment, Template

_PACKAGE = Path(__file__).resolve().parent


def _resource(name: str) -> Path:
    installed = _PACKAGE / "_data" / name
    return installed if installed.exists() else _PACKAGE.parent / name


def template(name: str) -> "Template":
    """Return the template of that name; a value that it asks for and is not given is an error.

    Values are escaped in HTML alone.
    """
    return _environment().get_template(name)


@functools.cache
def _environment() -> "Environment":
    from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

    return Environment(
        loader=FileSystemLoader(_resource("templates")),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=select_autoescape(["html.j2"], default=False),
    )


def firmware() -> Path:
    """Return the folder of the C runtime."""
    return _resource("firmware_c")


def licence() -> Path:
    """Return the licence's text."""
    return _resource("LICENSE")
