"""A page in the browser that shows a joint, served to this machine alone.

Drawn by viser, whose client comes with it: the page loads nothing from elsewhere. Everything of one
kind is one object of the scene, so that an update is a handful of messages, however many segments
and sensors there are.
"""

import logging
import socket
import threading
import time
import webbrowser
from collections import deque
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

import numpy as np

from ccgen.errors import ArgumentError, ToolError
from ccgen.joint import Joint
from ccgen.view.cameras import FIELD_OF_VIEW, aim, is_narrow
from ccgen.view.drawing import Colours, Drawing, drawing_of, pieces
from ccgen.view.origins import own_pages_only
from ccgen.view.panel import legend, numbers
from ccgen.view.sight import Bends, Errors, Floats, Sight, errors_of

if TYPE_CHECKING:
    from viser import ClientHandle, GuiUplotHandle, ViserServer

HOST = "127.0.0.1"
FIRST_PORT = 8080
_PORTS = 100

TIP = (0, 158, 115)
"""Colour of the tip."""
_TRACE, _GHOST, _BACKBONE, _RING = (140, 210, 185), (165, 165, 165), (0, 0, 0), (190, 190, 190)

_SCENE_SECONDS = 1 / 40
_PANEL_SECONDS = 0.2
_GONE_SECONDS = 5.0
"""Without anybody, before the page counts as closed: it may be loading again."""
_TRACED = 400
"""Places of the tip."""
_PLOTTED = 400
"""Points of a plot."""
_STEPS = tuple(float(f"{digit}e{power}") for power in range(-3, 4) for digit in (1, 2, 5))
"""Between the numbers of a plot, which are told with three decimals."""
_ACROSS = np.array([1.0, 1.0, 0.05])
"""Lengths of a frame's axes: z, along the joint, would hide it."""
_AROUND = 48
"""Pieces of a circle."""


class Page:
    """A joint on a page; give it sights.

    Attributes:
        url: where it is.
    """

    def __init__(self, server: "ViserServer", joint: Joint, truth: str | None) -> None:
        """Draw the straight joint.

        Args:
            server: with nothing on it.
            joint: its geometry and sensors.
            truth: what estimates are held against, in words; None where nothing is known.
        """
        self._server, self._joint = server, joint
        self.url = f"http://{HOST}:{server.get_port()}"
        self._trace: deque[Floats] = deque(maxlen=_TRACED)
        self._drawn = self._told = self._seen = float("-inf")
        self._pending: Sight | None = None
        straight = Sight(0.0, Bends.straight(joint), np.zeros(len(joint.sensors)))
        with server.atomic():
            self._add_surroundings()
            self._add_scene(drawing_of(joint, straight))
            self._plot = _Plot(joint, known=truth is not None)
            self._numbers = server.gui.add_html(numbers(joint, straight, None))
            self._handle = self._plot.add(server)
            server.gui.add_html(legend(truth))

    @property
    def due(self) -> bool:
        """Whether it is time for another sight; until then `show` keeps the latest."""
        return time.monotonic() - self._drawn >= _SCENE_SECONDS

    @property
    def opened(self) -> bool:
        """Whether somebody looks, or has looked."""
        self._look()
        return self._seen > float("-inf")

    @property
    def closed(self) -> bool:
        """Whether nobody looks any more, after somebody did."""
        return self.opened and time.monotonic() - self._seen > _GONE_SECONDS

    def show(self, sight: Sight) -> None:
        """Draw a sight, unless the one before has only just been drawn; then it waits."""
        self._pending = sight
        if self.due:
            self.settle()

    def settle(self) -> None:
        """Draw the sight that waits, if one does."""
        sight, self._pending = self._pending, None
        if sight is None:
            return
        self._drawn = time.monotonic()
        with self._server.atomic():
            self._draw(drawing_of(self._joint, sight), lost=bool(sight.lost))
            if self._drawn - self._told >= _PANEL_SECONDS:
                self._told = self._drawn
                errors = errors_of(self._joint, sight)
                self._plot.take(sight, errors)
                self._numbers.content = numbers(self._joint, sight, errors)
                self._handle.data = self._plot.data()

    def _look(self) -> None:
        if self._server.get_clients():
            self._seen = time.monotonic()

    def _add_surroundings(self) -> None:
        scene, length = self._server.scene, self._joint.geometry.length
        around = np.linspace(0.0, 2.0 * np.pi, _AROUND + 1)
        radius = max(sensor.radius for sensor in self._joint.sensors)
        ring = radius * np.stack([np.cos(around), np.sin(around), 0.0 * around], axis=1)
        _line(scene, "/base", pieces(ring), _RING, 2.0)
        scene.add_grid("/floor", width=2 * length, height=2 * length, plane="xy",
                       cell_size=length / 10, section_size=length / 2)  # fmt: skip
        camera = self._server.initial_camera
        aim(camera, length)
        camera.fov = FIELD_OF_VIEW
        camera.near, camera.far = 0.01 * length, 100.0 * length

        @self._server.on_client_connect
        def _(client: "ClientHandle") -> None:
            if is_narrow(client.camera.image_width):
                aim(client.camera, length, narrow=True)

    def _add_scene(self, drawing: Drawing) -> None:
        scene, joint = self._server.scene, self._joint
        length = joint.geometry.length
        axis = min(0.8 * joint.geometry.segment_length, 0.05 * length)
        self._ghost = _line(scene, "/truth", drawing.backbone, _GHOST, 3.0)
        self._ghost.visible = False
        self._backbone = _line(scene, "/backbone", drawing.backbone, _BACKBONE, 5.0)
        self._strings = _line(scene, "/sensors", drawing.strings,
                              _linear(drawing.string_colours), 4.0)  # fmt: skip
        self._trace_line = _line(scene, "/trace", np.repeat(drawing.tip[None, None], 2, 1), _TRACE,
                                 2.0)  # fmt: skip
        self._frames = scene.add_batched_axes(
            "/frames", drawing.turns, drawing.places, np.tile(_ACROSS, (len(drawing.places), 1)),
            axes_length=axis, axes_radius=0.05 * axis,
        )  # fmt: skip
        self._tip = scene.add_point_cloud(
            "/tip", np.zeros((1, 3)), TIP, point_size=0.025 * length, point_shape="circle",
            point_shading="flat", precision="float32", position=drawing.tip,
        )  # fmt: skip

    def _draw(self, drawing: Drawing, lost: bool) -> None:
        self._backbone.points = drawing.backbone.astype(np.float32)
        self._backbone.colors = np.array(_GHOST if lost else _BACKBONE, dtype=np.uint8)
        self._strings.points = drawing.strings.astype(np.float32)
        self._strings.colors = _linear(drawing.string_colours)
        self._frames.batched_positions = drawing.places.astype(np.float32)
        self._frames.batched_wxyzs = drawing.turns.astype(np.float32)
        self._tip.position = drawing.tip
        if len(drawing.ghost):
            self._ghost.points = drawing.ghost.astype(np.float32)
        self._ghost.visible = len(drawing.ghost) > 0
        if not lost:
            self._trace.append(drawing.tip)
        if len(self._trace) > 1:
            self._trace_line.points = pieces(np.array(self._trace)).astype(np.float32)


class _Plot:
    """What is plotted over time: errors where they are known, else the bend of the whole joint."""

    def __init__(self, joint: Joint, known: bool) -> None:
        self._axes = [axis for axis in joint.axes if axis != "h"]
        self._known = known
        self._points: deque[list[float]] = deque(maxlen=_PLOTTED)
        self._first: float | None = None

    def add(self, server: "ViserServer") -> "GuiUplotHandle":
        """Put it on the page."""
        colours = {"u": "#0072B2", "v": "#CC79A7", "tip": "#E67800"}
        names = [*self._axes, *(["tip"] if self._known else [])]
        series: list[Any] = [{}]
        for name in names:
            said = "tip / mm" if name == "tip" else f"{name} / deg"
            series.append({"label": said, "stroke": colours[name], "width": 1.5,
                           "scale": "mm" if name == "tip" else "y"})  # fmt: skip
        upright = {"size": 52, "incrs": _STEPS}
        axes: list[Any] = [{"label": "s", "labelSize": 16}, upright]
        if self._known:
            axes.append({**upright, "scale": "mm", "side": 1, "grid": {"show": False}})
        return server.gui.add_uplot(
            self.data(), tuple(series), height=170, axes=tuple(axes),
            title="error of a segment, of the tip" if self._known else "bend of the whole joint",
            scales={"x": {"time": False}}, legend={"show": True, "live": False},
            padding=(10, 10, 0, 0),
        )  # fmt: skip

    def take(self, sight: Sight, errors: Errors | None) -> None:
        """Add a point; what is not known is a gap."""
        self._first = sight.t if self._first is None else self._first
        if self._known:
            found = errors.bends if errors else {}
            values = [np.degrees(found.get(axis, np.nan)) for axis in self._axes]
            values.append(1e3 * errors.tip if errors else np.nan)
        else:
            values = [
                np.nan if axis in sight.lost else np.degrees(getattr(sight.estimate, axis).sum())
                for axis in self._axes
            ]
        self._points.append([sight.t - self._first, *map(float, values)])

    def data(self) -> tuple[Floats, ...]:
        """Columns: seconds, then a curve each."""
        columns = 1 + len(self._axes) + self._known
        points = np.array(self._points or [[0.0] + [np.nan] * (columns - 1)])
        return tuple(np.ascontiguousarray(column) for column in points.T)


@contextmanager
def open_page(joint: Joint, truth: str | None, port: int | None = None) -> Iterator[Page]:
    """Serve a page with a joint on it until the block ends.

    Args:
        joint: what is shown.
        truth: as of `Page`.
        port: to listen on; by default 8080 or the next one that is free.

    Raises:
        ToolError: viser is not installed, or no port is free.
        ArgumentError: that port is taken.
    """
    try:
        import rich
        from viser import ViserServer
    except ImportError as error:
        raise ToolError(
            "a view needs viser; install it with `pip install 'ccgen[view]'`"
        ) from error

    class LocalServer(ViserServer):
        """A server that nobody can ask to publish itself."""

        def request_share_url(self, verbose: bool = True) -> str | None:
            return None

    chosen = _free_port(port)
    logging.getLogger("websockets").addHandler(logging.NullHandler())
    console = rich.get_console()  # viser tells of itself there; stdout is for results
    quiet, console.quiet = console.quiet, True
    try:
        with own_pages_only():
            server = LocalServer(HOST, chosen, label=joint.name, verbose=False)
        try:
            if server.get_port() != chosen:
                raise ArgumentError(f"{chosen} was just taken; name another", "view_port")
            server.gui.configure_theme(show_logo=False, show_share_button=False)
            yield Page(server, joint, truth)
        finally:
            server.stop()
    finally:
        console.quiet = quiet


def open_browser(url: str) -> None:
    """Ask the desktop's browser to open a page.

    Raises:
        ToolError: there is none, or none but those of the terminal.
    """
    import os

    try:
        browser = webbrowser.get()
    except webbrowser.Error:
        browser = None
    if browser is None or (
        type(browser) is webbrowser.GenericBrowser and "BROWSER" not in os.environ
    ):
        raise ToolError("no browser was found to open the page in")
    threading.Thread(target=browser.open, args=(url,), daemon=True).start()


def _free_port(port: int | None) -> int:
    if port is not None:
        try:
            _try(port)
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise ArgumentError(
                f"{port} cannot be listened on ({reason}); name another port", "view_port"
            ) from error
        return port
    for candidate in range(FIRST_PORT, FIRST_PORT + _PORTS):
        try:
            _try(candidate)
        except OSError:
            continue
        return candidate
    raise ArgumentError(
        f"no port from {FIRST_PORT} to {FIRST_PORT + _PORTS - 1} is free; name another", "view_port"
    )


def _try(port: int) -> None:
    with socket.socket() as one:
        one.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        one.bind((HOST, port))
        one.listen()


def _linear(colours: Colours) -> Colours:
    """What viser draws in these colours: it takes those of single points as shares of light."""
    share = colours / 255.0
    light = np.where(share <= 0.04045, share / 12.92, ((share + 0.055) / 1.055) ** 2.4)
    return np.asarray(np.rint(255.0 * light), dtype=np.uint8)


def _line(scene: Any, name: str, points: Floats, colour: Any, pixels: float) -> Any:
    return scene.add_line_segments(
        name, points, np.asarray(colour, dtype=np.uint8), thickness=pixels, thickness_units="screen"
    )
