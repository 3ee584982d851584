#!/usr/bin/env python3
"""Tries the viewer's window as a user would, without a display: real keys, a real mouse, and what came of it.

    apt-get install xvfb xdotool imagemagick libxkbcommon-x11-0 libxcursor1 libxi6 mesa-vulkan-drivers
    pip install pillow
    python3 examples/viewer/try.py          # some minutes; screenshots in target/viewer-tried

Another program or folder for screenshots: try.py [--viewer PROGRAM] [--out FOLDER]. Without --viewer it is built first.
The program keeps what it shows and measures in a file (`--report`), with the places of the panel's parts: they are found by their words.
"""

import argparse
import json
import os
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile
import time

from PIL import Image, ImageChops, ImageStat

ROOT = pathlib.Path(__file__).resolve().parents[2]
WIDTH, HEIGHT = 1280, 720
# Where the panel ends.
PANEL = 350


class Window:
    """The viewer's window on a display of its own."""

    def __init__(self, program, out, arguments, folder=None):
        self.out = out
        # Another window in the same folder finds what the last one kept.
        self.folder = folder or pathlib.Path(tempfile.mkdtemp())
        self.file = self.folder / "told.json"
        self.file.unlink(missing_ok=True)
        # Settings of the last time are kept in here.
        environment = dict(os.environ, WINIT_X11_SCALE_FACTOR="1", XDG_DATA_HOME=str(self.folder))
        environment.pop("WAYLAND_DISPLAY", None)
        self.log = open(self.folder / "log", "w+")
        self.program = subprocess.Popen(
            [program, *arguments, "--size", f"{WIDTH}x{HEIGHT}", "--report", self.file],
            env=environment, stdout=self.log, stderr=self.log, cwd=self.folder)
        self.wait(lambda r: True, "the first frame")
        self.window = self.do("search", "--sync", "--onlyvisible", "--name", "^umbrage$").split()[0]
        self.do("windowmove", self.window, 0, 0, "windowfocus", self.window)
        time.sleep(1)

    def do(self, *arguments):
        return subprocess.run(["xdotool", *map(str, arguments)], check=True, capture_output=True, text=True).stdout

    def told(self):
        if self.program.poll() is not None:
            self.log.seek(0)
            raise AssertionError(f"the program ended with {self.program.returncode}: {self.log.read()}")
        return json.loads(self.file.read_text()) if self.file.exists() else None

    def report(self):
        return self.told()["report"]

    def wait(self, holds, what, seconds=120, part="report"):
        end = time.time() + seconds
        while time.time() < end:
            told = self.told()
            if told and told[part] is not None and holds(told[part]):
                return told[part]
            time.sleep(0.1)
        raise AssertionError(f"{what} did not come within {seconds} s: {self.told()}")

    def measured(self, seconds=300):
        """Waits until truth is traced, both sides are compared with it, and masks with the CPU's."""
        time.sleep(1)
        self.wait(lambda a: True, "the masks' comparison", seconds, "agreement")
        return self.report()

    def shot(self, name):
        file = self.out / f"{name}.png"
        subprocess.run(["import", "-window", self.window, file], check=True)
        return Image.open(file).convert("RGB")

    def move(self, x, y):
        self.do("mousemove", "--window", self.window, x, y)
        time.sleep(0.4)

    def click(self, words, nth=0, role=None):
        """Clicks on the n-th part of the panel with these words."""
        for _ in range(20):
            left, top, right, bottom = self.place(words, nth, role)
            if top >= 0 and bottom <= HEIGHT - 10:
                break
            # The panel is scrolled until the part shows.
            self.move(20, HEIGHT / 2)
            self.do("click", 5 if bottom > HEIGHT - 10 else 4)
            # It glides for a while.
            time.sleep(1.5)
        self.move((left + right) / 2, (top + bottom) / 2)
        self.do("click", 1)
        time.sleep(0.6)

    def place(self, words, nth=0, role=None):
        time.sleep(0.6)
        parts = self.told()["widgets"]
        found = [p["at"] for p in parts if words in (p["label"], p["value"]) and role in (None, p["role"])]
        assert len(found) > nth, f"no part `{words}` among {[(p['role'], p['label'], p['value']) for p in parts]}"
        return found[nth]

    def key(self, name):
        self.move(WIDTH - 200, HEIGHT - 60)
        self.do("key", name)
        time.sleep(0.5)

    def drag(self, button, begin, steps):
        self.move(*begin)
        self.do("mousedown", button)
        time.sleep(0.5)
        for dx, dy in steps:
            self.do("mousemove_relative", "--", dx, dy)
            time.sleep(0.2)
        self.do("mouseup", button)
        time.sleep(0.5)

    def close(self):
        self.program.terminate()
        self.program.wait()


def picture(image):
    """The picture without the panel and the labels above it."""
    return image.crop((PANEL, 70, WIDTH, HEIGHT))


def halves(image):
    image = picture(image)
    middle = image.width // 2
    return image.crop((0, 0, middle - 20, image.height)), image.crop((middle + 20, 0, image.width, image.height))


def difference(a, b):
    return sum(ImageStat.Stat(ImageChops.difference(a, b)).mean) / 3


def spread(image):
    return sum(ImageStat.Stat(image).stddev) / 3


def agreed(window):
    for side in window.told()["agreement"]["sides"]:
        print(f"  against the CPU: {side}")
        assert side.get("decided_off") == 0, side


def messages(program):
    """What goes wrong before there is a window is told in plain words."""
    for what, arguments, code, word, environment in [
        ("a broken size", ["--size", "12"], 2, "write it as 1280x720", {}),
        ("an unknown technique", ["--left", "nothing"], 2, "possible values", {}),
        ("an unknown scene", ["cubess"], 1, "cubes", {}),
        ("a file that isn't there", ["/none/a.obj"], 1, "/none/a.obj", {}),
        ("no display", [], 1, "display", {"DISPLAY": ""}),
        ("no adapter", [], 1, "driver", {"VK_DRIVER_FILES": "/none", "VK_ICD_FILENAMES": "/none"}),
        ("the help", ["--help"], 0, "Examples:", {}),
        ("the list", ["--list"], 0, "street", {}),
    ]:
        all_of_it = {**os.environ, **environment}
        done = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=60, env=all_of_it)
        said = done.stdout + done.stderr
        assert done.returncode == code and word in said and "panicked" not in said, (what, done.returncode, said)
        print(f"told in words: {what}")


def measured(window):
    report = window.measured()
    hard, exact = report["sides"]
    print(f"{report['size']} pixels: {hard['label']} {hard['wrong']} of {hard['pixels']} wrong, {exact['label']} {exact['wrong']}")
    assert exact["technique"] == "exact" and exact["pixels"] > 100_000, exact
    assert exact["rmse"] < 0.005 < hard["rmse"], report
    agreed(window)
    image = window.shot("start")
    for half in halves(image):
        assert spread(half) > 10, "a half is blank"
    return image


def looked_around(window, before):
    window.drag(3, (800, 400), [(20, 4)] * 5)
    window.measured()
    turned = window.shot("turned")
    assert difference(picture(before), picture(turned)) > 3, "the right button doesn't look around"
    window.move(700, 300)
    window.move(900, 500)
    assert difference(picture(turned), picture(window.shot("moved"))) < 0.5, "the mouse alone turns the view"
    window.drag(3, (800, 400), [(-20, -4)] * 5)
    last = window.shot("back")
    for key in ["w", "s", "a", "d", "e", "q"]:
        window.move(900, 600)
        window.do("keydown", key)
        time.sleep(0.6)
        window.do("keyup", key)
        time.sleep(1)
        now = window.shot(f"key-{key}")
        assert difference(picture(last), picture(now)) > 0.5, f"{key} doesn't fly"
        last = now
    window.move(900, 600)
    window.do("click", 4, "click", 4)
    time.sleep(2)
    assert difference(picture(last), picture(window.shot("wheel"))) > 0.5, "the wheel doesn't move"
    window.key("Home")
    window.measured()
    assert difference(picture(before), picture(window.shot("home"))) < 0.5, "Home doesn't go back"
    print("the right button looks, W A S D E Q fly, the wheel goes ahead, Home goes back")


def dragged_light(window):
    window.key("x")
    window.key("f")
    before = window.measured()
    light = before["lights"][0]
    marker = window.told()["report"]["handles"]
    assert marker, "the light's marker is out of the picture"
    picture_before = window.shot("light")
    x, y = marker
    # The handle along x of the world begins beside the marker.
    for way in [(40, 0), (-40, 0), (0, -40), (28, 28)]:
        window.drag(1, (x + way[0], y + way[1]), [(way[0] // 4, way[1] // 4)] * 6)
        if window.report()["lights"][0]["toward"] != light["toward"]:
            break
    after = window.measured()
    assert after["lights"][0]["toward"] != light["toward"], "no handle moves the light"
    assert difference(picture(picture_before), picture(window.shot("light-dragged"))) > 0.3, "its shadows stay"
    window.key("x")
    print("the light is dragged by its handle")


def switched(window):
    window.click("hard", role="ComboBox")
    window.click("pcf", role="Button")
    window.wait(lambda r: r["sides"][0]["technique"] == "pcf", "the other technique")
    report = window.measured()
    print(f"switched to {report['sides'][0]['label']}: RMSE {report['sides'][0]['rmse']:.4f}")
    agreed(window)


def pictures(window):
    plain = window.shot("plain")
    for label, name in [("error", "Error"), ("truth", "Truth"), ("mask", "Mask"), ("texels", "Texels"), ("cascades", "Layers"), ("lists", "Lists")]:
        window.click(label)
        window.wait(lambda r: r["picture"] == name, f"the picture of {label}")
        window.move(900, 600)
        shown = window.shot(f"over-{label}")
        changed = [difference(a, b) for a, b in zip(halves(plain), halves(shown))]
        print(f"  {label}: the halves change by {changed[0]:.2f} and {changed[1]:.2f}")
        assert max(changed) > 0.05, f"{label} shows nothing"
    window.click("nothing")


def divided(window):
    middle = PANEL + (WIDTH - PANEL) / 2
    found = window.report()["split"]
    x = PANEL - 4 + found * (WIDTH - PANEL + 4)
    window.drag(1, (x, 500), [(-40, 0)] * 4)
    moved = window.report()["split"]
    assert moved < found - 0.1, (found, moved, middle)
    window.key("f")
    window.wait(lambda r: r["split"] is None, "one side")
    window.key("x")
    window.wait(lambda r: r["split"] == 0.5, "both sides")
    print("the divider is dragged; F and X show one side and both")


def planned(window):
    window.click("Find it")
    report = window.wait(lambda r: r["plan"] is not None, "a plan", 300)
    print(f"the least for this view: {report['plan']}")
    window.click("Show it on the left")
    name = report["plan"].split(" ")[0]
    window.wait(lambda r: r["sides"][0]["technique"] == name, "the plan on the left")
    window.click("Copy preset")
    window.wait(lambda r: "clipboard" in (r["message"] or ""), "the preset in the clipboard")
    window.click("Close")
    window.shot("planned")


def failed_and_cured(window):
    window.click("Failures")
    window.click("1 low-sun-5")
    window.wait(lambda r: r["scene"] == "low-sun-5", "the place of a failure")
    report = window.measured()
    fault, cure = report["sides"]
    print(f"low sun: {fault['label']} {fault['rmse']:.3f}, {cure['label']} {cure['rmse']:.4f}")
    assert fault["rmse"] > 0.1 and cure["rmse"] < 0.01, report
    window.key("h")
    window.shot("failure")
    window.key("h")


def kept(program, out):
    """Settings are remembered."""
    first = Window(program, out, ["cubes", "--left", "midpoint"])
    first.key("ctrl+q")
    first.program.wait(timeout=30)
    again = Window(program, out, [], first.folder)
    report = again.report()
    assert report["scene"] == "cubes" and report["sides"][0]["technique"] == "midpoint", report
    again.close()
    print("settings are remembered")


def lost(program, out):
    """A device that is lost in mid-flight: the window comes back, and says so."""
    window = Window(program, out, ["cubes", "--left", "midpoint", "--lose-device-after", "6"])
    # It is found out by the next frame, which takes an event.
    time.sleep(7)
    window.move(800, 400)
    report = window.wait(lambda r: r["message"], "a message", 60)
    assert "lost" in report["message"] and report["scene"] == "cubes", report
    assert report["sides"][0]["technique"] == "midpoint", report
    window.measured()
    window.close()
    print(f"told in the window: {report['message']}")


def fluent(program, out, scene):
    """While the camera moves frames stay quick, on fewer pixels."""
    window = Window(program, out, [scene, "--fresh", "--left", "pcf"])
    # The left side alone.
    window.key("f")
    window.key("f")
    window.move(800, 400)
    window.do("mousedown", 3)
    for _ in range(40):
        window.do("mousemove_relative", "--", 3, 0)
        time.sleep(0.1)
    report = window.report()
    window.do("mouseup", 3)
    frames = 1000 / report["interval_ms"]
    print(f"{scene}, turning: {frames:.1f} frames a second at {100 * report['scale']:.0f} % of the width")
    window.close()
    return frames


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--viewer", type=pathlib.Path)
    parser.add_argument("--out", default=ROOT / "target/viewer-tried", type=pathlib.Path)
    options = parser.parse_args()
    missing = [tool for tool in ["Xvfb", "xdotool", "import"] if not shutil.which(tool)]
    if missing:
        sys.exit(f"needs {', '.join(missing)}: see the head of this file")
    program = options.viewer
    if program is None:
        subprocess.run(["cargo", "build", "--release", "-p", "umbrage-viewer"], cwd=ROOT, check=True)
        target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
        program = target / "release/umbrage-viewer"
    options.out.mkdir(parents=True, exist_ok=True)
    messages(program)
    display = f":{random.randrange(90, 990)}"
    server = subprocess.Popen(["Xvfb", display, "-screen", "0", f"{WIDTH}x{HEIGHT}x24"], stderr=subprocess.DEVNULL)
    os.environ["DISPLAY"] = display
    time.sleep(1)
    try:
        window = Window(program, options.out, ["cubes", "--left", "hard", "--right", "exact", "--fresh"])
        start = measured(window)
        looked_around(window, start)
        dragged_light(window)
        switched(window)
        pictures(window)
        divided(window)
        planned(window)
        failed_and_cured(window)
        window.close()
        kept(program, options.out)
        lost(program, options.out)
        assert fluent(program, options.out, "cubes") >= 10
    finally:
        server.terminate()
    print(f"all well; screenshots are in {options.out}")


if __name__ == "__main__":
    main()
