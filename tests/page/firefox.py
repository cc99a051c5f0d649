"""A Firefox without a window for the tests: opens pages from disk and asks them, over its own protocol, Marionette."""

from __future__ import annotations

import json
import shutil
import socket
import subprocess
import time
from pathlib import Path

import pytest

FIREFOX = next(filter(None, map(shutil.which, ("firefox", "firefox-esr"))), None)
needs_firefox = pytest.mark.skipif(FIREFOX is None, reason="no Firefox is installed to open the page")

#: A port that is free, which it writes into its profile, and no first page or report.
PREFERENCES = {
    "marionette.port": 0,
    "browser.shell.checkDefaultBrowser": False,
    "datareporting.policy.dataSubmissionEnabled": False,
}

#: In s.
PATIENCE = 60


class Firefox:
    """One tab; ends with ``close()``."""

    def __init__(self, profile: Path):
        lines = (f"user_pref({json.dumps(name)}, {json.dumps(value)});" for name, value in PREFERENCES.items())
        (profile / "user.js").write_text("\n".join(lines), encoding="utf-8")
        command = [FIREFOX, "--headless", "--marionette", "--no-remote", "--profile", str(profile), "about:blank"]
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.count, self.kept, self.socket = 0, b"", None
        try:
            self.socket = socket.create_connection(("127.0.0.1", self._port(profile / "MarionetteActivePort")), PATIENCE)
            self._received()
            self.call("WebDriver:NewSession")
        except BaseException:
            self.close()
            raise

    def _port(self, file: Path) -> int:
        until = time.monotonic() + PATIENCE
        while not (file.exists() and file.read_text().strip()):
            assert time.monotonic() < until and self.process.poll() is None, "Firefox does not start"
            time.sleep(0.05)
        return int(file.read_text())

    def close(self) -> None:
        """Ends it."""
        if self.socket is not None:
            self.socket.close()
        self.process.terminate()
        try:
            self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def call(self, command: str, **parameters):
        """The answer to a command: both are JSON with their lengths before them."""
        self.count += 1
        text = json.dumps([0, self.count, command, parameters]).encode()
        self.socket.sendall(b"%d:%s" % (len(text), text))
        _, _, problem, answer = self._received()
        assert problem is None, problem
        return answer

    def _received(self):
        while b":" not in self.kept:
            self._read()
        length, _, self.kept = self.kept.partition(b":")
        while len(self.kept) < int(length):
            self._read()
        text, self.kept = self.kept[: int(length)], self.kept[int(length) :]
        return json.loads(text)

    def _read(self) -> None:
        more = self.socket.recv(1 << 16)
        assert more, "Firefox has ended"
        self.kept += more

    def open(self, page: Path) -> Firefox:
        """Opens a file and waits until it has loaded."""
        self.call("WebDriver:Navigate", url=page.resolve().as_uri())
        return self

    def evaluate(self, expression: str):
        """The value of a JavaScript expression."""
        return self.call("WebDriver:ExecuteScript", script=f"return {expression}", args=[], sandbox=None)["value"]
