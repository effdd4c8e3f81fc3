"""Where templates, C runtime and licence lie: in the installed package or beside the sources."""

from pathlib import Path

_PACKAGE = Path(__file__).resolve().parent


def _resource(name: str) -> Path:
    installed = _PACKAGE / "_data" / name
    return installed if installed.exists() else _PACKAGE.parent / name


def templates() -> Path:
    """Return the folder of Jinja2 templates."""
    return _resource("templates")


def firmware() -> Path:
    """Return the folder of the C runtime."""
    return _resource("firmware_c")


def licence() -> Path:
    """Return the licence's text."""
    return _resource("LICENSE")
