"""What commands with --view share: its options, and the page while a command runs."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

from ccgen.cli.output import note
from ccgen.errors import InputError, ToolError

if TYPE_CHECKING:
    from ccgen.joint import Joint
    from ccgen.view.page import Page

View = Annotated[
    bool,
    typer.Option(
        "--view", help="Show the joint in three dimensions, in a browser; needs ccgen[view]."
    ),
]
ViewPort = Annotated[
    int | None,
    typer.Option(
        "--view-port",
        min=1,
        max=65535,
        metavar="PORT",
        help="Where the page is, on this machine alone.  [default: 8080, or the next free one]",
    ),
]
NoBrowser = Annotated[
    bool, typer.Option("--no-browser", help="With --view: say where the page is, open nothing.")
]

_GLANCE = 0.02


def check_view(view: bool, port: int | None, no_browser: bool) -> None:
    """Refuse options of a page where there is none."""
    if not view and (port is not None or no_browser):
        name = "--no-browser" if no_browser else "--view-port"
        raise InputError(f"{name}: belongs to --view; add it, or leave this out")


@contextmanager
def viewed(
    joint: "Joint", truth: str | None, port: int | None, no_browser: bool
) -> "Iterator[Page]":
    """A page with a joint on it, open in the browser or told where it is.

    Raises:
        ToolError: viser is not installed, or there is no browser to open it.
        ArgumentError: the port is taken.
    """
    from ccgen.view.page import open_browser, open_page

    with open_page(joint, truth, port) as page:
        if no_browser:
            note(f"the joint is at {page.url}; Ctrl-C ends")
        else:
            try:
                open_browser(page.url)
            except ToolError as error:
                raise ToolError(
                    f"{error}; with --no-browser you open {page.url} yourself, from elsewhere "
                    f"through ssh -L {page.url.rpartition(':')[2]}:{page.url.removeprefix('http://')}"
                ) from error
            note(f"the joint is at {page.url}, in your browser; Ctrl-C ends")
        yield page


def wait_for_somebody(page: "Page", ended: Callable[[], bool]) -> None:
    """Wait until the page is open, or the command is asked to end."""
    while not page.opened and not ended():
        time.sleep(_GLANCE)


def stay(page: "Page", ended: Callable[[], bool]) -> Iterator[None]:
    """Draw what waits; go on until the page is closed, or the command is asked to end."""
    while not page.closed and not ended():
        page.settle()
        yield
        time.sleep(_GLANCE)
