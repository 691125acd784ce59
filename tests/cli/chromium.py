"""Chromium without a window, by the protocol of its driver. Standard library only."""

import base64
import http.client
import json
import os
import shutil
import socket
import subprocess
import time

THERE = shutil.which("chromedriver") is not None


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


class Chromium:
    """A browser process with one page, with this much less priority than others. Close it with close()."""

    def __init__(self, niceness=0):
        self.port = free_port()
        # For root, Chromium gives the process that draws the priority -8. Without this capability it cannot.
        drop = ["setpriv", "--bounding-set=-sys_nice"] if os.geteuid() == 0 else []
        self.driver = subprocess.Popen([*drop, "chromedriver", f"--port={self.port}"], stdout=subprocess.DEVNULL,
                                       stderr=subprocess.DEVNULL)
        if niceness:
            os.setpriority(os.PRIO_PROCESS, self.driver.pid, niceness)  # before it makes the browser's processes
        self.session = None
        try:
            for _ in range(200):
                try:
                    self._call("GET", "/status")
                    break
                except OSError:
                    time.sleep(0.05)
            options = {"args": ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1280,1000",
                                "--enable-unsafe-swiftshader", "--disable-background-networking"]}
            wanted = {"goog:chromeOptions": options,
                      "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL"}}
            self.session = self._call("POST", "/session", {"capabilities": {"alwaysMatch": wanted}})["sessionId"]
        except BaseException:
            self.close()
            raise

    def close(self):
        if self.session:
            self.call("DELETE", "")
            self.session = None
        self.driver.terminate()
        self.driver.wait()

    def _call(self, method, path, body=None):
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=300)
        connection.request(method, path, json.dumps(body) if body is not None else None,
                           {"Content-Type": "application/json"})
        value = json.loads(connection.getresponse().read())["value"]
        connection.close()
        assert not (isinstance(value, dict) and "error" in value), value
        return value

    def call(self, method, path, body=None):
        """A request to the session."""
        return self._call(method, f"/session/{self.session}{path}", body)

    def open(self, url):
        self.call("POST", "/url", {"url": url})

    def script(self, text):
        """What the script in the page returns."""
        return self.call("POST", "/execute/sync", {"script": text, "args": []})

    def command(self, name, parameters):
        """A command of the developer tools."""
        return self.call("POST", "/goog/cdp/execute", {"cmd": name, "params": parameters})

    def log(self, kind):
        return self.call("POST", "/se/log", {"type": kind})

    def wait_for(self, text, what):
        """Until the script in the page returns something that is true."""
        for _ in range(400):
            if self.script(text):
                return
            time.sleep(0.05)
        raise AssertionError(what)

    def picture(self, file):
        data = self.command("Page.captureScreenshot", {"captureBeyondViewport": True})["data"]
        file.write_bytes(base64.b64decode(data))

    def show_as(self, scheme, width):
        """In light or dark, on a screen of this width."""
        self.command("Emulation.setEmulatedMedia", {"features": [{"name": "prefers-color-scheme", "value": scheme}]})
        self.command("Emulation.setDeviceMetricsOverride", {"width": width, "height": 1000, "deviceScaleFactor": 1,
                                                            "mobile": width < 600})

    def rows(self, table):
        """The cells of a table as texts."""
        return self.script(f"return [...document.querySelectorAll('#{table} tbody tr')]"
                           ".map(r => [...r.cells].map(c => c.textContent))")

    def figures(self):
        return self.script("return Object.fromEntries([...document.querySelectorAll('#figures dd')]"
                           ".map(d => [d.dataset.key, d.textContent]))")

    def errors(self):
        """What the page logged as an error, but for the time without a server."""
        return [entry for entry in self.log("browser")
                if entry["level"] == "SEVERE" and "ERR_CONNECTION_REFUSED" not in entry["message"]
                and "ERR_INCOMPLETE_CHUNKED_ENCODING" not in entry["message"]]

    def asked(self):
        """All addresses that the browser asked for."""
        return [event["params"]["request"]["url"] for entry in self.log("performance")
                for event in [json.loads(entry["message"])["message"]]
                if event["method"] == "Network.requestWillBeSent"]
