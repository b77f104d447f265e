#!/usr/bin/env python3
"""Looks at the live page in a headless Chromium, at desktop and phone width, light and dark:
page_browser.py ADDRESS [FOLDER for pictures].

Says "drawn" when every check holds while the daemon runs, then waits for the page's own alarms and says "stale" and
"lost". Any fault ends it with 1 and its words. It speaks the DevTools protocol over the browser's pipe, so that it can
wait for what a page that never stops loading shows."""
import base64
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

VIEWS = [("desktop", 1280, 900, "light"), ("desktop-dark", 1280, 900, "dark"),
         ("phone", 390, 844, "light"), ("phone-dark", 390, 844, "dark")]
WAIT_S = 30
FAULTS = {"Runtime.exceptionThrown", "Log.entryAdded", "Runtime.consoleAPICalled"}


class Browser:
    """One tab. What the page complains about, refusals by its own policy among it, is in `complaints`."""

    def __init__(self, profile):
        (command, self.to_browser), (self.from_browser, answer) = os.pipe(), os.pipe()

        def as_three_and_four():
            one, two = os.dup(command), os.dup(answer)  # neither source may be overwritten by the first copy
            high = [os.dup2(one, 103), os.dup2(two, 104)]
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        self.process = subprocess.Popen(
            ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--remote-debugging-pipe",
             f"--user-data-dir={profile}", "about:blank"],
            preexec_fn=as_three_and_four, close_fds=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(command)
        os.close(answer)
        self.number, self.rest, self.session, self.complaints = 0, b"", None, []
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Log"):
            self.call(domain + ".enable")

    def message(self):
        while b"\0" not in self.rest:
            part = os.read(self.from_browser, 65536)
            if not part:
                raise SystemExit("the browser ended by itself")
            self.rest += part
        one, self.rest = self.rest.split(b"\0", 1)
        return json.loads(one)

    def call(self, method, **parameters):
        self.number += 1
        request = {"id": self.number, "method": method, "params": parameters}
        if self.session:
            request["sessionId"] = self.session
        os.write(self.to_browser, json.dumps(request).encode() + b"\0")
        while True:
            answer = self.message()
            if answer.get("method") in FAULTS:
                self.complaints.append(json.dumps(answer["params"])[:500])
            if answer.get("id") == self.number:
                if "error" in answer:
                    raise SystemExit(f"{method}: {answer['error']}")
                return answer["result"]

    def value(self, expression):
        return self.call("Runtime.evaluate", expression=expression, returnByValue=True)["result"].get("value")

    def wait_for(self, expression, what):
        for _ in range(WAIT_S * 10):
            if self.value(expression):
                return
            time.sleep(0.1)
        raise SystemExit(f"not within {WAIT_S} s: {what}; the page shows: {self.value('document.body.innerText')}")

    def picture(self, file):
        height = self.value("document.documentElement.scrollHeight")
        width = self.value("innerWidth")
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True,
                         clip={"x": 0, "y": 0, "width": width, "height": height, "scale": 1})["data"]
        file.write_bytes(base64.b64decode(data))


INKED = """(() => { const c = document.getElementById('%s');
  const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;
  const seen = new Set(); for (let i = 0; i < d.length; i += 4) seen.add(d[i] << 16 | d[i + 1] << 8 | d[i + 2]); return seen.size; })()"""


def look(browser, address, width, height, scheme):
    browser.call("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1,
                 mobile=width < 600)
    browser.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
    browser.call("Page.navigate", url=address)
    browser.wait_for("document.getElementById('sentence')?.textContent.startsWith('The attitude is known')", "an attitude")
    browser.wait_for("document.querySelectorAll('#health .chip').length === 4", "the health of four sensors")
    faults = []
    text = browser.value("document.body.innerText")
    for words in ("Accelerometer", "Gyroscope", "Magnetometer", "Last 30 seconds", "inside the daemon", "directions have rested"):
        if words not in text:
            faults.append(f"no word of '{words}'")
    if not browser.value("/^[−]?\\d+\\.\\d$/.test(document.getElementById('roll').textContent)"):
        faults.append("roll is no number")
    for canvas in ("body", "sphere"):
        if browser.value(INKED % canvas) < 5:
            faults.append(f"nothing is drawn in '{canvas}'")
    if browser.value("document.querySelectorAll('.plot canvas').length") != 3:
        faults.append("there are not three curves")
    if browser.value("document.documentElement.scrollWidth > innerWidth"):
        faults.append("it is wider than the window")
    if browser.value("!document.getElementById('banner').hidden"):
        faults.append("an alarm is shown: " + browser.value("document.getElementById('banner').innerText"))
    if browser.value("performance.getEntriesByType('resource').some((e) => new URL(e.name).origin !== location.origin && !e.name.startsWith('data:'))"):
        faults.append("something was loaded from elsewhere")
    faults += browser.complaints
    if faults:
        raise SystemExit(f"{width} x {height}, {scheme}: " + "; ".join(faults))


def alarm(browser, word):
    browser.wait_for(f"!document.getElementById('banner').hidden && document.getElementById('banner-word').textContent === '{word}'",
                     f"the alarm {word}")


def say(word):
    os.write(1, word.encode() + b"\n")  # in one piece, whatever buffers the interpreter was told to use


def main(address, folder=None):
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        browser = Browser(profile)
        try:
            for name, width, height, scheme in VIEWS:
                look(browser, address, width, height, scheme)
                if folder:
                    time.sleep(2)
                    browser.picture(pathlib.Path(folder) / f"{name}.png")
            say("drawn")
            for word, said in (("STALE", "stale"), ("CONNECTION LOST", "lost")):
                alarm(browser, word)
                if folder:
                    browser.picture(pathlib.Path(folder) / f"{said}.png")
                say(said)
        finally:
            browser.process.terminate()
            browser.process.wait()


if __name__ == "__main__":
    main(*sys.argv[1:3])
