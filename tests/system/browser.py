# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium, steered over the pipe of its own protocol; the standard library only."""
import base64
import json
import os
import select
import shutil
import struct
import subprocess
import tempfile
import time
import zlib

PROGRAMS = ("chromium", "chromium-headless-shell", "chromium-browser", "google-chrome")


def program():
    """The browser of this machine, or None."""
    return next(filter(None, map(shutil.which, PROGRAMS)), None)


class Browser:
    def __init__(self, width, height, phone=False):
        self.folder = tempfile.mkdtemp(prefix="geond_browser_")
        to_read, to_write = os.pipe()
        from_read, from_write = os.pipe()

        def connect():  # the browser reads descriptor 3 and writes 4
            a, b = os.dup(to_read), os.dup(from_write)
            os.dup2(a, 3)
            os.dup2(b, 4)
            os.set_inheritable(3, True)
            os.set_inheritable(4, True)

        self.process = subprocess.Popen(
            [program(), "--headless=new", "--remote-debugging-pipe", "--no-sandbox", "--no-first-run", "--disable-gpu-sandbox",
             "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", "--hide-scrollbars",
             "--user-data-dir=" + self.folder, "about:blank"],
            preexec_fn=connect, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(to_read)
        os.close(from_write)
        self.to, self.come, self.received, self.number, self.log = to_write, from_read, b"", 0, []
        target = self.ask("Target.createTarget", url="about:blank")["targetId"]
        self.session = None
        self.session = self.ask("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.ask(domain + ".enable")
        self.ask("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=2 if phone else 1, mobile=phone)
        if phone:
            self.ask("Emulation.setTouchEmulationEnabled", enabled=True)

    def close(self):
        if self.process.poll() is not None:
            return
        self.process.terminate()
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        os.close(self.to)
        os.close(self.come)
        shutil.rmtree(self.folder, ignore_errors=True)

    def _message(self, seconds):
        end = time.monotonic() + seconds
        while b"\0" not in self.received:
            if not select.select([self.come], [], [], max(0, end - time.monotonic()))[0]:
                raise TimeoutError("the browser does not answer")
            got = os.read(self.come, 1 << 16)
            if not got:
                raise EOFError("the browser has ended")
            self.received += got
        line, self.received = self.received.split(b"\0", 1)
        return json.loads(line)

    def ask(self, method, **params):
        self.number += 1
        request = {"id": self.number, "method": method, "params": params}
        if getattr(self, "session", None):
            request["sessionId"] = self.session
        os.write(self.to, json.dumps(request).encode() + b"\0")
        while True:
            message = self._message(60)
            if message.get("method") in ("Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled"):
                self.log.append(json.dumps(message["params"])[:500])
            if message.get("id") == self.number:
                if "error" in message:
                    raise RuntimeError(f"{method}: {message['error']}")
                return message["result"]

    def open(self, url):
        self.ask("Page.navigate", url=url)

    def js(self, expression):
        """The value of a JavaScript expression, or of the promise that it is."""
        result = self.ask("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        if "exceptionDetails" in result:
            raise RuntimeError(json.dumps(result["exceptionDetails"])[:800])
        return result["result"].get("value")

    def wait(self, expression, seconds=120):
        end = time.monotonic() + seconds
        while True:
            try:
                value = self.js(expression)
            except RuntimeError:
                value = None  # between two pages
            if value:
                return value
            if time.monotonic() > end:
                raise TimeoutError(f"never true: {expression}; the page says {self.log[-5:]}")
            time.sleep(0.05)

    def click(self, x, y):
        for kind in ("mousePressed", "mouseReleased"):
            self.ask("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)

    def click_on(self, selector):
        place = self.js(f"(() => {{ const e = document.querySelector('{selector}'); e.scrollIntoView({{block: 'nearest'}});"
                        "const b = e.getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()")
        self.click(*place)

    def screenshot(self, path=None):
        png = base64.b64decode(self.ask("Page.captureScreenshot", format="png")["data"])
        if path:
            with open(path, "wb") as file:
                file.write(png)
        return Picture(png)


class Picture:
    """The pixels of a PNG of 8 bits a colour, without interlace."""

    def __init__(self, png):
        at, packed = 8, b""
        while at < len(png):
            size, kind = struct.unpack(">I4s", png[at:at + 8])
            data = png[at + 8:at + 8 + size]
            if kind == b"IHDR":
                self.width, self.height, depth, color = struct.unpack(">IIBB", data[:10])
                self.channels = {2: 3, 6: 4}[color]
                assert depth == 8
            elif kind == b"IDAT":
                packed += data
            at += 12 + size
        raw, step, rows, before = zlib.decompress(packed), self.width * self.channels, [], None
        for y in range(self.height):
            kind, row = raw[y * (step + 1)], bytearray(raw[y * (step + 1) + 1:(y + 1) * (step + 1)])
            for i in range(step if kind else 0):
                left = row[i - self.channels] if i >= self.channels else 0
                up = before[i] if before else 0
                corner = before[i - self.channels] if before and i >= self.channels else 0
                if kind == 1:
                    guess = left
                elif kind == 2:
                    guess = up
                elif kind == 3:
                    guess = (left + up) // 2
                else:
                    p = left + up - corner
                    guess = min((abs(p - left), 0, left), (abs(p - up), 1, up), (abs(p - corner), 2, corner))[2]
                row[i] = (row[i] + guess) & 255
            rows.append(row)
            before = row
        self.rows = rows

    def where(self, like):
        """Share of the pixels for which like(r, g, b) holds, and their mean place (x, y from 0 to 1)."""
        n = sum_x = sum_y = 0
        for y in range(0, self.height, 2):
            row = self.rows[y]
            for x in range(0, self.width, 2):
                i = x * self.channels
                if like(row[i], row[i + 1], row[i + 2]):
                    n, sum_x, sum_y = n + 1, sum_x + x, sum_y + y
        total = ((self.height + 1) // 2) * ((self.width + 1) // 2)
        return n / total, (sum_x / max(n, 1) / self.width, sum_y / max(n, 1) / self.height)
