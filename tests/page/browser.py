"""A Chromium without a window for the tests: opens pages from disk and talks to them over the DevTools protocol."""

from __future__ import annotations

import asyncio
import base64
import json
import shutil
import subprocess
import tempfile
import time
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome", "chrome"))), None)
needs_chromium = pytest.mark.skipif(CHROMIUM is None, reason="no Chromium or Chrome is installed to open the page")

FLAGS = (
    "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --use-gl=angle --use-angle=swiftshader --enable-unsafe-swiftshader "
    "--remote-debugging-port=0 --remote-allow-origins=* --window-size=800,600"
).split()

#: What the software renderer says when a picture is taken; nothing of the page's.
HARMLESS = "GPU stall due to ReadPixels"


#: Codes of keys that do something by themselves.
KEYS = {" ": 32, "ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Home": 36, "End": 35, "Escape": 27, "Tab": 9}


#: In s; a page that draws with the software renderer on a busy machine takes its time.
PATIENCE = 60


class BrowserEnded(Exception):
    """The browser, or its tab, is no more, or says nothing; the next page is opened in a new one."""


class Browser:
    """One browser with one tab; a new one where the last has ended.

    Attributes:
        messages: what the page has written to the console or thrown since it was opened.
        requests: addresses that it has asked for since then.
        dialogs: texts of dialogs that it has opened.
    """

    def __init__(self, folder: Path):
        self.folder = folder
        self.messages, self.requests, self.dialogs = [], [], []
        self._start()

    def _start(self) -> None:
        self.folder.mkdir(exist_ok=True)
        profile = Path(tempfile.mkdtemp(dir=self.folder))
        self.count, self.loaded, self.ended = 0, False, False
        self.words = profile / "words.txt"
        with self.words.open("wb") as words:
            command = [CHROMIUM, *FLAGS, f"--user-data-dir={profile}", "about:blank"]
            self.process = subprocess.Popen(command, stdout=words, stderr=words)
        self.loop = asyncio.new_event_loop()
        try:
            self.socket = self.loop.run_until_complete(self._connect(profile / "DevToolsActivePort"))
            self.connected = True
            for domain in ("Page", "Runtime", "Log", "Network", "Inspector"):
                self.call(f"{domain}.enable")
        except BaseException:
            self._end()
            raise

    def _gone(self, what: str) -> BrowserEnded:
        self.ended = True
        return BrowserEnded(f"{what}; its last words: {self.words.read_text(errors='replace')[-1000:]}")

    async def _connect(self, port_file: Path):
        from tornado.websocket import websocket_connect

        until = time.monotonic() + PATIENCE
        while not (port_file.exists() and port_file.read_text().count("\n")):
            if self.process.poll() is not None or time.monotonic() > until:
                raise self._gone("the browser did not start")
            await asyncio.sleep(0.05)
        port = port_file.read_text().split()[0]
        with urllib.request.urlopen(f"http://127.0.0.1:{port}/json/list") as answer:
            tab = next(tab for tab in json.load(answer) if tab["type"] == "page")
        return await websocket_connect(tab["webSocketDebuggerUrl"], max_message_size=2**26)

    def close(self) -> None:
        """Ends the browser, whatever state it is in."""
        try:
            self.loop.run_until_complete(self._hang_up())
        finally:
            self._end()

    async def _hang_up(self) -> None:
        self.socket.close()  # which waits some seconds for an answer, and then does without
        while self.connected:
            self.connected = await self.socket.read_message() is not None

    def _end(self) -> None:
        self.loop.close()
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def call(self, method: str, **parameters):
        """The result of a command; events that arrive meanwhile are kept."""
        self.count += 1
        self.loop.run_until_complete(self._send({"id": self.count, "method": method, "params": parameters}))
        while True:
            message = self._receive()
            if message.get("id") == self.count:
                assert "error" not in message, message
                return message["result"]

    async def _send(self, message: dict) -> None:
        from tornado.websocket import WebSocketClosedError

        try:
            await self.socket.write_message(json.dumps(message))
        except WebSocketClosedError:
            raise self._gone("the browser has ended") from None

    async def _read(self) -> str | None:
        return await asyncio.wait_for(self.socket.read_message(), PATIENCE)

    def _receive(self) -> dict:
        try:
            text = self.loop.run_until_complete(self._read())
        except TimeoutError:
            raise self._gone(f"the browser has said nothing for {PATIENCE} s") from None
        self.connected = text is not None
        if not self.connected:
            raise self._gone("the browser has ended")
        message = json.loads(text)
        if message.get("method") == "Inspector.targetCrashed":
            raise self._gone("the tab has crashed")
        self._keep(message.get("method"), message.get("params", {}))
        return message

    def _keep(self, event: str | None, told: dict) -> None:
        if event == "Network.requestWillBeSent":
            self.requests.append(told["request"]["url"])
        elif event == "Runtime.consoleAPICalled":
            self.messages.append(str([argument.get("value") for argument in told["args"]]))
        elif event == "Runtime.exceptionThrown":
            self.messages.append(str(told["exceptionDetails"]))
        elif event == "Log.entryAdded" and HARMLESS not in told["entry"]["text"]:
            self.messages.append(told["entry"]["text"])
        elif event == "Page.javascriptDialogOpening":
            self.dialogs.append(told["message"])
        elif event == "Page.loadEventFired":
            self.loaded = True

    def open(self, path: Path, fragment: str = "") -> Browser:
        """Opens a file in a fresh document and waits until it has loaded."""
        if self.ended:
            self.close()
            self._start()
        self._go("about:blank")
        self.messages, self.requests, self.dialogs = [], [], []
        self._go(path.resolve().as_uri() + fragment)
        return self

    def reset(self) -> Browser:
        """Forgets the window, the settings and what pages have stored."""
        if not self.ended:
            self.call("Emulation.clearDeviceMetricsOverride")
            self.call("Emulation.setEmulatedMedia", media="", features=[])
            self.call("Storage.clearDataForOrigin", origin="file://", storageTypes="local_storage")
        return self

    def _go(self, address: str) -> None:
        self.loaded = False
        self.call("Page.navigate", url=address)
        while not self.loaded:
            self._receive()

    @contextmanager
    def beginning_with(self, script: str):
        """Documents that are opened meanwhile run a script before their own."""
        added = self.call("Page.addScriptToEvaluateOnNewDocument", source=script)
        yield
        self.call("Page.removeScriptToEvaluateOnNewDocument", **added)

    def evaluate(self, expression: str):
        """The value of a JavaScript expression, after promises."""
        answer = self.call("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer
        return answer["result"].get("value")

    def state(self) -> dict:
        """What the page says in its body's data-state."""
        return json.loads(self.evaluate("document.body.dataset.state"))

    def wait(self, seconds: float) -> None:
        """Lets the page run: for what must not happen; ``until`` waits for what must."""
        self.evaluate(f"new Promise(resolve => setTimeout(resolve, {1000 * seconds}))")

    def until(self, expression: str) -> None:
        """Lets the page run until a JavaScript expression, which may speak of its ``state``, is true, however slow the machine."""
        came = self.evaluate(f"""new Promise(resolve => {{
            const end = performance.now() + {500 * PATIENCE};
            const look = () => {{
                const state = JSON.parse(document.body.dataset.state || "null");
                if ({expression}) resolve(true);
                else if (performance.now() > end) resolve(false);
                else setTimeout(look, 5);
            }};
            look();
        }})""")
        assert came, f"it never came about that {expression}"

    def click(self, selector: str) -> None:
        """A press of the mouse on the middle of an element."""
        self.press_at(*self.place(selector, 0.5))

    def press_at(self, x: float, y: float, count: int = 1) -> None:
        """A press of the mouse, the second of a double click where the count is 2."""
        for kind in ("mousePressed", "mouseReleased"):
            self.mouse(kind, x, y, button="left", clickCount=count)

    def mouse(self, kind: str, x: float, y: float, **more) -> None:
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **more)

    def box(self, selector: str, number: int = 0) -> list[float]:
        """Left, top, width and height of an element, after it was brought into the window."""
        return self.evaluate(f"""(() => {{
            const element = document.querySelectorAll({json.dumps(selector)})[{number}];
            element.scrollIntoView({{block: "center"}});
            const box = element.getBoundingClientRect();
            return [box.x, box.y, box.width, box.height];
        }})()""")

    def press(self, key: str) -> None:
        """A key, by the name that its event has."""
        written = {"text": key} if len(key) == 1 else {}
        named = {"code": "Space" if key == " " else key, "windowsVirtualKeyCode": KEYS.get(key, 0), **written}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **named)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, **named)

    def point(self, selector: str, across: float, kind: str = "mouseMoved", **more) -> None:
        """The mouse at a part of the width of an element, at half its height."""
        self.mouse(kind, *self.place(selector, across), **more)

    def place(self, selector: str, across: float, up: float = 0.5, number: int = 0) -> tuple[float, float]:
        """A point of an element at shares of its width and height, in the window."""
        x, y, width, height = self.box(selector, number)
        return x + across * width, y + (1 - up) * height

    def prefers(self, **features: str) -> None:
        """What the system is set to, such as color_scheme="dark"."""
        features = [{"name": f"prefers-{name.replace('_', '-')}", "value": value} for name, value in features.items()]
        self.call("Emulation.setEmulatedMedia", features=features)

    def size(self, width: int, height: int, *, mobile: bool = False) -> None:
        """The window's."""
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=mobile)

    def picture(self, selector: str) -> bytes:
        """An element as a PNG."""
        left, top, width, height = self.box(selector)
        across, down = self.evaluate("[scrollX, scrollY]")
        clip = {"x": left + across, "y": top + down, "width": width, "height": height, "scale": 1}
        return base64.b64decode(self.call("Page.captureScreenshot", format="png", clip=clip)["data"])
