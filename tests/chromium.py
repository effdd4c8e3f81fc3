"""A headless Chromium that is driven over the DevTools protocol, with WebGL in software."""

import base64
import json
import shutil
import subprocess
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

from websockets.sync.client import connect

_FLAGS = (
    *("--headless", "--no-sandbox", "--disable-dev-shm-usage", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
    *("--remote-debugging-port=0", "--remote-allow-origins=*"),
)
_PATIENCE = 60.0
"""Seconds until the browser must have started, or answered."""


class Tab:
    """A page of the browser.

    Attributes:
        said: texts of its console that tell of an error, and exceptions.
        asked: addresses that were asked for over the network.
    """

    def __init__(self, socket):
        self._socket, self._number = socket, 0
        self.said, self.asked = [], []

    def command(self, method, **params):
        self._number += 1
        self._socket.send(json.dumps({"id": self._number, "method": method, "params": params}))
        while True:
            answer = json.loads(self._socket.recv(timeout=_PATIENCE))
            if answer.get("id") == self._number:
                return answer["result"]
            self._note(answer)

    def _note(self, event):
        params = event.get("params", {})
        match event["method"]:
            case "Runtime.consoleAPICalled" if params["type"] in ("error", "assert"):
                self.said.append(json.dumps(params["args"]))
            case "Runtime.exceptionThrown":
                self.said.append(json.dumps(params["exceptionDetails"]))
            case "Log.entryAdded" if params["entry"]["level"] == "error":
                self.said.append(json.dumps(params["entry"]))
            case "Network.requestWillBeSent":
                self.asked.append(params["request"]["url"])

    def open(self, url, width, height=900):
        self.command("Emulation.setDeviceMetricsOverride", width=width, height=height,
                     deviceScaleFactor=1, mobile=False)  # fmt: skip
        self.command("Page.navigate", url=url)

    def evaluate(self, script):
        return self.command("Runtime.evaluate", expression=script, returnByValue=True)["result"][
            "value"
        ]

    def picture(self):
        """What is seen, as a PNG."""
        return base64.b64decode(self.command("Page.captureScreenshot", format="png")["data"])


@contextmanager
def chromium(folder: Path):
    """A tab of a browser whose profile is in a folder."""
    profile = folder / "profile"
    process = subprocess.Popen(
        [
            shutil.which("chromium") or "chromium",
            *_FLAGS,
            f"--user-data-dir={profile}",
            "about:blank",
        ],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    try:
        with connect(_address(profile), max_size=None) as socket:
            tab = Tab(socket)
            for domain in ("Runtime", "Log", "Network", "Page"):
                tab.command(f"{domain}.enable")
            yield tab
    finally:
        process.terminate()
        process.wait(20)


def _address(profile):
    """Where its first tab is driven."""
    told, end = profile / "DevToolsActivePort", time.monotonic() + _PATIENCE
    while time.monotonic() < end:
        if told.exists() and told.read_text().count("\n"):
            port = told.read_text().split("\n")[0]
            with urllib.request.urlopen(
                f"http://127.0.0.1:{port}/json", timeout=_PATIENCE
            ) as answer:
                tabs = [tab for tab in json.load(answer) if tab["type"] == "page"]
            if tabs:
                return tabs[0]["webSocketDebuggerUrl"]
        time.sleep(0.05)
    raise TimeoutError("chromium did not start")
