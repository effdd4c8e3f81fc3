"""Web pages from elsewhere may not look at a joint, though their browser reaches this machine."""

from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Any
from urllib.parse import urlsplit

_HERE = ("127.0.0.1", "localhost", "::1")


@contextmanager
def own_pages_only() -> Iterator[None]:
    """Refuse requests of pages of another host in servers that viser starts within the block.

    A browser lets any page open a socket to 127.0.0.1 and says from where in the header Origin.
    viser neither looks at it nor passes on what websockets would do with it.
    """
    from websockets.asyncio import server

    serve = server.serve

    def guarded(*args: Any, process_request: Any, **options: Any) -> Any:
        def process(connection: Any, request: Any) -> Any:
            origin = request.headers.get("Origin")
            if origin is not None and not _is_here(origin):
                return connection.respond(HTTPStatus.FORBIDDEN, "of a page from elsewhere\n")
            return process_request(connection, request)

        return serve(*args, process_request=process, **options)

    # For mypy `serve` is a class, which nothing may take the place of; viser only calls it.
    server.serve = guarded  # type: ignore[assignment,misc]
    try:
        yield
    finally:
        server.serve = serve  # type: ignore[misc]


def _is_here(origin: str) -> bool:
    try:
        return urlsplit(origin).hostname in _HERE
    except ValueError:
        return False
