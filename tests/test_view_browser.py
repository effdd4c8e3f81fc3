"""The page of `--view` in a browser: a bent joint where its pose projects to, and no scrolling."""

import io
import math
from dataclasses import replace

import numpy as np
import pytest
from chromium import chromium
from test_view import RANGE, SHOULDER
from waiting import becomes

import ccgen
from ccgen.figures.curves import string_paths
from ccgen.sensing.bending import Bending
from ccgen.view.drawing import _frames as frames_of
from ccgen.view.drawing import drawing_of
from ccgen.view.page import TIP, open_page
from ccgen.view.simulated import as_found, simulated_sights

DISMISS = """
(() => {
  const found = [...document.querySelectorAll(".mantine-Notification-root")]
    .filter(one => one.innerText.includes("Software WebGL"));
  found.forEach(one => one.querySelector("button").click());
  return document.querySelectorAll(".mantine-Notification-root").length;
})()
"""
SIZES = """
(() => {
  const canvas = document.querySelector("canvas").getBoundingClientRect();
  return [document.documentElement.scrollWidth, innerWidth, document.body.scrollWidth,
          canvas.left, canvas.top, canvas.width, canvas.height];
})()
"""


def turned(wxyz):
    """The rotation of a quaternion."""
    w, x, y, z = wxyz
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def projected(camera, point, canvas):
    """Where a camera that looks along its z, y down, sees a point; pixels of the page."""
    left, top, width, height = canvas
    x, y, z = turned(camera.wxyz).T @ (point - camera.position)
    focal = height / 2 / math.tan(camera.fov / 2)
    return np.array([left + width / 2 + focal * x / z, top + height / 2 + focal * y / z])


def pixels_of(picture):
    """A PNG's pixels, shape (rows, columns, 3)."""
    import imageio.v3

    return imageio.v3.imread(io.BytesIO(picture))[..., :3].astype(int)


def marker(picture):
    """The middle of what has the colour of the tip; None where nothing has."""
    pixels = pixels_of(picture)
    rows, columns = np.nonzero((np.abs(pixels - TIP) <= 2).all(axis=-1))
    if len(rows) < 40:
        return None
    return np.array([columns.min() + columns.max() + 1, rows.min() + rows.max() + 1]) / 2


@pytest.mark.slow
def test_the_tip_is_seen_where_its_pose_projects_to(tmp_path):
    fit = ccgen.fit(ccgen.load(SHOULDER))
    joint = as_found(fit)
    simulation = Bending("end-force", RANGE, "u").at(joint)
    (sight,) = simulated_sights(fit, [simulation])
    with open_page(joint, "the simulated shape") as page, chromium(tmp_path) as tab:
        page.show(sight)
        page.settle()
        for width in (1400, 390):
            looked = Looked(page, tab, tmp_path, width)
            looked.settled(simulation.tip_pose[:3, 3], str(width))
            scrolled, inner, body = tab.evaluate(SIZES)[:3]
            assert max(scrolled, body) <= inner == width
            for x, y in looked.at(drawing_of(joint, sight).backbone[:, 0]):
                on_top = tab.evaluate(f"document.elementFromPoint({x}, {y}).tagName")
                assert on_top == "CANVAS", (width, x, y)
        assert tab.said == []
        outside = [url for url in tab.asked if not url.startswith(("data:", "blob:", page.url))]
        assert outside == []


PANEL = 330
"""Pixels at the right that the panel may cover."""
NEAR = 30
"""Pixels about a line in which it, the axes of frames and the tip's disc are drawn."""


class Looked:
    """A page that a browser looks at."""

    def __init__(self, page, tab, folder, width=1400):
        self.page, self.tab, self.folder, self.width = page, tab, folder, width
        self.reload()

    def reload(self):
        before = set(self.page._server.get_clients())
        self.tab.open(self.page.url, self.width)
        assert becomes(lambda: set(self.page._server.get_clients()) - before)
        assert becomes(lambda: self.tab.evaluate("!!document.querySelector('canvas')"))
        clients = self.page._server.get_clients()
        self.camera = clients[max(clients)].camera
        assert becomes(
            lambda: self.tab.evaluate(DISMISS) == 0 and marker(self.tab.picture()) is not None
        )
        self.canvas = self.tab.evaluate(SIZES)[3:]

    def at(self, points):
        """Where points are seen, shape (..., 2)."""
        flat = np.reshape(points, (-1, 3))
        seen = [projected(self.camera, point, self.canvas) for point in flat]
        return np.reshape(seen, (*np.shape(points)[:-1], 2))

    def show(self, sight, tip, name):
        """The picture of a sight once it stands still, without the panel."""
        self.page.show(sight)
        self.page.settle()
        return self.settled(tip, name)

    def settled(self, tip, name):
        expected, last = self.at(tip), [b""]

        def still():
            taken = self.tab.picture()
            middle = marker(taken)
            done = taken == last[-1] and middle is not None
            last.append(taken)
            return done and np.abs(middle - expected).max() < 3.0

        assert becomes(still), name
        (self.folder / f"{name}.png").write_bytes(last[-1])
        return pixels_of(last[-1])[:, :-PANEL]


def differing(one, other):
    """Which pixels of two pictures differ by more than rounding."""
    return np.abs(one - other).max(axis=-1) > 8


def about(lines, shape):
    """Pixels near lines of shape (k, 2, 2), ends as seen."""
    near = np.zeros(shape, dtype=bool)
    for one, other in lines:
        left, top = np.maximum(np.minimum(one, other) - NEAR, 0).astype(int)
        right, bottom = (np.maximum(one, other) + NEAR).astype(int) + 1
        box = near[top:bottom, left:right]
        rows, columns = np.indices(box.shape)
        away = np.stack([columns + left - one[0], rows + top - one[1]])
        along = (other - one)[:, None, None]
        share = np.clip((away * along).sum(axis=0) / max((along**2).sum(), 1e-9), 0.0, 1.0)
        box |= np.hypot(*(away - share * along)) < NEAR
    return near


@pytest.mark.slow
def test_pictures_differ_where_the_joint_does_and_nowhere_else(tmp_path):
    fit = ccgen.fit(ccgen.load(SHOULDER))
    joint = as_found(fit)
    bendings = [Bending("end-force", angle, "u").at(joint) for angle in (0.2 * RANGE, RANGE)]
    little, far = simulated_sights(fit, bendings)
    tips = [bending.tip_pose[:3, 3] for bending in bendings]
    readings = far.readings.copy()
    readings[5] = np.nan
    without = replace(far, missing=("v2",), readings=readings)
    with open_page(joint, None) as page, chromium(tmp_path) as tab:
        page.show(little)
        page.settle()
        looked = Looked(page, tab, tmp_path)
        one = looked.settled(tips[0], "little")
        other = looked.show(far, tips[1], "far")
        broken = looked.show(without, tips[1], "without")
        looked.reload()
        again = looked.settled(tips[1], "again")
        drawn = [drawing_of(joint, sight) for sight in (little, far)]
        lines = [looked.at(part) for own in drawn for part in (own.backbone, own.strings)]
        lines.append(looked.at([[tips[0], tips[1]]]))  # the trace
        path = looked.at(string_paths(joint, frames_of(joint, far.estimate))[5])
    # The same scene gives the same picture, by another context of the browser's too.
    assert differing(again, broken).mean() < 1e-4
    # Bent otherwise, the joint is elsewhere, and nothing else is.
    changed, near = (
        differing(one, other),
        about(np.concatenate([np.reshape(x, (-1, 2, 2)) for x in lines]), one.shape[:2]),
    )
    assert changed.sum() > 2000
    assert changed[~near].sum() == 0
    assert near.mean() < 0.25
    # A string without a reading is drawn broken, and nothing else changes.
    changed = differing(other, broken)
    assert changed.sum() > 100
    assert changed[~about(np.stack([path[:-1], path[1:]], axis=1), one.shape[:2])].sum() == 0
    assert runs(other, path) == 1
    assert runs(broken, path) >= 3


def runs(pixels, path):
    """Pieces in which a line is drawn along a path, seen before white."""
    share = np.linspace(0.02, 0.98, 400) * (len(path) - 1)
    places = [np.interp(share, np.arange(len(path)), own) for own in path.T]
    columns, rows = (np.rint(np.array(own) - 0.5).astype(int) for own in places)
    seen = 255 - pixels[rows, columns].min(axis=-1) > 25
    return int(seen[0]) + int((seen[1:] & ~seen[:-1]).sum())
