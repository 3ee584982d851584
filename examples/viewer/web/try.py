#!/usr/bin/env python3
"""Tries the viewer's page in a browser without a display.

    cargo xtask web --no-serve
    pip install playwright pillow
    apt-get install chromium                # Debian's has WebGPU on SwiftShader, a software driver
    python3 examples/viewer/web/try.py      # some minutes; screenshots in target/web-tried

Another page, browser or folder for screenshots: try.py [--page FOLDER] [--browser PROGRAM] [--out FOLDER].
Screenshots are compared with golden pictures, see `../pictures.py`; --bless makes these anew.
Clicks and keys are real ones, sent to the browser. Parts of the panel are found by their words: `umbrage_widgets()` tells where they are.
"""

import argparse
import base64
import functools
import http.server
import io
import json
import math
import pathlib
import sys
import threading
import time

from PIL import Image
from playwright.sync_api import sync_playwright

# No folder of compiled scripts beside the sources.
sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
import pictures as compared  # noqa: E402
from pictures import difference, spread  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[3]
# Without the last two, the browser's compositor can't show a WebGPU canvas, and the device is lost with the first frame.
WEBGPU = ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan",
          "--use-vulkan=swiftshader", "--use-angle=swiftshader"]
SIZE = {"width": 960, "height": 540}
# A telephone, held upright.
NARROW = {"width": 390, "height": 844}
UNFOLD = "\u2630 Scene and settings"
# Seconds that a server on the same machine may take to show the first frame.
MOST_START = 5
# Frames that are drawn, at least, while a worker is busy. On two cores that a software driver shares with the worker there are few; a page
# that stands still draws none.
LEAST_FRAMES = 3
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


# A model with a material of its own and a texture, as modelling programs write them.
MODEL = """
mtllib looks.mtl
v -1 0 0
v 1 0 0
v 1 2 0
v -1 2 0
vt 0 0
vt 1 0
vt 1 1
vt 0 1
usemtl checks
f 1/1 2/2 3/3 4/4
"""
LOOKS = """
newmtl checks
Kd 1 1 1
map_Kd C:\\models\\checks.png
"""
WITH_MODEL = """
[[light]]
kind = "directional"
direction = [1, -2, -1]
[camera]
eye = [2, 3, 7]
target = [0, 0.7, 0]
[[object]]
shape = "plane"
scale = 4
texture = "textures/checks.png"
[[object]]
mesh = "models/sign.obj"
"""


def checks():
    """A PNG image of four squares."""
    image = Image.new("RGB", (64, 64), (200, 40, 30))
    for corner in [(0, 0), (32, 32)]:
        image.paste((240, 220, 60), (*corner, corner[0] + 32, corner[1] + 32))
    out = io.BytesIO()
    image.save(out, "PNG")
    return out.getvalue()


class Server(http.server.SimpleHTTPRequestHandler):
    # What is served in place of files, by their paths: none for an error.
    instead = {}

    def do_GET(self):
        if self.path not in self.instead:
            return super().do_GET()
        text = self.instead[self.path]
        if text is None:
            return self.send_error(404)
        self.send_response(200)
        self.send_header("Content-Type", "text/javascript")
        self.end_headers()
        self.wfile.write(text.encode())

    def end_headers(self):
        # Else what is served instead of a file is not asked for.
        self.send_header("Cache-Control", "no-store")
        super().end_headers()

    def log_message(self, *_):
        pass


class Viewer:
    """A page with the viewer in it."""

    def __init__(self, browser, address, out, golden):
        self.page = browser.new_page(viewport=SIZE)
        self.address, self.out, self.golden = address, out, golden
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
            return report["truth"] == 1 and all(side["wrong"] is not None or side["refusal"] for side in shown)
        return self.wait(done, "truth", seconds)

    def shot(self, name):
        """Returns what is seen once it stays the same, and keeps it: a software driver shows frames late."""
        png = None
        for _ in range(20):
            time.sleep(0.7)
            last, png = png, self.page.screenshot(timeout=120_000)
            if last == png:
                break
        (self.out / f"{name}.png").write_bytes(png)
        return Image.open(io.BytesIO(png)).convert("RGB")

    def golden_shot(self, name, region=None):
        """A screenshot that is compared with a golden one."""
        image = self.shot(name)
        self.golden.check(name, image.crop(region or PICTURE))
        return image

    def widgets(self):
        self.page.evaluate("umbrage_widgets()")
        # They are those of the next frame.
        for _ in range(20):
            time.sleep(0.5)
            widgets = json.loads(self.page.evaluate("umbrage_widgets()"))
            if widgets:
                return widgets
        raise AssertionError("the page draws no frame")

    def find(self, role, words, nth=0):
        """Where the n-th part with these words is, counted from top to bottom."""
        widgets = self.widgets()
        found = [w for w in widgets if w["role"] == role and words in (w["label"], w["value"])]
        # They are told of in no order.
        found.sort(key=lambda w: (w["at"][1], w["at"][0]))
        assert len(found) > nth, f"no {role} `{words}` among {[(w['role'], w['label'], w['value']) for w in widgets]}"
        return found[nth]["at"]

    def click(self, role, words, nth=0):
        """Clicks on the n-th part with these words; scrolls the panel where it lies below or above what is seen."""
        last = None
        for _ in range(60):
            left, top, right, bottom = at = self.find(role, words, nth)
            # The panel glides for a while after it was scrolled.
            rests, last = at == last, at
            if not rests:
                continue
            if 0 <= top and bottom <= SIZE["height"]:
                break
            self.page.mouse.move(100, SIZE["height"] / 2)
            self.page.mouse.wheel(0, 150 if top > 0 else -150)
            time.sleep(0.5)
        else:
            raise AssertionError(f"{role} `{words}` could not be scrolled to")
        self.page.mouse.click((left + right) / 2, (top + bottom) / 2)
        time.sleep(0.3)

    def drop(self, files):
        """Drops files on the page, all at once."""
        sent = [(name, base64.b64encode(data if isinstance(data, bytes) else data.encode()).decode()) for name, data in files.items()]
        self.page.evaluate("""files => {
            const data = new DataTransfer();
            for (const [name, text] of files)
                data.items.add(new File([Uint8Array.from(atob(text), letter => letter.charCodeAt(0))], name));
            const at = { clientX: 600, clientY: 300, dataTransfer: data, bubbles: true, cancelable: true };
            for (const kind of ["dragenter", "dragover", "drop"])
                document.getElementById("umbrage").dispatchEvent(new DragEvent(kind, at));
        }""", sent)

    def frames_while(self, goes_on, seconds):
        """Counts the frames that are drawn while something goes on: the number, and how many seconds they took."""
        begin, end = time.time(), time.time() + seconds
        first, count = self.report()["frames"], 0
        while time.time() < end:
            report = self.report()
            if not goes_on(report):
                break
            count = report["frames"] - first
            time.sleep(0.05)
        return count, time.time() - begin

    def key(self, name):
        # Keys go to the canvas; the pointer is kept off the panel.
        self.page.mouse.move(SIZE["width"] - 200, SIZE["height"] - 60)
        self.page.keyboard.press(name)
        time.sleep(0.3)


# The picture without the panel and the labels above it.
PICTURE = (340, 70, SIZE["width"], SIZE["height"])


def picture(image):
    return image.crop(PICTURE)


def halves(image):
    return compared.halves(picture(image))


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
    viewer.measured()
    image = viewer.golden_shot("cubes")
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


def dragged(viewer):
    """The light by its handle, and the divider, both with the mouse."""
    viewer.open("?scene=cubes&left=hard&right=exact&split=0.5")
    report = viewer.measured()
    x, y = report["handles"]
    toward = report["lights"][0]["toward"]
    before = viewer.shot("before-drag")
    mouse = viewer.page.mouse

    def drag(begin, step, count=6):
        mouse.move(*begin)
        # The page has to see where the pointer is before it is pressed.
        time.sleep(1)
        mouse.down()
        for i in range(1, count + 1):
            mouse.move(begin[0] + i * step[0], begin[1] + i * step[1])
            time.sleep(0.3)
        mouse.up()
        time.sleep(0.5)

    for way in [(40, 0), (-40, 0), (0, -40), (28, 28)]:
        drag((x + way[0], y + way[1]), (way[0] / 4, way[1] / 4))
        if viewer.report()["lights"][0]["toward"] != toward:
            break
    report = viewer.measured()
    assert report["lights"][0]["toward"] != toward, "no handle moves the light"
    assert difference(picture(before), picture(viewer.shot("light-dragged"))) > 0.3, "its shadows stay"
    agreed(viewer)
    # The divider is in the middle of what the panel leaves.
    middle = (PICTURE[0] + SIZE["width"]) / 2
    drag((middle + 4, SIZE["height"] - 60), (-30, 0))
    split = viewer.report()["split"]
    assert split < 0.45, split
    viewer.shot("divided")
    print(f"the light is dragged by its handle, and the divider to {split:.2f}")


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
    hard = picture(viewer.golden_shot("mask-hard"))
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
    viewer.open("?scene=cubes&left=hard&right=exact&split=0.5")
    viewer.drop({"ball.toml": BALL})
    viewer.wait(lambda r: r["scene"] == "ball", "the dropped scene")
    viewer.measured()
    viewer.golden_shot("ball")
    viewer.drop({"dark.toml": "[[light]]\nkind = 'dark'"})
    report = viewer.wait(lambda r: r["message"], "a message")
    print(f"a broken scene is refused: {report['message']}")
    assert "dark.toml" in report["message"] and report["scene"] == "ball", report


def dropped_together(viewer):
    """A model with its looks, a scene with all that it names, and what is said where something is missing."""
    viewer.open("?scene=cubes&left=hard&right=exact&split=0.5")
    model = {"checks.png": checks(), "looks.mtl": LOOKS, "sign.obj": MODEL}
    viewer.drop(model)
    report = viewer.wait(lambda r: r["scene"] == "sign", "the dropped model")
    assert report["message"] is None, report
    # Two squares and a floor.
    assert report["triangles"] == 4, report
    viewer.measured()
    viewer.golden_shot("model")
    viewer.drop({"scene.toml": WITH_MODEL, **model})
    report = viewer.wait(lambda r: r["scene"] == "scene", "the dropped scene")
    assert report["message"] is None, report
    viewer.measured()
    viewer.golden_shot("scene")
    viewer.drop({"sign.obj": MODEL, "looks.mtl": LOOKS})
    report = viewer.wait(lambda r: r["scene"] == "sign", "the model without its texture")
    print(f"a model without its texture: {report['message']}")
    assert "checks.png" in report["message"] and "drop" in report["message"], report
    viewer.drop({"scene.toml": WITH_MODEL, "sign.obj": MODEL})
    report = viewer.wait(lambda r: "texture" in (r["message"] or ""), "a message")
    print(f"a scene without its texture: {report['message']}")
    assert "scene.toml:" in report["message"] and "checks.png" in report["message"] and "provide it" in report["message"], report
    assert report["scene"] == "sign", "the present scene did not stay"
    viewer.drop({"a.obj": MODEL, "b.obj": MODEL, "looks.mtl": LOOKS, "checks.png": checks()})
    report = viewer.wait(lambda r: r["scene"] == "a", "one of two models")
    assert "2 scenes" in report["message"], report


def large_model(side):
    """A wavy field of 2 side^2 triangles, as a model."""
    row = range(side + 1)
    points = [f"v {x / 50} {0.3 * math.sin(x / 20) * math.cos(y / 30):.4f} {y / 50}" for y in row for x in row]
    faces = []
    for y in range(side):
        for x in range(side):
            a = y * (side + 1) + x + 1
            faces.append(f"f {a} {a + side + 1} {a + side + 2} {a + 1}")
    return "\n".join(points + faces)


def read_beside(viewer):
    """The page goes on drawing while a large model is read, and reading is called off."""
    # No lists of casters, which the CPU would make of so many triangles for a while.
    viewer.open("?scene=cubes&left=hard&right=pcf&split=left")
    large = large_model(500)
    viewer.drop({"field.obj": large})
    begin = time.time()
    viewer.wait(lambda r: r["reading"] == "field.obj", "reading")
    frames, seconds = viewer.frames_while(lambda r: r["reading"], 60)
    report = viewer.wait(lambda r: r["scene"] == "field", "the large model", 300)
    print(f"a model of {len(large) / 1e6:.0f} MB, {report['triangles']} triangles: shown after {time.time() - begin:.1f} s; "
          f"{frames} frames while it was read, in {seconds:.1f} s")
    assert frames >= LEAST_FRAMES, frames
    viewer.shot("field")
    viewer.open("?scene=cubes&left=hard&right=pcf&split=left")
    viewer.drop({"other.obj": large})
    viewer.wait(lambda r: r["reading"] == "other.obj", "reading")
    viewer.click("Button", "Cancel loading")
    viewer.wait(lambda r: r["reading"] is None, "the end of reading", 5)
    time.sleep(3)
    assert viewer.report()["scene"] == "cubes", "what was called off was shown"
    viewer.drop({"other.obj": large})
    viewer.wait(lambda r: r["reading"] == "other.obj", "reading")
    viewer.page.screenshot(path=viewer.out / "reads.png", timeout=120_000)


def choose_scene(viewer, name):
    """Chooses a built-in scene by keys."""
    viewer.key("F2")
    viewer.page.keyboard.type(name)
    viewer.page.keyboard.press("Enter")


def made_beside(viewer):
    """The page goes on drawing while a large built-in scene is made, which is called off by a newer choice and by Esc."""
    viewer.open("?scene=cubes&left=hard&right=pcf&split=left")
    begin = time.time()
    choose_scene(viewer, "forest")
    before = viewer.wait(lambda r: r["reading"] == "forest", "the begin of the forest")
    assert before["scene"] == "cubes", before
    # The key flies: each frame is another picture.
    viewer.page.keyboard.down("s")
    steps = set()

    def is_made(report):
        steps.add((report["loading"] or "").split(" (")[0])
        return report["reading"] and "go to the device" not in report["loading"]
    frames, seconds = viewer.frames_while(is_made, 60)
    camera = viewer.report()["camera"]
    viewer.page.keyboard.up("s")
    report = viewer.wait(lambda r: r["scene"] == "forest", "the forest", 300)
    print(f"the forest, {report['triangles']} triangles: shown after {time.time() - begin:.1f} s; {frames} frames while it was made, "
          f"in {seconds:.1f} s; it told {sorted(steps)}")
    assert camera != before["camera"], "the camera did not move"
    assert frames >= LEAST_FRAMES, frames
    assert any(word in step for step in steps for word in ["reading", "placing", "handed over"]), steps
    viewer.open("?scene=cubes&left=hard&right=pcf&split=left")
    choose_scene(viewer, "forest")
    viewer.wait(lambda r: r["reading"] == "forest", "the begin of the forest")
    viewer.page.screenshot(path=viewer.out / "makes.png", timeout=120_000)
    choose_scene(viewer, "fence")
    viewer.wait(lambda r: r["scene"] == "fence", "the newer choice")
    choose_scene(viewer, "forest")
    viewer.wait(lambda r: r["reading"] == "forest", "the begin of the forest")
    viewer.key("Escape")
    viewer.wait(lambda r: r["reading"] is None, "the end of loading", 5)
    time.sleep(4)
    report = viewer.report()
    assert report["scene"] == "fence" and report["message"] is None, report
    print("making a scene is called off by a newer choice, and by Esc")


def planned(viewer):
    """The page goes on drawing while the planner works in its worker."""
    viewer.open("?scene=cubes&left=hard&right=exact&split=left")
    viewer.measured()
    viewer.click("Button", "Find it")
    begin = time.time()
    before = viewer.wait(lambda r: r["planning"], "the begin of a plan")
    # The key flies: each frame is another picture.
    viewer.page.mouse.move(SIZE["width"] - 200, SIZE["height"] - 60)
    viewer.page.keyboard.down("s")
    frames, seconds = viewer.frames_while(lambda r: r["planning"], 30)
    after = viewer.report()
    viewer.page.keyboard.up("s")
    viewer.page.screenshot(path=viewer.out / "plans.png", timeout=120_000)
    print(f"from where the planner {before['planning']}: {frames} frames in {seconds:.1f} s")
    assert after["handles"] != before["handles"], "the camera did not move"
    assert frames >= LEAST_FRAMES, frames
    report = viewer.wait(lambda r: r["plan"] is not None or r["message"], "a plan", 400)
    assert report["planning"] is None and report["message"] is None, report
    print(f"the least for this view: {report['plan']}, after {time.time() - begin:.0f} s")
    viewer.shot("planned")
    viewer.click("Button", "Show it on the left")
    name = report["plan"].split(" ")[0]
    viewer.wait(lambda r: r["sides"][0]["technique"] == name, "the plan on the left")
    # Truth under a wide light takes long: its plan is not there before the button has been found.
    viewer.open("?scene=street-soft&left=hard&right=pcf&split=left")
    viewer.wait(lambda r: r["scene"] == "street-soft", "the scene")
    viewer.click("Button", "Find it")
    viewer.wait(lambda r: r["planning"], "another plan")
    viewer.click("Button", "Cancel")
    report = viewer.wait(lambda r: r["planning"] is None, "the end of the plan", 5)
    assert report["message"] is None, report
    print("a plan is called off")


def handed(viewer):
    """The least for a model of one's own, copied: kept as `copied.preset.toml`, which ../try.py hands to the example `forward`."""
    viewer.page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    # No plan is what is on the right: the copy of the wrong side would be found out.
    viewer.open("?scene=cubes&left=hard&right=midpoint&split=left")
    viewer.drop({"hills.obj": large_model(40)})
    viewer.wait(lambda r: r["scene"] == "hills", "the dropped model")
    viewer.click("Button", "Find it")
    report = viewer.wait(lambda r: r["plan"] is not None or r["message"], "a plan", 400)
    assert report["message"] is None, report
    print(f"the least for a dropped model: {report['plan']}")
    viewer.click("Button", "Show it on the left")
    technique = report["plan"].split(" ")[0]
    viewer.wait(lambda r: r["sides"][0]["technique"] == technique, "the plan on the left")
    # Both buttons have to be told of for the upper one to be the left side's.
    viewer.page.mouse.move(100, SIZE["height"] / 2)
    for _ in range(40):
        if len([w for w in viewer.widgets() if w["label"] == "Copy preset"]) == 2:
            break
        viewer.page.mouse.wheel(0, -150)
        time.sleep(0.5)
    viewer.click("Button", "Copy preset")
    viewer.wait(lambda r: "clipboard" in (r["message"] or ""), "the preset in the clipboard")
    copied = viewer.page.evaluate("navigator.clipboard.readText()")
    assert f'technique = "{technique}"' in copied, (technique, copied)
    (viewer.out / "copied.preset.toml").write_text(copied)
    viewer.shot("handed")


def broken_workers(viewer):
    """Workers that can't start, panic, or run out of memory: each becomes a message, and the page goes on."""
    script = (ROOT / "examples/viewer/web/worker.js").read_text()
    call = "umbrage_work(job, parts);"
    assert call in script
    for what, instead, words in [
        ("can't be loaded", None, "worker.js can't be loaded"),
        ("panics", script.replace(call, "umbrage_work('panic', parts);"), "a test requested a panic"),
        ("runs out of memory", script.replace(call, "umbrage_work('memory', parts);"), "no memory is left"),
        ("is asked for something else", script.replace(call, "umbrage_work('dance', parts);"), "`dance`"),
    ]:
        Server.instead.clear()
        viewer.open("?scene=cubes&left=hard&right=exact&split=left")
        Server.instead["/worker.js"] = instead
        viewer.click("Button", "Find it")
        report = viewer.wait(lambda r: r["message"], "a message")
        print(f"a worker that {what}: {report['message']}")
        assert words in report["message"] and report["planning"] is None, report
        viewer.drop({"ball.toml": BALL})
        report = viewer.wait(lambda r: "ball.toml" in (r["message"] or ""), "a message")
        assert words in report["message"] and report["reading"] is None and report["scene"] == "cubes", report
        choose_scene(viewer, "fence")
        if instead is None:
            report = viewer.wait(lambda r: r["scene"] == "fence", "a scene that is made without a worker")
            assert report["message"] is None, report
        else:
            report = viewer.wait(lambda r: "fence:" in (r["message"] or ""), "a message")
            assert words in report["message"] and report["reading"] is None and report["scene"] == "cubes", report
        assert viewer.page.locator("#status").is_hidden(), "the page says that it stopped"
    Server.instead.clear()
    # A browser that knows no workers.
    viewer.open("?scene=cubes&left=hard&right=exact&split=left")
    viewer.page.evaluate("() => { window.Worker = class { constructor() { throw new Error('no workers here'); } }; }")
    viewer.click("Button", "Find it")
    report = viewer.wait(lambda r: r["message"], "a message")
    print(f"a browser without workers: {report['message']}")
    assert "can't start a worker (no workers here)" in report["message"], report
    choose_scene(viewer, "fence")
    viewer.wait(lambda r: r["scene"] == "fence", "a scene that is made without a worker")
    viewer.shot("without-workers")
    viewer.told.clear()


def narrow(viewer):
    """On a telephone the panel is folded at first; a button unfolds it."""
    viewer.page.set_viewport_size(NARROW)
    try:
        viewer.open("?scene=cubes&left=hard&right=exact&split=0.5")
        viewer.measured()
        left, top, right, bottom = viewer.find("Button", UNFOLD)
        assert min(left, top) >= 0 and right <= NARROW["width"] and bottom - top >= 40, (left, top, right, bottom)
        image = viewer.shot("narrow")
        right_of_it = image.crop((NARROW["width"] // 2, 300, NARROW["width"], 700))
        left_of_it = image.crop((0, 300, NARROW["width"] // 2, 700))
        assert min(spread(right_of_it), spread(left_of_it)) > 5, "the picture is covered"
        viewer.click("Button", UNFOLD)
        viewer.find("Button", "Failures")
        viewer.shot("narrow-unfolded")
        viewer.click("Button", "Fold")
        viewer.find("Button", UNFOLD)
        viewer.key("F1")
        viewer.shot("narrow-keys")
        viewer.key("Escape")
    finally:
        viewer.page.set_viewport_size(SIZE)
    viewer.open("?scene=cubes&left=hard&right=exact&split=0.5")
    assert not [w for w in viewer.widgets() if w["label"] == UNFOLD], "the panel is folded in a wide window"
    print(f"in a window {NARROW['width']} pixels wide the panel is folded at first, and the button unfolds it")


def moving(viewer):
    """A place of failure that moves plays its path, and its button pauses it."""
    viewer.open("?failure=hills-pan")
    begin = viewer.wait(lambda r: r["path"] and r["path"]["playing"], "the path")
    viewer.wait(lambda r: r["camera"] != begin["camera"] and r["path"]["step"] != begin["path"]["step"], "the next step")
    viewer.click("Button", "Pause")
    paused = viewer.wait(lambda r: not r["path"]["playing"], "the pause")
    viewer.measured()
    assert viewer.report()["camera"] == paused["camera"], "it moves while it is paused"
    viewer.shot("hills-pan")
    print(f"hills-pan plays, and is paused at step {paused['path']['step']}")


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


def first(viewer):
    started(viewer)
    measured(viewer)
    agreed(viewer)
    heat_map(viewer)


PARTS = {
    "first": first, "dragged": dragged, "masks": masks, "switched": switched, "dropped": dropped, "together": dropped_together, "large": read_beside,
    "made": made_beside, "plan": planned, "broken": broken_workers, "moving": moving,
    "narrow": narrow, "others": others, "handed": handed,
}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--page", default=ROOT / "target/web", type=pathlib.Path)
    parser.add_argument("--browser", default="/usr/bin/chromium")
    parser.add_argument("--out", default=ROOT / "target/web-tried", type=pathlib.Path)
    parser.add_argument("--bless", action="store_true", help="makes the golden pictures anew")
    parser.add_argument("--only", nargs="+", choices=PARTS, metavar="PART", help=f"plays these parts alone: {', '.join(PARTS)}")
    options = parser.parse_args()
    if not options.bless:
        compared.test()
    assert (options.page / "index.html").is_file(), f"there is no page in {options.page}: run `cargo xtask web --no-serve`"
    options.out.mkdir(parents=True, exist_ok=True)
    handler = functools.partial(Server, directory=options.page)
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    address = f"http://localhost:{server.server_address[1]}/"
    with sync_playwright() as playwright:
        without_webgpu(playwright, options.browser, address, options.out)
        browser = playwright.chromium.launch(
            executable_path=options.browser, headless=False, args=["--headless=new", *WEBGPU])
        golden = compared.Goldens(compared.FOLDERS[1], options.bless, options.out)
        viewer = Viewer(browser, address, options.out, golden)
        for part in options.only or PARTS:
            PARTS[part](viewer)
            faults = [line for line in viewer.told if line.startswith("error")]
            assert not faults, faults
        if not options.only:
            golden.end()
        browser.close()
    print(f"all well; screenshots are in {options.out}")


if __name__ == "__main__":
    main()
