"""The page of `--view` in a browser: a bent joint where its pose projects to, and no scrolling."""

import io
import math

import numpy as np
import pytest
from chromium import chromium
from test_view import RANGE, SHOULDER
from waiting import becomes

import ccgen
from ccgen.sensing.bending import Bending
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


def marker(picture):
    """The middle of what has the colour of the tip; None where nothing has."""
    import imageio.v3

    pixels = imageio.v3.imread(io.BytesIO(picture))[..., :3].astype(int)
    rows, columns = np.nonzero((np.abs(pixels - TIP) <= 2).all(axis=-1))
    if len(rows) < 100:
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
            before = set(page._server.get_clients())
            tab.open(page.url, width)
            assert becomes(lambda old=before: set(page._server.get_clients()) - old)
            assert becomes(lambda: tab.evaluate("!!document.querySelector('canvas')"))
            seen = []
            assert becomes(
                lambda found=seen: (
                    tab.evaluate(DISMISS) == 0
                    and (found.append(marker(tab.picture())) or found[-1] is not None)
                )
            )
            scrolled, inner, body, *canvas = tab.evaluate(SIZES)
            assert max(scrolled, body) <= inner == width
            camera = page._server.get_clients()[max(page._server.get_clients())].camera
            expected = projected(camera, simulation.tip_pose[:3, 3], canvas)
            assert np.abs(seen[-1] - expected).max() < 3.0, (seen[-1], expected)
            (tmp_path / f"{width}.png").write_bytes(tab.picture())
        assert tab.said == []
        outside = [url for url in tab.asked if not url.startswith(("data:", "blob:", page.url))]
        assert outside == []
