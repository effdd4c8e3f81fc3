"""Where the templates and the C runtime lie: in the installed package or beside the sources."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def _folder(name: str) -> Path:
    installed = _PACKAGE / "_data" / name
    return installed if installed.is_dir() else _PACKAGE.parent / name


def templates() -> Path:
    """Return the folder of Jinja2 templates."""
    return _folder("templates")


def firmware() -> Path:
    """Return the folder of the C runtime."""
    return _folder("firmware_c")
