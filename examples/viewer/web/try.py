#!/usr/bin/env python3
"""Tries the viewer's page in a browser without a display.

    cargo xtask web --no-serve
    pip install playwright pillow
    apt-get install chromium                # Debian's has WebGPU on SwiftShader, a software driver
    python3 examples/viewer/web/try.py      # some minutes; screenshots in target/web-tried

Another page, browser or folder for screenshots: try.py [--page FOLDER] [--browser PROGRAM] [--out FOLDER].
Clicks and keys are real ones, sent to the browser. Parts of the panel are found by their words: `umbrage_widgets()` tells where they are.
"""

import argparse
import functools
import http.server
import io
import json
import pathlib
import threading
import time

from PIL import Image, ImageChops, ImageStat
from playwright.sync_api import sync_playwright

ROOT = pathlib.Path(__file__).resolve().parents[3]
# Without the last two, the browser's compositor can't show a WebGPU canvas, and the device is lost with the first frame.
WEBGPU = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan",
          "--use-vulkan=swiftshader", "--use-angle=swiftshader"]
SIZE = {"width": 960, "height": 540}
# Seconds that a server on the same machine may take to show the first frame.
MOST_START = 5
BALL = """
[[light]]
kind = "directional"
direction = [1, -2, 0.5]
[[object]]
shape = "plane"
scale = 4
[[object]]
shape = "sphere"
translate = [0, 1.5, 0]
"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


class Viewer:
    """A page with the viewer in it."""

    def __init__(self, browser, address, out):
        self.page = browser.new_page(viewport=SIZE)
        self.address, self.out = address, out
        self.told = []
        self.page.on("console", lambda message: self.told.append(f"{message.type}: {message.text}"))
        self.page.on("pageerror", lambda error: self.told.append(f"error: {error}"))

    def open(self, query):
        self.page.goto(self.address + query)
        self.wait(lambda r: r["first_frame_ms"] > 0, "the first frame")

    def report(self):
        text = self.page.evaluate("window.umbrage_report ? window.umbrage_report() : 'null'")
        return json.loads(text)

    def wait(self, holds, what, seconds=120):
        end = time.time() + seconds
        while time.time() < end:
            report = self.report()
            if report and holds(report):
                return report
            time.sleep(0.1)
        self.shot("failed")
        raise AssertionError(f"{what} did not come within {seconds} s: {self.report()}; the page says {self.told}, "
                             f"{self.page.inner_text('#status')}")

    def measured(self, seconds=240):
        """Waits until truth is traced, and the sides that are shown are compared with it."""
        def done(report):
            shown = report["sides"] if report["split"] is not None else [report["sides"][report["shown_side"]]]
            return report["truth"] == 1 and all(side["wrong"] is not None for side in shown)
        return self.wait(done, "truth", seconds)

    def shot(self, name):
        """Returns what is seen once it stays the same, and keeps it: a software driver shows frames late."""
        png = None
        for _ in range(20):
            time.sleep(0.7)
            last, png = png, self.page.screenshot()
            if last == png:
                break
        (self.out / f"{name}.png").write_bytes(png)
        return Image.open(io.BytesIO(png)).convert("RGB")

    def widgets(self):
        self.page.evaluate("umbrage_widgets()")
        time.sleep(0.5)
        return json.loads(self.page.evaluate("umbrage_widgets()"))

    def click(self, role, words, nth=0):
        """Clicks on the n-th part with these words."""
        widgets = self.widgets()
        found = [w for w in widgets if w["role"] == role and words in (w["label"], w["value"])]
        assert len(found) > nth, f"no {role} `{words}` among {[(w['role'], w['label'], w['value']) for w in widgets]}"
        left, top, right, bottom = found[nth]["at"]
        self.page.mouse.click((left + right) / 2, (top + bottom) / 2)
        time.sleep(0.3)

    def key(self, name):
        # Keys go to the canvas; the pointer is kept off the panel.
        self.page.mouse.move(SIZE["width"] - 200, SIZE["height"] - 60)
        self.page.keyboard.press(name)
        time.sleep(0.3)


def picture(image):
    """The picture without the panel, the labels above it and the marks in its middle columns."""
    left = 340
    return image.crop((left, 70, SIZE["width"], SIZE["height"]))


def halves(image):
    image = picture(image)
    middle = image.width // 2
    return image.crop((0, 0, middle - 20, image.height)), image.crop((middle + 20, 0, image.width, image.height))


def spread(image):
    return sum(ImageStat.Stat(image).stddev) / 3


def difference(a, b):
    return sum(ImageStat.Stat(ImageChops.difference(a, b)).mean) / 3


def share(image, holds):
    pixels = list(image.get_flattened_data())
    return sum(map(holds, pixels)) / len(pixels)


def is_red_or_blue(pixel):
    r, g, b = pixel
    return (r > 200 and g < 90 and b < 90) or (b > 200 and r < 90)


def without_webgpu(playwright, program, address, out):
    browser = playwright.chromium.launch(executable_path=program, headless=False, args=["--headless=new", "--disable-gpu"])
    page = browser.new_page(viewport=SIZE)
    page.goto(address)
    page.wait_for_selector("#without:not([hidden])", timeout=20_000)
    page.wait_for_function("[...document.images].every(i => i.complete && i.naturalWidth > 0)")
    (out / "without.png").write_bytes(page.screenshot(full_page=True))
    why = page.inner_text("#why")
    browser.close()
    print(f"without WebGPU: {why}")
    assert "graphics device" in why or "WebGPU" in why, why


def started(viewer):
    viewer.open("?scene=cubes&left=hard&right=exact&split=0.5")
    report = viewer.report()
    seconds = report["first_frame_ms"] / 1000
    print(f"start, {report['scene']}: first frame after {seconds:.2f} s")
    assert seconds < MOST_START, "it started late"
    assert viewer.page.locator("#status").is_hidden(), "the line was not taken away"
    image = viewer.shot("cubes")
    for name, half in zip(["left", "right"], halves(image)):
        assert spread(half) > 10, f"the {name} half is blank"
    assert spread(image.crop((0, 0, 300, SIZE["height"]))) > 5, "the panel is blank"
    return image


def measured(viewer):
    report = viewer.measured()
    hard, exact = report["sides"]
    print(f"{report['size']} pixels: {hard['label']} {hard['wrong']} of {hard['pixels']} wrong, "
          f"{exact['label']} {exact['wrong']} wrong")
    assert exact["technique"] == "exact" and exact["pixels"] > 10_000, exact
    assert exact["wrong"] == 0 and exact["rmse"] == 0, exact
    assert hard["wrong"] > 0, hard


def agreed(viewer):
    """Compares the masks of the browser's device with those that the CPU half makes there."""
    told = json.loads(viewer.page.evaluate("umbrage_agreement()"))
    refused = [side["refusals"] for side in viewer.report()["sides"]]
    for side, refusals in zip(told["sides"], refused):
        if refusals:
            print(f"against the CPU: {side['technique']}: {refusals}")
            continue
        print(f"against the CPU: {side['technique']}: {side['differing']} of {side['pixels']} pixels differ, {side['undecided']} "
              f"undecided, {side['decided_off']} decided are off")
        assert side.get("decided_off") == 0, side


def heat_map(viewer):
    plain = viewer.shot("plain")
    viewer.key("h")
    viewer.wait(lambda r: r["picture"] == "Error", "the picture of errors")
    image = viewer.shot("errors")
    wrong, right = [share(half, is_red_or_blue) for half in halves(image)]
    before = share(halves(plain)[0], is_red_or_blue)
    print(f"errors laid over: {100 * wrong:.2f} % of the left half, {100 * right:.2f} % of the right one")
    assert wrong > before + 0.0005 and right <= share(halves(plain)[1], is_red_or_blue) + 1e-4
    viewer.key("h")
    viewer.wait(lambda r: r["picture"] == "Nothing", "no picture of errors")


def masks(viewer):
    """What the device says of each pixel, and what rays say, look the same."""
    viewer.open("?scene=cubes&left=hard&right=exact&split=right&over=truth")
    viewer.measured()
    truth = picture(viewer.shot("truth"))
    viewer.open("?scene=cubes&left=hard&right=exact&split=right&over=mask")
    viewer.measured()
    exact = picture(viewer.shot("mask-exact"))
    viewer.key("f")
    viewer.wait(lambda r: r["shown_side"] == 0, "the other side")
    viewer.measured()
    hard = picture(viewer.shot("mask-hard"))
    print(f"masks against truth, mean step of 256: exact {difference(truth, exact):.3f}, hard {difference(truth, hard):.3f}")
    assert difference(truth, exact) < 0.02 < difference(truth, hard) < 5
    lit, dark = share(truth, lambda p: min(p) > 250), share(truth, lambda p: max(p) < 5)
    assert lit > 0.1 and dark > 0.02, (lit, dark)


def switched(viewer):
    viewer.open("?scene=cubes&left=hard&right=exact&split=0.5")
    viewer.measured()
    before = viewer.shot("before-switch")
    viewer.click("ComboBox", "hard")
    viewer.shot("techniques")
    viewer.click("Button", "traced")
    viewer.wait(lambda r: r["sides"][0]["technique"] == "traced", "the other technique")
    report = viewer.measured()
    after = viewer.shot("switched")
    changed = [difference(a, b) for a, b in zip(halves(before), halves(after))]
    print(f"switched by clicks to {report['sides'][0]['label']}: {report['sides'][0]['wrong']} wrong; "
          f"the left half changed by {changed[0]:.3f}, the right one by {changed[1]:.3f}")
    assert report["sides"][0]["wrong"] == 0, report
    assert changed[0] > 0.01 and changed[1] < 1e-3, changed
    viewer.key("x")
    report = viewer.wait(lambda r: r["split"] is None, "one side")
    viewer.key("f")
    viewer.wait(lambda r: r["shown_side"] != report["shown_side"], "the other side")
    viewer.measured()
    viewer.shot("one-side")


def dropped(viewer):
    drop = """text => {
        const data = new DataTransfer();
        data.items.add(new File([text], "ball.toml"));
        const at = { clientX: 600, clientY: 300, dataTransfer: data, bubbles: true, cancelable: true };
        for (const kind of ["dragenter", "dragover", "drop"])
            document.getElementById("umbrage").dispatchEvent(new DragEvent(kind, at));
    }"""
    viewer.page.evaluate(drop, BALL)
    viewer.wait(lambda r: r["scene"] == "ball", "the dropped scene")
    viewer.shot("dropped")
    viewer.page.evaluate(drop, "[[light]]\nkind = 'dark'")
    report = viewer.wait(lambda r: r["message"], "a message")
    print(f"a broken scene is refused: {report['message']}")
    assert "ball.toml" in report["message"], report


def others(viewer):
    """Other techniques and lights on this device, against the CPU."""
    for left, right in [("pcf", "pcss"), ("pcf_disc", "pcf_merged"), ("midpoint", "second_depth"), ("pcf_hardware", "soft"),
                        ("pcf_dithered", "planar")]:
        viewer.open(f"?scene=cubes&left={left}&right={right}")
        report = viewer.measured()
        assert report["message"] is None, report
        agreed(viewer)
    viewer.open("?nonsense=1&scene=cubess")
    message = viewer.report()["message"]
    print(f"an address with mistakes: {message}")
    assert "cubess" in message and "nonsense" in message, message


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--page", default=ROOT / "target/web", type=pathlib.Path)
    parser.add_argument("--browser", default="/usr/bin/chromium")
    parser.add_argument("--out", default=ROOT / "target/web-tried", type=pathlib.Path)
    options = parser.parse_args()
    assert (options.page / "index.html").is_file(), f"there is no page in {options.page}: run `cargo xtask web --no-serve`"
    options.out.mkdir(parents=True, exist_ok=True)
    handler = functools.partial(Quiet, directory=options.page)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://localhost:{server.server_address[1]}/"
    with sync_playwright() as playwright:
        without_webgpu(playwright, options.browser, address, options.out)
        browser = playwright.chromium.launch(
            executable_path=options.browser, headless=False, args=["--headless=new", *WEBGPU])
        viewer = Viewer(browser, address, options.out)
        started(viewer)
        measured(viewer)
        agreed(viewer)
        heat_map(viewer)
        masks(viewer)
        switched(viewer)
        dropped(viewer)
        others(viewer)
        faults = [line for line in viewer.told if line.startswith("error")]
        assert not faults, faults
        browser.close()
    print(f"all well; screenshots are in {options.out}")


if __name__ == "__main__":
    main()
