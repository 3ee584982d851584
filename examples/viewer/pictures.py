#!/usr/bin/env python3
"""Compares screenshots of the viewer's window and page with each other and with the reduced ones in folders `goldens`.

    python3 examples/viewer/pictures.py     # tests the comparison itself: altered pictures must fail
    python3 examples/viewer/try.py --bless  # overwrites the goldens of the window; web/try.py --bless those of the page

Pictures are kept at a quarter of their width and height, so that each of their pixels is the mean of 16.

Tolerance, in levels of 255. What may differ without a fault:
* devices round otherwise: single pixels along shadows' edges flip. In a block of 8x8 small pixels (32x32 of the window) an edge has about 32
  pixels; if all of them flip by 150 levels, the block's mean moves by 5;
* colours round otherwise: half a level each.
So a block's mean may be off by up to 6 levels, and the whole picture's by up to 1.
"""

import io
import pathlib
import sys

from PIL import Image, ImageChops, ImageStat

VIEWER = pathlib.Path(__file__).resolve().parent
# Those of the window, and of the page.
FOLDERS = [VIEWER / "goldens", VIEWER / "web/goldens"]
SHRINK = 4
BLOCK = 8
OF_BLOCK, OF_ALL = 6.0, 1.0
# Of all goldens together, bytes: they are part of the repository.
MOST_BYTES = 300_000


def spread(image):
    """Returns the standard deviation of an image's levels (0 to 255): 0 if it is blank."""
    return sum(ImageStat.Stat(image).stddev) / 3


def difference(a, b):
    """Returns the mean absolute difference of two images (0 to 255)."""
    return sum(ImageStat.Stat(ImageChops.difference(a, b)).mean) / 3


def halves(image):
    """Returns the parts left and right of the divider, without the divider."""
    middle = image.width // 2
    return image.crop((0, 0, middle - 20, image.height)), image.crop((middle + 20, 0, image.width, image.height))


def small(image):
    """Returns a region reduced to the size of its golden."""
    return image.convert("RGB").reduce(SHRINK)


def fault(kept, seen):
    """Describes how a picture differs from its golden, or returns None."""
    if kept.size != seen.size:
        return f"it has {seen.size} pixels, the kept one {kept.size}"
    whole = max(abs(a - b) for a, b in zip(ImageStat.Stat(kept).mean, ImageStat.Stat(seen).mean))
    if whole > OF_ALL:
        return f"its mean colour is off by {whole:.1f} levels, {OF_ALL} are allowed"
    for top in range(0, kept.height, BLOCK):
        for left in range(0, kept.width, BLOCK):
            block = (left, top, min(left + BLOCK, kept.width), min(top + BLOCK, kept.height))
            means = [ImageStat.Stat(image.crop(block)).mean for image in (kept, seen)]
            off = max(abs(a - b) for a, b in zip(*means))
            if off > OF_BLOCK:
                place = (SHRINK * left, SHRINK * top)
                return f"32x32 pixels at {place} of its region are off by {off:.1f} levels, {OF_BLOCK} are allowed"
    return None


class Goldens:
    """Compares pictures with goldens, or overwrites the goldens."""

    def __init__(self, folder, blesses, out):
        self.folder = folder
        self.blesses = blesses
        self.out = out
        self.seen = set()

    def check(self, name, image):
        file = self.folder / f"{name}.png"
        seen = small(image)
        self.seen.add(file)
        if self.blesses:
            seen.save(file, optimize=True)
            print(f"golden written: {name}, {file.stat().st_size} bytes")
            return
        assert file.exists(), f"there is no {file}; if the picture is right, keep it with --bless"
        wrong = fault(Image.open(file).convert("RGB"), seen)
        if wrong:
            seen.save(self.out / f"{name}-seen.png")
        assert wrong is None, f"the picture `{name}` is not as {file}: {wrong}. See {self.out / name}-seen.png; if that is right, keep it with --bless"
        print(f"matches the golden: {name}")

    def end(self):
        """Fails on unused goldens, or deletes them when blessing."""
        idle = set(self.folder.glob("*.png")) - self.seen
        if self.blesses:
            for file in idle:
                file.unlink()
        else:
            assert not idle, f"nothing was compared with {sorted(map(str, idle))}"
        bytes_of_all = sum(file.stat().st_size for file in self.seen)
        assert bytes_of_all < MOST_BYTES, f"the goldens have {bytes_of_all} bytes; keep smaller regions"


def spoilt(image):
    """Yields altered pictures with a visible fault, each with its name."""
    width, height = image.size
    yield "moved by 8 pixels of the window", ImageChops.offset(image, 2, 0)
    # Away from the end of the scale that is nearer: there is nothing lighter than white.
    step = 2 if sum(ImageStat.Stat(image).mean) < 3 * 128 else -2
    yield "2 levels lighter or darker", image.point(lambda level: max(0, min(level + step, 255)))
    with_patch = image.copy()
    patch = (width // 2, height // 2, width // 2 + BLOCK, height // 2 + BLOCK)
    middle = ImageStat.Stat(image.crop(patch)).mean
    with_patch.paste(tuple(int(level + 40 if level < 128 else level - 40) for level in middle), patch)
    yield "with a spot of 32x32 pixels", with_patch
    yield "blank", Image.new("RGB", image.size, tuple(map(int, ImageStat.Stat(image).mean)))
    yield "upside down", image.transpose(Image.Transpose.FLIP_TOP_BOTTOM)
    yield "cut", image.crop((0, 0, width - 1, height))


def test():
    """The comparison accepts a picture and its JPEG copy, and rejects altered ones."""
    files = sorted(file for folder in FOLDERS for file in folder.glob("*.png"))
    assert files, f"there are no goldens in {FOLDERS}"
    for file in files:
        kept = Image.open(file).convert("RGB")
        packed = io.BytesIO()
        kept.save(packed, "JPEG", quality=97, subsampling=0)
        for same in (kept, Image.open(packed).convert("RGB")):
            wrong = fault(kept, same)
            assert wrong is None, f"{file.name} is not taken for itself: {wrong}"
        for what, image in spoilt(kept):
            assert fault(kept, image), f"{file.name} {what} passes: the comparison sees too little"
    print(f"the comparison finds all faults in {len(files)} goldens")


if __name__ == "__main__":
    sys.exit(test())
