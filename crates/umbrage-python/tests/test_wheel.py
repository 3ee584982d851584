"""Compares the installed wheel with `umbrage-sun`: test_wheel.py PROGRAM."""

import pathlib, re, subprocess, sys, tempfile, threading

PART = """
import numpy as np, umbrage_surfaces as us, sys
us.set_threads(int(sys.argv[1]))
rng = np.random.default_rng(5)
v = np.round(rng.random((900, 3)) * 4 + np.repeat(rng.random((300, 3)) * 20, 3, axis=0), 6)
v += [691000.0, 5335000.0, 500.0]
t = np.arange(900, dtype=np.uint32).reshape(300, 3)
s = np.round(rng.standard_normal((5, 3)), 6)
f = us.Facets(v, t, unit="m", certify=True)
"""
HASH = PART + """
if len(sys.argv) > 2:
    lines = ["v %r %r %r" % tuple(p.tolist()) for p in v] + ["f %d %d %d" % tuple((q + 1).tolist()) for q in t]
    open(sys.argv[2] + "/m.obj", "w").write("\\n".join(lines) + "\\n")
    open(sys.argv[2] + "/s.txt", "w").write("\\n".join("%r %r %r" % tuple(p.tolist()) for p in s) + "\\n")
a, l = f.lit_area(s), f.lit(s)
h = f.sun_hours(np.array([0.0, 7200.0]), np.array([[1.0, 0.2, 0.3], [-1.0, 0.2, 0.6]]))
assert a.fraction.shape == (5, 300) and a.fraction.dtype == np.float64 and l.is_lit.shape == (5, 300)
assert a.centroid_m.shape == (5, 300, 3) and 0 <= a.fraction.min() and a.fraction.max() <= 1
assert h.minutes.shape == (300,) and abs(sum(b - a for a, b in h.spans_s[0]) / 60 - h.minutes[0]) < 1e-9
assert a.stated.identity < 1e-9 and "hash" in str(a.stated)
assert abs(a.area_m2 - a.fraction * f.areas_m2).max() < 1e-9
print("%016x %016x %016x" % (a.stated.hash, l.stated.hash, h.stated.hash))
"""


def python(code, *arguments):
    run = subprocess.run([sys.executable, "-c", code, *arguments], check=True, capture_output=True, text=True)
    return run.stdout.split()


def main(program):
    with tempfile.TemporaryDirectory() as folder:
        one, many = python(HASH, "1", folder), python(HASH, "16")
        assert one == many, (one, many)
        for kind, expected in (["--area"], one[0]), ([], one[1]):
            command = [program, f"{folder}/m.obj", "--unit", "m", "--suns", f"{folder}/s.txt", *kind]
            out = subprocess.run(command, check=True, capture_output=True, text=True).stdout
            found = re.search("hash ([0-9a-f]{16})", out).group(1)
            assert found == expected, (kind, found, expected)
    # The lock of the interpreter is free while areas are computed.
    scope = {}
    sys.argv = ["", "2"]
    exec(PART, scope)
    ticks, done = [], threading.Event()
    count = lambda: [ticks.append(1) for _ in iter(lambda: done.wait(0.001), True)]
    thread = threading.Thread(target=count)
    thread.start()
    scope["f"].lit_area(scope["np"].tile(scope["s"], (200, 1)))
    during = len(ticks)
    done.set()
    thread.join()
    assert during > 5, f"{during} turns of another thread while areas were computed"
    # Faults are errors with rows.
    us, np = scope["us"], scope["np"]
    for vertices, part in (np.full((3, 3), np.nan), "vertex 0"), (np.zeros((2, 3)), "facet 0"):
        try:
            us.Facets(vertices, np.array([[0, 1, 2]], dtype=np.uint32))
        except ValueError as error:
            assert part in str(error), error
        else:
            raise AssertionError("accepted")
    size = sum(p.stat().st_size for p in pathlib.Path(us.__file__).parent.glob("*") if p.is_file())
    print(f"the wheel gives the hashes of umbrage-sun, with 1 and 16 threads; installed: {size} bytes")


main(sys.argv[1])
