#!/usr/bin/env python3
"""Tests the viewer's window under Xvfb with real key and mouse events.

    apt-get install xvfb xdotool xclip imagemagick libxkbcommon-x11-0 libxcursor1 libxi6 mesa-vulkan-drivers
    pip install pillow python-xlib
    python3 examples/viewer/try.py          # some minutes; screenshots in target/viewer-tried

Another program or folder for screenshots: try.py [--viewer PROGRAM] [--out FOLDER]. Without --viewer it is built first.
Regions of the screenshots are compared with those in `goldens` (see `pictures.py`); `--bless` overwrites the goldens instead,
and docs/viewer.png.
`--only NAME` runs one part: keyboard, moving, loading, dropped, holes, readable, scaled, fluent, mouse, views, or handed.
`handed` takes a model of one's own, has the least for it found, and hands what was copied to the example `forward`. With
`--copied FILE...` it also takes the presets that the page in a browser has copied (`web/try.py --only handed` keeps one).
The program writes its state, its measurements and the panel's widgets to a file (`--report`). Widgets are found by their text.
"""

import argparse
import base64
import io
import json
import math
import os
import pathlib
import random
import shutil
import struct
import subprocess
import sys
import tempfile
import time

from PIL import Image

# No folder of compiled scripts beside the viewer's sources.
sys.dont_write_bytecode = True
import drop  # noqa: E402
import pictures as compared  # noqa: E402
from pictures import difference, spread  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
WIDTH, HEIGHT = 1280, 720
# Where the panel ends.
PANEL = 350
# Frames a second that the small scene of cubes has to have while the camera turns, on a software driver.
LEAST_RATE = 10


class Window:
    """The viewer's window on a display of its own. Places are points: pixels, divided by the display's scale factor."""

    def __init__(self, program, out, arguments, folder=None, size=(WIDTH, HEIGHT), waits=True, started_in=None, scale=1):
        self.out = out
        self.scale = scale
        self.size = size
        # Another window in the same folder loads the settings of the last one.
        self.folder = folder or pathlib.Path(tempfile.mkdtemp())
        self.file = self.folder / "report.json"
        self.file.unlink(missing_ok=True)
        # Settings are saved in here.
        environment = dict(os.environ, WINIT_X11_SCALE_FACTOR=str(scale), XDG_DATA_HOME=str(self.folder))
        environment.pop("WAYLAND_DISPLAY", None)
        self.log = open(self.folder / "log", "w+")
        self.program = subprocess.Popen(
            [program, *arguments, "--size", "{}x{}".format(*size), "--report", self.file],
            env=environment, stdout=self.log, stderr=self.log, cwd=started_in or self.folder)
        self.wait(lambda r: True, "the first frame")
        self.window = self.do("search", "--sync", "--onlyvisible", "--name", "^umbrage$").split()[0]
        self.do("windowmove", self.window, 0, 0, "windowfocus", self.window)
        if waits:
            self.wait(lambda r: r["loading"] is None, "the scene")
        time.sleep(1)

    def do(self, *arguments):
        return subprocess.run(["xdotool", *map(str, arguments)], check=True, capture_output=True, text=True).stdout

    def file_content(self):
        if self.program.poll() is not None:
            self.log.seek(0)
            raise AssertionError(f"the program ended with {self.program.returncode}: {self.log.read()}")
        return json.loads(self.file.read_text()) if self.file.exists() else None

    def report(self):
        return self.file_content()["report"]

    def wait(self, holds, what, seconds=120, part="report"):
        end = time.time() + seconds
        while time.time() < end:
            content = self.file_content()
            if content and content[part] is not None and holds(content[part]):
                return content[part]
            time.sleep(0.1)
        raise AssertionError(f"{what} did not come within {seconds} s: {self.report()}")

    def measured(self, seconds=300):
        """Waits until truth is traced and both sides and their CPU masks are compared."""
        time.sleep(1)
        self.wait(lambda a: True, "the masks' comparison", seconds, "agreement")
        return self.report()

    def shot(self, name):
        file = self.out / f"{name}.png"
        subprocess.run(["import", "-window", self.window, file], check=True)
        image = Image.open(file).convert("RGB")
        return image if self.scale == 1 else image.reduce(self.scale)

    def still(self, name, region=(PANEL, 70, WIDTH, HEIGHT)):
        """Returns a region of the window once it stops changing: frames follow the report."""
        last = None
        for _ in range(60):
            image = self.shot(name).crop(region)
            if last and spread(image) > 1 and difference(last, image) == 0:
                return image
            last = image
            time.sleep(1.5)
        raise AssertionError(f"the window does not come to rest for `{name}`")

    def move(self, x, y):
        self.do("mousemove", "--window", self.window, x * self.scale, y * self.scale)
        time.sleep(0.4)

    def click(self, words, nth=0, role=None):
        """Clicks the n-th widget of the panel with this text."""
        for _ in range(20):
            left, top, right, bottom = self.place(words, nth, role)
            if top >= 0 and bottom <= HEIGHT - 10:
                break
            # Scrolls the panel until the widget is visible.
            self.move(20, HEIGHT / 2)
            self.do("click", 5 if bottom > HEIGHT - 10 else 4)
            # Scrolling is animated.
            time.sleep(1.5)
        self.move((left + right) / 2, (top + bottom) / 2)
        self.do("click", 1)
        time.sleep(0.6)

    def place(self, words, nth=0, role=None):
        for _ in range(20):
            # Frames may be slow: a menu appears some frames later.
            time.sleep(0.6)
            parts = self.file_content()["widgets"]
            found = [p["at"] for p in parts if words in (p["label"], p["value"]) and role in (None, p["role"])]
            # The report has no order: sorts from top to bottom.
            found.sort(key=lambda at: (at[1], at[0]))
            if len(found) > nth:
                break
        assert len(found) > nth, f"no part `{words}` among {[(p['role'], p['label'], p['value']) for p in parts]}"
        return found[nth]

    def press(self, *names, holds=None, what=None, seconds=120):
        """Presses keys without moving the mouse, then waits until `holds` is true."""
        for name in names:
            self.do("key", name)
            time.sleep(0.3)
        return self.wait(holds or (lambda r: True), what or f"the answer to {names}", seconds)

    def type(self, text):
        self.do("type", "--delay", 40, text)
        time.sleep(0.3)

    def key(self, name):
        self.move(WIDTH - 200, HEIGHT - 60)
        self.do("key", name)
        time.sleep(0.5)

    def drag(self, button, begin, steps):
        self.move(*begin)
        self.do("mousedown", button)
        time.sleep(0.5)
        for dx, dy in steps:
            self.do("mousemove_relative", "--", dx * self.scale, dy * self.scale)
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
    return compared.halves(picture(image))


def agreed(window):
    """The masks that were compared are those of the techniques that are shown, and as the CPU's."""
    content = window.file_content()
    for side, shown in zip(content["agreement"]["sides"], content["report"]["sides"]):
        print(f"  against the CPU: {side}")
        assert side["technique"] == shown["technique"], (side, shown)
        assert side.get("decided_off") == 0, side


def messages(program):
    """Errors before the window opens are printed as messages, without a panic."""
    for what, arguments, code, word, environment in [
        ("a broken size", ["--size", "12"], 2, "write it as 1280x720", {}),
        ("an unknown technique", ["--left", "nothing"], 2, "possible values", {}),
        ("an unknown scene", ["cubess"], 1, "cubes", {}),
        ("a failure that isn't there", ["cubes", "--failure"], 1, "hills-pan", {}),
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
        print(f"message printed: {what}")


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
    marker = window.file_content()["report"]["handles"]
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
    for label, name in [("error", "Error"), ("truth", "Truth"), ("mask", "Mask"), ("texels", "Texels"), ("cascades", "Layers"),
                        ("lists", "Lists"), ("heat", "Heat")]:
        window.click(label)
        window.wait(lambda r: r["picture"] == name, f"the picture of {label}")
        window.move(900, 600)
        # Pictures of lookups are made beside the frames.
        time.sleep(2)
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
    stale = "Outdated: view, light or settings changed. Search again."
    parts = [part["label"] or part["value"] for part in window.file_content()["widgets"]]
    assert stale not in parts, parts
    window.move(900, 600)
    window.do("keydown", "w")
    time.sleep(0.6)
    window.do("keyup", "w")
    window.place(stale)
    window.key("Home")
    window.measured()


def failed_and_cured(window, kept):
    window.click("Failures")
    window.click("shadow acne: low-sun-5")
    window.wait(lambda r: r["scene"] == "low-sun-5", "the place of a failure")
    report = window.measured()
    fault, cure = report["sides"]
    print(f"low sun: {fault['label']} {fault['rmse']:.3f}, {cure['label']} {cure['rmse']:.4f}")
    assert fault["rmse"] > 0.1 and cure["rmse"] < 0.01, report
    window.key("h")
    kept.check("failure", window.still("failure"))
    if kept.blesses:
        # The picture of docs/live.md.
        shutil.copy(window.out / "failure.png", ROOT / "docs/viewer.png")
    window.key("h")


def hidden(program, out):
    """A side that is hidden as its technique changes has no figures of the old one: the mask that is compared is the new one's."""
    window = Window(program, out, ["cubes", "--left", "pcf", "--right", "exact", "--fresh"], size=(640, 480))
    before = window.measured()["sides"][0]
    # The right side alone: the pointer is off the panel, which takes most of so small a window.
    window.move(600, 440)
    window.press("f", holds=lambda r: r["split"] is None and r["shown_side"] == 1, what="the right side alone")
    window.press("1")
    window.type("hard")
    window.press("Return", holds=lambda r: r["sides"][0]["technique"] == "hard", what="the other technique")
    after = window.measured()["sides"][0]
    agreed(window)
    assert after["rmse"] != before["rmse"], (before, after)
    window.close()
    print(f"a hidden side's figures are its own: RMSE {before['rmse']:.4f} of pcf, {after['rmse']:.4f} of hard")


def refused(program, out):
    """What a light set refuses has a reason and no figures, and the other side has its own."""
    window = Window(program, out, ["cubes", "--left", "planar", "--right", "exact", "--fresh"])
    report = window.wait(lambda r: r["sides"][0]["refusal"] and r["sides"][1]["rmse"] is not None and r["truth"] == 1, "figures", 300)
    left, right = report["sides"]
    assert left["rmse"] is None and right["rmse"] == 0, report["sides"]
    window.shot("refused")
    window.press("v", holds=lambda r: r["picture"] == "Error", what="errors")
    window.shot("refused-errors")
    # A plan is one that the window can show.
    report = window.press("p", holds=lambda r: r["planning"] or r["plan"], what="a plan's begin")
    assert report["refused"] == ["planar", "volumes"], report["refused"]
    window.close()
    print(f"a refused technique gives the reason: {left['refusal']}")


def switched_off(program, out):
    """Without the light that is measured there are no figures, and nothing lies over the picture."""
    window = Window(program, out, ["cubes", "--left", "hard", "--right", "exact", "--fresh"])
    window.press("v", holds=lambda r: r["picture"] == "Error", what="errors")
    window.measured()
    window.press("g", holds=lambda r: not r["lights"][0]["is_on"], what="the light off")
    report = window.wait(lambda r: r["truth"] is None, "no truth")
    assert all(side["rmse"] is None for side in report["sides"]), report["sides"]
    with_errors = window.still("switched-off")
    window.press("shift+v", holds=lambda r: r["picture"] == "Nothing", what="nothing over it")
    assert difference(with_errors, window.still("switched-off-plain")) == 0, "errors stay over the picture"
    window.press("g", holds=lambda r: r["lights"][0]["is_on"], what="the light on")
    window.measured()
    agreed(window)
    window.close()
    print("a light that is switched off takes its figures and pictures with it")


def retyped(program, out):
    """Lights of all kinds, chosen in the panel: each is valid, and its masks are the CPU's."""
    window = Window(program, out, ["cubes", "--left", "pcf", "--right", "exact", "--fresh"])
    window.measured()
    kinds = ["directional", "spot", "point", "rectangle", "disc", "directional"]
    for before, kind in zip(kinds, kinds[1:]):
        window.click(before, role="ComboBox")
        window.click(kind, role="Button")
        window.wait(lambda r: r["lights"][0]["kind"].startswith(kind[:4]), f"a light that is {kind}")
        report = window.measured()
        assert report["message"] is None, report["message"]
        agreed(window)
        window.shot(f"retyped-{kind}")
    window.close()
    print(f"a light is made {', '.join(kinds[1:])}")


def moved(program, out):
    """Orbit, parallel lines, and the keys for going nearer; a screenshot is a file of what is seen."""
    window = Window(program, out, ["cubes", "--left", "pcf", "--right", "exact", "--fresh"])
    before = window.measured()["camera"]
    window.key("o")
    near = window.press("plus", holds=lambda r: r["camera"] != before, what="a nearer view")["camera"]
    window.press("minus", holds=lambda r: r["camera"] != near, what="a farther view")
    window.drag(3, (800, 400), [(15, 0)] * 4)
    assert max(abs(a - b) for a, b in zip(window.report()["camera"], before)) > 0.1, "orbit leaves the eye where it is"
    window.click("parallel")
    window.measured()
    agreed(window)
    window.shot("parallel")
    window.key("F12")
    message = window.wait(lambda r: "screenshot is in" in (r["message"] or ""), "the screenshot")["message"]
    file = pathlib.Path(message.split(" is in ")[1].rstrip("."))
    kept = Image.open(file).convert("RGB")
    assert kept.size == (WIDTH, HEIGHT), kept.size
    window.press("Escape", holds=lambda r: r["message"] is None, what="the message's end")
    seen = difference(picture(kept), picture(window.shot("screenshot")))
    assert seen < 0.5, seen
    window.close()
    print("orbit, parallel lines and keys that go nearer; F12 keeps what is seen")


def remembered(program, out):
    """Settings are remembered, with the lights as they were left, wherever the program is started."""
    folder = pathlib.Path(tempfile.mkdtemp())
    bowl(folder / "bowl.obj")
    first = Window(program, out, ["cubes", "--left", "midpoint"])
    first.press("F2")
    first.type(os.path.relpath(folder / "bowl.obj", first.folder))
    first.press("Return", holds=lambda r: r["scene"] == "bowl", what="the model")
    first.key("Right")
    first.press("Insert", holds=lambda r: len(r["lights"]) == 2, what="another light")
    first.measured()
    before = first.report()
    first.key("ctrl+q")
    first.program.wait(timeout=30)
    # What is read in another folder is found there, too.
    again = Window(program, out, [], first.folder, started_in=folder)
    report = again.report()
    assert report["scene"] == "bowl" and report["sides"][0]["technique"] == "midpoint", report
    assert report["lights"] == before["lights"] and report["chosen"] == before["chosen"], (before, report)
    again.key("ctrl+q")
    again.program.wait(timeout=30)
    # Named by its path from there, it is the same.
    named = Window(program, out, ["bowl.obj"], first.folder, started_in=folder)
    assert named.report()["lights"] == before["lights"], named.report()
    named.press("Delete", "Delete", holds=lambda r: not r["lights"], what="no lights")
    named.key("ctrl+q")
    named.program.wait(timeout=30)
    dark = Window(program, out, [], first.folder)
    assert dark.report()["lights"] == [], dark.report()
    dark.close()
    print("settings are remembered, with a model, its view and its lights")


def lost(program, out):
    """After a lost device the window reopens with its lights and shows a message."""
    window = Window(program, out, ["cubes", "--left", "midpoint", "--lose-device-after", "9"])
    window.key("Right")
    lights = window.press("Insert", holds=lambda r: len(r["lights"]) == 2, what="another light")["lights"]
    # It is found out by the next frame, which takes an event.
    time.sleep(10)
    # On the display: the window may have been opened again already, and is another one then.
    window.do("mousemove", 800, 400)
    report = window.wait(lambda r: r["message"] and r["loading"] is None, "a message and the scene", 60)
    assert "lost" in report["message"] and report["scene"] == "cubes", report
    assert report["sides"][0]["technique"] == "midpoint", report
    assert report["lights"] == lights, (lights, report["lights"])
    window.measured()
    window.close()
    print(f"message in the window: {report['message']}")


def seconds_of_cores(process):
    """The time that the machine's cores have spent on a process, seconds."""
    # Of `proc(5)`: the 14th and the 15th field; the second one may hold blanks, and ends with the last bracket.
    fields = pathlib.Path(f"/proc/{process.pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def turning(program, out, scene):
    """While the camera turns frames stay quick, on fewer pixels. Returns frames a second."""
    window = Window(program, out, [scene, "--fresh", "--left", "pcf"])
    # The left side alone.
    window.key("f")
    window.key("f")
    window.move(800, 400)
    window.do("mousedown", 3)
    turn(window, 20)
    # By now the picture has as many pixels as it will have.
    before, spent, begin = window.report()["frames"], seconds_of_cores(window.program), time.time()
    turn(window, 40)
    after, spent, passed = window.report()["frames"], seconds_of_cores(window.program) - spent, time.time() - begin
    report = window.report()
    window.shot(f"turning-{scene}")
    window.do("mouseup", 3)
    rate = (after - before) / passed
    print(f"{scene}, {report['triangles']} triangles, turning: {rate:.1f} frames a second at {100 * report['scale']:.0f} % of the width; "
          f"a frame takes {1000 * spent / (after - before):.0f} ms of the cores' time")
    window.close()
    return rate


def turn(window, steps):
    for _ in range(steps):
        window.do("mousemove_relative", "--", 3, 0)
        time.sleep(0.1)


def fluent(program, out):
    """What moves stays fluent in scenes of all sizes."""
    # Larger scenes take as long as the machine is slow and busy: their figures are to be read.
    for scene in ["town", "street", "nave"]:
        turning(program, out, scene)
    rate = turning(program, out, "cubes")
    assert rate >= LEAST_RATE, f"cubes turn at {rate:.1f} frames a second, {LEAST_RATE} are wanted"


def ring(image):
    """The rectangle around the part that has the keyboard; none if nothing has."""
    pixels = image.load()
    at = [(x, y) for y in range(image.height) for x in range(image.width) if pixels[x, y] == (255, 200, 60)]
    if not at:
        return None
    return min(x for x, _ in at), min(y for _, y in at), max(x for x, _ in at), max(y for _, y in at)


def tabbed(window):
    """Tab goes through the panel; what has the keyboard is framed, scrolled into view, and pressed by Enter."""
    add = window.place("Add", role="Button")
    places = [None]
    while places[-1] is None or max(abs(a - b) for a, b in zip(places[-1], add)) > 1:
        assert len(places) < 60, "Tab does not reach the button `Add`"
        report = window.press("Tab", holds=lambda r: r["focus"] != places[-1], what="the next part")
        places.append(report["focus"])
        assert 0 <= places[-1][1] and places[-1][3] <= HEIGHT, f"the part that has the keyboard is out of the window: {places[-1]}"
    assert len(places) > 10, f"Tab reaches {len(places)} parts only"
    found = ring(window.still("focus", (0, 0, PANEL - 30, HEIGHT)))
    assert found and max(abs(a - b) for a, b in zip(found, add)) < 6, f"no frame is around the part that has the keyboard: {found}, {add}"
    count = len(window.report()["lights"])
    window.press("Return", holds=lambda r: len(r["lights"]) == count + 1, what="another light")
    window.press("Escape")
    window.press("Delete", holds=lambda r: len(r["lights"]) == count, what="one light less")
    print(f"Tab goes through the panel ({len(places) - 1} parts to `Add`), and Enter presses")


def moving(program, out):
    """A moving failure follows its path until it is paused or the user moves the camera or the light."""
    window = Window(program, out, ["hills-pan", "--failure", "--fresh"])
    begin = window.report()
    assert begin["path"]["playing"] and begin["scene"] == "hills", begin["path"]
    window.wait(lambda r: r["path"]["step"] != begin["path"]["step"] and r["camera"] != begin["camera"], "the next step")
    window.shot("moving")
    window.press("space", holds=lambda r: not r["path"]["playing"], what="the pause")
    time.sleep(1)
    paused = window.measured()
    time.sleep(1)
    after = window.report()
    assert after["camera"] == paused["camera"] and after["path"]["step"] > 0, "it moves while it is paused"
    window.shot("paused")
    fault, cure = [side["wrong"] for side in after["sides"]]
    print(f"hills-pan, paused at step {after['path']['step']}: {fault:.0f} pixels wrong on the left, {cure:.0f} on the right")
    window.press("plus", holds=lambda r: r["path"]["step"] is None, what="the end of the path")
    nearer = window.report()["camera"]
    back = window.press("minus", holds=lambda r: r["camera"] != nearer, what="a step back")["camera"]
    assert math.dist(back, paused["camera"]) < 0.1 * math.dist(begin["camera"], paused["camera"]), (back, paused, begin)
    window.press("Home")
    window.click("Play", role="Button")
    window.wait(lambda r: r["path"]["playing"] and r["camera"] not in (begin["camera"], back), "the way on")
    before = window.report()["camera"]
    window.move(WIDTH - 200, HEIGHT - 60)
    window.do("keydown", "w")
    time.sleep(1)
    window.do("keyup", "w")
    stopped = window.wait(lambda r: r["path"]["step"] is None, "the end of the path")
    assert not stopped["path"]["playing"], stopped["path"]
    far = sum((a - b) ** 2 for a, b in zip(before, begin["camera"])) ** 0.5
    print(f"the path had gone {far:.2f} m; the user's own motion ended it")
    window.press("b", holds=lambda r: r["loading"] is None and (r["path"] or {}).get("name") != "hills-pan", what="the next place")
    window.press("F3")
    window.type("hills-sun")
    report = window.press("Return", holds=lambda r: (r["path"] or {}).get("name") == "hills-sun", what="the turning sun")
    window.wait(lambda r: r["lights"] != report["lights"], "the sun's turn")
    window.press("Left", holds=lambda r: r["path"]["step"] is None, what="the end of the path")
    window.close()


def keyboard(program, out, kept):
    """Everything can be operated without a mouse."""
    window = Window(program, out, ["cubes", "--left", "hard", "--right", "exact", "--fresh"])
    window.press("F1", holds=lambda r: r["help"], what="the keys")
    kept.check("keys", window.still("keys"))
    window.press("Escape", holds=lambda r: not r["help"])
    window.press("F2")
    window.type("c3 ro")
    time.sleep(1)
    window.shot("picker")
    window.press("Return", holds=lambda r: r["scene"] == "c3-room", what="the scene")
    window.press("1")
    window.type("pcf")
    window.press("Return", holds=lambda r: r["sides"][0]["technique"] == "pcf", what="the technique of the left")
    window.press("2")
    window.type("hard")
    window.press("Return", holds=lambda r: r["sides"][1]["technique"] == "hard", what="the technique of the right")
    window.press("F2")
    window.type("cubes")
    window.press("Return", holds=lambda r: r["scene"] == "cubes", what="the scene")
    for keys in [("Right",), ("Up", "Up"), ("Prior",), ("shift+Left",), ("r", "Right", "r")]:
        before = window.report()["lights"][0]
        window.press(*keys, holds=lambda r: r["lights"][0] != before, what=f"another light after {keys}")
    window.press("Insert", holds=lambda r: len(r["lights"]) == 2 and r["chosen"] == 1, what="another light")
    window.press("n", holds=lambda r: r["chosen"] == 0, what="the next light")
    window.press("shift+n", holds=lambda r: r["chosen"] == 1, what="the light before")
    window.press("g", holds=lambda r: not r["lights"][1]["is_on"], what="the light off")
    window.press("Delete", holds=lambda r: len(r["lights"]) == 1, what="a light less")
    window.press("period", "period", "period", holds=lambda r: 0.55 < r["split"] < 0.57, what="the divider to the right")
    window.press("comma", holds=lambda r: 0.53 < r["split"] < 0.55, what="the divider to the left")
    window.press("v", holds=lambda r: r["picture"] == "Error", what="the errors")
    window.press("shift+v", holds=lambda r: r["picture"] == "Nothing", what="no picture over the scene")
    window.press("h", holds=lambda r: r["picture"] == "Error", what="the errors")
    window.press("m", holds=lambda r: r["maps"], what="the maps")
    window.press("m", "h", holds=lambda r: not r["maps"])
    eye = window.report()["camera"]
    before = window.shot("looks")
    window.do("keydown", "j")
    time.sleep(1)
    window.do("keyup", "j")
    window.press("x", "x", holds=lambda r: r["camera"] == eye and r["split"] == 0.5)
    assert difference(picture(before), picture(window.shot("looked"))) > 1, "J does not look around"
    window.press("Home")
    window.press("p", holds=lambda r: r["planning"] or r["plan"], what="a plan that begins")
    plan = window.wait(lambda r: r["plan"], "a plan", 400)["plan"]
    window.press("shift+p", holds=lambda r: r["sides"][0]["technique"] == plan.split(" ")[0], what="the plan on the left")
    window.press("c", holds=lambda r: "clipboard" in (r["message"] or ""), what="the preset in the clipboard")
    window.press("Escape", holds=lambda r: r["message"] is None, what="no message")
    window.press("p", holds=lambda r: r["planning"], what="a plan that begins")
    window.press("p", holds=lambda r: not r["planning"], what="the plan called off")
    window.press("F3")
    window.type("low-sun-5")
    window.press("Return", holds=lambda r: r["scene"] == "low-sun-5", what="the place of a failure")
    window.press("b", holds=lambda r: r["loading"] is None and r["scene"] != "low-sun-5", what="the next place of failure")
    window.press("shift+b", holds=lambda r: r["scene"] == "low-sun-5", what="the one before")
    tabbed(window)
    window.press("ctrl+plus", holds=lambda r: r["zoom"] and abs(r["pixels_per_point"] - 1.1) < 0.01, what="larger text")
    window.press("ctrl+minus", "ctrl+minus", holds=lambda r: abs(r["pixels_per_point"] - 0.9) < 0.01, what="smaller text")
    window.press("ctrl+0", holds=lambda r: r["zoom"] is None and r["pixels_per_point"] == 1, what="text of the usual size")
    window.press("F4", holds=lambda r: r["folded"], what="the folded panel")
    window.press("F4", holds=lambda r: r["folded"] is False, what="the panel")
    window.do("key", "ctrl+q")
    window.program.wait(timeout=30)
    print("the keyboard alone chooses scene, techniques and lights, divides, plans, copies, and looks at failures")


def large_model(file, side):
    """Writes a model of hills, 2 side^2 triangles."""
    with open(file, "w") as out:
        for y in range(side + 1):
            for x in range(side + 1):
                out.write(f"v {x / 50} {0.1 * ((x * 7 + y * 3) % 11)} {y / 50}\n")
        for y in range(side):
            for x in range(side):
                a = y * (side + 1) + x + 1
                out.write(f"f {a} {a + side + 1} {a + 1}\nf {a + 1} {a + side + 1} {a + side + 2}\n")


def loading(program, out):
    """The window answers while a large model is read; a newer choice replaces it; what is broken leaves the old scene."""
    folder = pathlib.Path(tempfile.mkdtemp())
    large, broken = folder / "large.obj", folder / "broken.obj"
    large_model(large, 500)
    broken.write_text("v 0 0 0\nf 1 2 x\n")
    window = Window(program, out, [large, "--fresh"], waits=False)
    answers = []
    while window.report()["loading"]:
        begin, before = time.time(), window.report()["shown_side"]
        window.do("key", "f")
        window.wait(lambda r: r["shown_side"] != before or not r["loading"], "an answer while a model is read", 30)
        answers.append(time.time() - begin)
        window.shot("loading")
    assert window.report()["triangles"] >= 500_000, window.report()
    assert answers and max(answers) < 5, f"the window answers after {answers} s"
    print(f"500,000 triangles are read; the window answers {len(answers)} keys meanwhile, after {max(answers):.1f} s at most")
    window.press("F2")
    window.type("cubes")
    window.press("Return", holds=lambda r: r["scene"] == "cubes", what="the scene")
    for file, keys in [(large, ["Escape"]), (large, ["F2", None, "Return"])]:
        window.press("F2")
        window.type(str(file))
        window.press("Return", holds=lambda r: r["loading"], what="the model that is read")
        for key in keys:
            window.type("figure") if key is None else window.press(key)
        window.wait(lambda r: r["loading"] is None or "figure" in r["loading"], "the model given up")
    window.wait(lambda r: r["scene"] == "figure", "the newer choice")
    # Longer than the model takes: it must not come after all.
    time.sleep(5)
    assert window.report()["scene"] == "figure", window.report()
    for file, word in [(broken, "broken.obj"), (folder / "none.obj", "none.obj"), (folder, str(folder))]:
        window.press("F2")
        window.type(str(file))
        if file == folder:
            # No scene has that name: there is nothing to take.
            window.press("Return", "Escape")
            continue
        window.press("Return", holds=lambda r: word in (r["message"] or ""), what="a message about the broken file")
        print(f"  message in the window: {window.report()['message']}")
        assert window.report()["scene"] == "figure", "the old scene is gone"
        window.press("Escape")
    window.shot("broken")
    window.close()
    window = Window(program, out, [broken, "--fresh"])
    report = window.wait(lambda r: r["scene"] == "town", "the usual scene")
    assert "broken.obj" in report["message"], report
    window.close()
    print("a newer choice replaces a scene that is read, Esc gives it up, and a broken file leaves the old one")


def bowl(file):
    """Writes a small model: a bowl over a floor."""
    points, faces, steps = [(-3, 0, -3), (-3, 0, 3), (3, 0, 3), (3, 0, -3)], ["f 1 2 3 4"], 24
    for ring_ in range(6):
        height, radius = 0.4 + 0.15 * ring_ * ring_ / 5, 0.2 + 0.2 * ring_
        turns = [2 * math.pi * i / steps for i in range(steps)]
        points += [(radius * math.cos(a), height, radius * math.sin(a)) for a in turns]
    for ring_ in range(5):
        for i in range(steps):
            a, b = 5 + ring_ * steps + i, 5 + ring_ * steps + (i + 1) % steps
            faces.append(f"f {a} {b} {b + steps} {a + steps}")
    file.write_text("\n".join("v {:.4f} {:.4f} {:.4f}".format(*p) for p in points) + "\n" + "\n".join(faces) + "\n")


def taken(preset, forward, out):
    """Hands a preset file to the example `forward`, which must draw with its technique."""
    technique = preset.read_text().split('technique = "')[1].split('"')[0]
    output = subprocess.run([forward, preset.resolve()], cwd=out, check=True, capture_output=True, text=True, timeout=300).stdout
    assert output.strip().endswith(f", {technique}"), output
    (out / "forward.png").rename(out / f"{preset.name}.png")
    print(f"the example `forward` draws with {technique}")


def handed(program, out, forward, copied):
    """A model of one's own, the least for it, and its preset in a renderer of one's own."""
    folder = pathlib.Path(tempfile.mkdtemp())
    model = folder / "bowl.obj"
    bowl(model)
    # No plan is what is on the right: the copy of the wrong side would be found out.
    window = Window(program, out, ["cubes", "--left", "hard", "--right", "midpoint", "--fresh"])
    window.press("F2")
    window.type(str(model))
    window.press("Return", holds=lambda r: r["scene"] == "bowl", what="the model")
    window.click("Find it")
    report = window.wait(lambda r: r["plan"] is not None, "a plan", 300)
    print(f"the least for the model: {report['plan']}")
    window.click("Show it on the left")
    technique = report["plan"].split(" ")[0]
    report = window.wait(lambda r: r["sides"][0]["technique"] == technique, "the plan on the left")
    assert report["sides"][1]["technique"] != technique, report
    window.click("Copy preset")
    window.wait(lambda r: "clipboard" in (r["message"] or ""), "the preset in the clipboard")
    text = subprocess.run(["xclip", "-selection", "clipboard", "-o"], check=True, capture_output=True, text=True, timeout=30).stdout
    (out / "handed.preset.toml").write_text(text)
    assert f'technique = "{technique}"' in text, text
    window.close()
    for file in [out / "handed.preset.toml", *copied]:
        taken(file, forward, out)


def dropped(program, out):
    """Files that are dropped on the window, as a file manager does."""
    folder = pathlib.Path(tempfile.mkdtemp()) / "with blanks & signs"
    folder.mkdir()
    model, card, notes, broken = [folder / name for name in ["bowl.obj", "card.gltf", "notes.txt", "broken.obj"]]
    bowl(model)
    checked_card(card, "MASK")
    notes.write_text("no scene")
    broken.write_text("v 0 0\nf 1 2 3\n")
    window = Window(program, out, ["cubes", "--left", "pcf", "--right", "exact", "--fresh"])
    held = drop.Drag(window.window, [notes, model])
    held.over(800, 400)
    window.place("Drop it here to show bowl.obj.")
    window.shot("dropped-held")
    held.leave()
    time.sleep(1)
    labels = [part["label"] or part["value"] for part in window.file_content()["widgets"]]
    assert "Drop it here to show bowl.obj." not in labels and window.report()["scene"] == "cubes", labels
    for files, scene in [([notes, model], "bowl"), ([card], "card")]:
        drop.dropped(window.window, files)
        window.wait(lambda r: r["scene"] == scene and r["loading"] is None, f"the scene {scene}")
        report = window.measured()
        assert report["message"] is None, report["message"]
        agreed(window)
    window.shot("dropped")
    for file, word in [(broken, "broken.obj"), (notes, "notes.txt")]:
        drop.dropped(window.window, [file])
        message = window.wait(lambda r: word in (r["message"] or ""), "a message about the file")["message"]
        print(f"  message in the window: {message}")
        assert window.report()["scene"] == "card", "the old scene is gone"
    window.close()
    print("files that are dropped are shown, with what they are named while they are held over the window")


def checked_card(file, mode):
    """Writes a glTF model: an upright card whose texture is clear in every other of 8 x 8 squares."""
    image = Image.new("RGBA", (64, 64), (60, 150, 50, 255))
    for y in range(8):
        for x in range(y % 2, 8, 2):
            image.paste((60, 150, 50, 0), (8 * x, 8 * y, 8 * x + 8, 8 * y + 8))
    png = io.BytesIO()
    image.save(png, "PNG")
    corners = [(-1, 0, 0), (1, 0, 0), (1, 2, 0), (-1, 2, 0)]
    uvs = [(0, 1), (1, 1), (1, 0), (0, 0)]
    numbers = struct.pack("<12f", *sum(corners, ())) + struct.pack("<8f", *sum(uvs, ())) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)

    def uri(kind, data):
        return f"data:{kind};base64,{base64.b64encode(data).decode()}"

    file.write_text(json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}],
        "materials": [{"alphaMode": mode, "doubleSided": True, "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "textures": [{"source": 0}], "images": [{"uri": uri("image/png", png.getvalue())}],
        "buffers": [{"byteLength": len(numbers), "uri": uri("application/octet-stream", numbers)}],
        "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 32},
                        {"buffer": 0, "byteOffset": 80, "byteLength": 12}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [-1, 0, 0], "max": [1, 2, 0]},
                      {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"},
                      {"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}],
    }))


def holes(program, out):
    """A glTF model with a mask: its holes are in the picture, in the maps and in lists, as in truth."""
    folder = pathlib.Path(tempfile.mkdtemp())
    masked, whole = folder / "masked.gltf", folder / "whole.gltf"
    checked_card(masked, "MASK")
    checked_card(whole, "OPAQUE")
    window = Window(program, out, [masked, "--fresh", "--left", "hard", "--right", "exact"])
    report = window.measured()
    assert report["message"] is None, report["message"]
    agreed(window)
    # A model's sun has a width, which neither side knows. A whole card's shadow would be wrong by more.
    assert max(side["rmse"] for side in report["sides"]) < 0.05, report["sides"]
    with_holes = window.still("holes")
    window.press("F2")
    window.type(str(whole))
    window.press("Return", holds=lambda r: r["loading"] is None and "whole" in r["scene"], what="the card without holes")
    window.measured()
    assert difference(with_holes, window.still("holes-whole")) > 1, "the mask changes nothing"
    window.press("F2")
    window.type("leaf-cards")
    window.press("Return", holds=lambda r: r["scene"] == "leaf-cards", what="the clearing", seconds=300)
    report = window.measured(600)
    print(f"leaf-cards: {report['sides'][0]['wrong']:.0f} pixels wrong on the left, {report['sides'][1]['wrong']:.0f} on the right")
    agreed(window)
    window.shot("leaf-cards")
    window.close()
    print("the holes of a masked glTF model and of leaves are seen and cast")


def readable(program, out):
    """Text stays readable on a large display, whatever scale it reports; the user's choice is saved."""
    first = Window(program, out, ["cubes", "--fresh"], size=(3840, 2160))
    report = first.wait(lambda r: r["pixels_per_point"] == 2, "text of twice the size")
    left, top, right, bottom = first.place("Failures", role="Button")
    assert 2 * (bottom - top) >= 32, f"a button is {2 * (bottom - top)} pixels high"
    # The rest changes while truth is traced.
    first.still("readable-3840", (0, 0, 480, 640))
    first.press("ctrl+minus", holds=lambda r: abs(r["pixels_per_point"] - 1.9) < 0.01, what="smaller text")
    first.do("key", "ctrl+q")
    first.program.wait(timeout=60)
    again = Window(program, out, [], first.folder, size=(3840, 2160))
    again.wait(lambda r: abs(r["pixels_per_point"] - 1.9) < 0.01, "the text's size of the last time")
    again.close()
    small = Window(program, out, ["cubes", "--fresh"])
    small.wait(lambda r: r["pixels_per_point"] == 1, "text of the usual size")
    small.still("readable-1280", (0, 0, 240, 320))
    small.close()
    print("text is readable at 1280x720 and 3840x2160, and its size is remembered")


def scaled(program, out):
    """On a display whose scale factor is 2: the pointer meets what is drawn, and all pixels are measured."""
    window = Window(program, out, ["cubes", "--left", "hard", "--right", "exact", "--fresh"], scale=2)
    window.wait(lambda r: r["pixels_per_point"] == 2, "text of twice the size")
    window.shot("scaled")
    size = Image.open(out / "scaled.png").size
    assert size == (2 * WIDTH, 2 * HEIGHT), size
    report = window.measured(600)
    assert report["size"][1] == 2 * HEIGHT, report["size"]
    agreed(window)
    divided(window)
    dragged_light(window)
    switched(window)
    window.close()
    print("a display with a scale factor of 2 has all of it")


def mouse(program, out, kept):
    window = Window(program, out, ["cubes", "--left", "hard", "--right", "exact", "--fresh"])
    start = measured(window)
    kept.check("start", window.still("start"))
    kept.check("panel", window.still("panel", (0, 0, 300, 440)))
    looked_around(window, start)
    dragged_light(window)
    switched(window)
    pictures(window)
    divided(window)
    planned(window)
    failed_and_cured(window, kept)
    window.close()
    overlays(program, out, kept)
    remembered(program, out)
    lost(program, out)


def overlays(program, out, kept):
    """Overlays match the goldens."""
    window = Window(program, out, ["cubes", "--left", "hard", "--right", "exact", "--fresh"])
    window.measured()
    for name in ["Error", "Truth", "Mask", "Texels", "Layers", "Lists"]:
        window.press("v", holds=lambda r: r["picture"] == name, what=f"the picture of {name}")
        if name in ("Error", "Texels", "Lists"):
            kept.check(f"over-{name.lower()}", window.still(f"over-{name.lower()}"))
    window.close()


def views(program, out):
    """Measurements match what is shown, whatever the user changes."""
    hidden(program, out)
    refused(program, out)
    switched_off(program, out)
    retyped(program, out)
    moved(program, out)


PARTS = ["keyboard", "moving", "loading", "dropped", "holes", "readable", "scaled", "fluent", "mouse", "views", "handed"]


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--viewer", type=pathlib.Path)
    parser.add_argument("--out", default=ROOT / "target/viewer-tried", type=pathlib.Path)
    parser.add_argument("--bless", action="store_true")
    parser.add_argument("--only", choices=PARTS)
    parser.add_argument("--copied", type=pathlib.Path, nargs="*", default=[], help="presets that the example `forward` is to take, too")
    options = parser.parse_args()
    missing = [tool for tool in ["Xvfb", "xdotool", "xclip", "import"] if not shutil.which(tool)]
    if missing:
        sys.exit(f"needs {', '.join(missing)}: see the head of this file")
    program = options.viewer
    if program is None:
        subprocess.run(["cargo", "build", "--release", "-p", "umbrage-viewer"], cwd=ROOT, check=True)
        target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
        program = target / "release/umbrage-viewer"
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    if options.only in (None, "handed"):
        subprocess.run(["cargo", "build", "--release", "-p", "umbrage-examples", "--example", "forward"], cwd=ROOT, check=True)
    # Windows run in folders of their own.
    program = program.resolve()
    if not program.is_file():
        sys.exit(f"{program} is not there: build it, or leave --viewer out")
    options.out.mkdir(parents=True, exist_ok=True)
    if not options.bless:
        compared.test()
    kept = compared.Goldens(compared.FOLDERS[0], options.bless, options.out)
    messages(program)
    display = f":{random.randrange(90, 990)}"
    # -noreset: otherwise the server restarts as its last window closes, and refuses the next one.
    server = subprocess.Popen(["Xvfb", display, "-screen", "0", "3840x2160x24", "-noreset"], stderr=subprocess.DEVNULL)
    os.environ["DISPLAY"] = display
    time.sleep(1)
    parts = {
        "keyboard": lambda: keyboard(program, options.out, kept),
        "moving": lambda: moving(program, options.out),
        "loading": lambda: loading(program, options.out),
        "dropped": lambda: dropped(program, options.out),
        "holes": lambda: holes(program, options.out),
        "readable": lambda: readable(program, options.out),
        "scaled": lambda: scaled(program, options.out),
        "fluent": lambda: fluent(program, options.out),
        "mouse": lambda: mouse(program, options.out, kept),
        "views": lambda: views(program, options.out),
        "handed": lambda: handed(program, options.out, target.resolve() / "release/examples/forward", options.copied),
    }
    try:
        for name, run in parts.items():
            if options.only in (None, name):
                run()
        if options.only is None:
            kept.end()
    finally:
        server.terminate()
    print(f"all parts passed; screenshots are in {options.out}")


if __name__ == "__main__":
    main()
