#!/usr/bin/env python3
"""Compares screenshots of the page with small pictures that were looked at: the files in `goldens/`.

    python3 examples/viewer/web/goldens.py          # shows that the comparison fails on spoilt pictures; takes a second

A golden picture is a screenshot of 960x540 pixels at a third of its width and height, black outside of the region that is compared. Pictures
are compared tile by tile, so that what is wrong in one place is not lost in the mean of all. `try.py --bless` makes them anew.
"""

import pathlib

from PIL import Image, ImageChops, ImageStat

FOLDER = pathlib.Path(__file__).resolve().parent / "goldens"
SCALE = 3
SIZE = (320, 180)
# Pixels of a small picture: 60 of the screenshot.
TILE = 20
# Greatest mean difference of a tile, in steps of 256. The same browser draws the same bits again, so 0 would do there. Other releases of its
# driver may round edges to the pixel beside: an edge between black and white across a whole tile that moves by one pixel of the
# screenshot changes a mean by 255 / 60 = 4.25. A shadow that is missing in a tenth of a tile changes it by more, at usual contrasts.
TOLERANCE = 4.25


def small(image, region):
    """The picture as golden ones are kept. The region is left, top, right and bottom in pixels of the screenshot."""
    assert image.size == tuple(side * SCALE for side in SIZE), image.size
    box = [round(edge / SCALE) for edge in region]
    out = Image.new("RGB", SIZE)
    out.paste(image.resize(SIZE, Image.Resampling.BOX).crop(box), box[:2])
    return out


def worst_tile(a, b):
    """The greatest mean difference of a tile, in steps of 256, and the tile's place."""
    difference = ImageChops.difference(a, b)
    worst = (0.0, (0, 0))
    for top in range(0, SIZE[1], TILE):
        for left in range(0, SIZE[0], TILE):
            tile = difference.crop((left, top, left + TILE, top + TILE))
            # Channels apart: a false colour may be right in two of three.
            worst = max(worst, (max(ImageStat.Stat(tile).mean), (left, top)))
    return worst


def fault(found, golden):
    """What is wrong with a picture, in words; nothing if it is as the golden one."""
    difference, (left, top) = worst_tile(found, golden)
    if difference <= TOLERANCE:
        return None
    return f"differs by {difference:.2f} steps of 256 (most {TOLERANCE}) in the tile at {left * SCALE}, {top * SCALE}"


class Goldens:
    def __init__(self, bless, out):
        self.bless, self.out = bless, out
        self.compared = []

    def check(self, name, image, region):
        found = small(image, region)
        path = FOLDER / f"{name}.png"
        if self.bless:
            found.save(path, optimize=True)
            print(f"golden picture {name}: made anew, {path.stat().st_size} bytes; look at it")
            self.compared.append(name)
            return
        assert path.is_file(), f"there is no golden picture {path}: look at {name} in {self.out}, and make it by --bless"
        golden = Image.open(path).convert("RGB")
        assert golden.size == SIZE, (name, golden.size)
        wrong = fault(found, golden)
        if wrong:
            found.save(self.out / f"{name}.found.png")
            raise AssertionError(f"the picture {name} {wrong}: compare {self.out / name}.found.png with {path}; "
                                 "if what is new is right, make the golden pictures anew by --bless")
        print(f"golden picture {name}: as it was, within {worst_tile(found, golden)[0]:.2f} steps of 256 in each tile")
        self.compared.append(name)

    def end(self):
        """Golden pictures that nothing was compared with are faults, too."""
        left = {path.stem for path in FOLDER.glob("*.png")} - set(self.compared)
        assert not left, f"nothing was compared with the golden pictures {sorted(left)}: remove them, or play what they belong to"


def spoilt(golden):
    """Spoilt copies of a picture, each of which must be refused."""
    box = golden.getbbox()
    middle = [(box[0] + box[2]) // 2, (box[1] + box[3]) // 2]
    patch = golden.crop((middle[0] - 6, middle[1] - 6, middle[0] + 6, middle[1] + 6))
    patched = golden.copy()
    patched.paste(patch.point(lambda value: (value + 128) % 256), (middle[0] - 6, middle[1] - 6))
    yield "a patch of 12x12", patched
    # By 6 pixels of the screenshot.
    yield "moved sideways", ImageChops.offset(golden, 2, 0)
    yield "darker by a tenth", golden.point(lambda value: round(0.9 * value))
    red, green, blue = golden.split()
    if ImageStat.Stat(ImageChops.difference(red, blue)).mean[0] > 1:
        yield "red for blue", Image.merge("RGB", (blue, green, red))
    yield "black", Image.new("RGB", SIZE)


def self_test():
    paths = sorted(FOLDER.glob("*.png"))
    assert paths, f"there are no golden pictures in {FOLDER}: make them by try.py --bless"
    pictures = {path.stem: Image.open(path).convert("RGB") for path in paths}
    count = 0
    for name, golden in pictures.items():
        assert fault(golden, golden) is None
        assert fault(golden.point(lambda value: min(value + 2, 255)), golden) is None, "two steps brighter is allowed"
        others = [(f"{other} for it", picture) for other, picture in pictures.items() if other != name]
        for what, picture in [*spoilt(golden), *others]:
            assert fault(picture, golden), f"{name}: the comparison does not see: {what}"
            count += 1
    print(f"the comparison refuses {count} spoilt pictures of {len(pictures)}")


if __name__ == "__main__":
    self_test()
