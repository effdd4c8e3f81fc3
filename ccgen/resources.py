"""Where templates, C runtime and licence lie: in the installed package or beside the sources."""

import functools
import sys
from contextlib import suppress
from importlib.util import cache_from_source
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from jinja2 import BytecodeCache, Environment, Template

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
        bytecode_cache=_compiled(),
    )


def _compiled() -> "BytecodeCache":
    """Keeps compiled templates where Python keeps this package's modules, and whenever it does.

    Compiling them takes longer than anything else of an export but integer poses.
    """
    import jinja2
    from jinja2.bccache import Bucket, FileSystemBytecodeCache

    class Compiled(FileSystemBytecodeCache):
        def dump_bytecode(self, bucket: Bucket) -> None:
            if not sys.dont_write_bytecode:
                with suppress(OSError):  # a folder that is not there or not ours
                    super().dump_bytecode(bucket)

    folder = Path(cache_from_source(__file__)).parent
    return Compiled(str(folder), f"template-{jinja2.__version__}-%s.cache")


def firmware() -> Path:
    """Return the folder of the C runtime."""
    return _resource("firmware_c")


def licence() -> Path:
    """Return the licence's text."""
    return _resource("LICENSE")
