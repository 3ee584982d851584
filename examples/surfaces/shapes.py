"""Meshes and images for the examples: (vertices, triangles) pairs."""

import matplotlib
import numpy as np
from PIL import Image

matplotlib.use("Agg")
SIDES = [(0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]


def box(x, y, z, a, b, c):
    """A closed box from (x, y, z) with the sides a, b, c."""
    v = [(x + i * a, y + j * b, z + k * c) for k in (0, 1) for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))]
    return np.array(v, float), np.array([t for q in SIDES for t in (q[:3], (q[0], q[2], q[3]))], np.uint32)


def grid(corner, u, v, m, n):
    """A parallelogram of m x n squares, facing along u x v."""
    i, j = np.meshgrid(np.arange(m + 1), np.arange(n + 1), indexing="ij")
    points = corner + i[..., None] * np.array(u) / m + j[..., None] * np.array(v) / n
    a = (np.arange(m)[:, None] * (n + 1) + np.arange(n)).ravel()
    b, c, d = a + n + 1, a + n + 2, a + 1
    return points.reshape(-1, 3), np.concatenate([np.c_[a, b, c], np.c_[a, c, d]]).astype(np.uint32)


def join(*meshes):
    """One mesh of several."""
    first = np.cumsum([0] + [len(m[0]) for m in meshes[:-1]])
    return np.concatenate([m[0] for m in meshes]), np.concatenate([m[1] + np.uint32(f) for m, f in zip(meshes, first)])


def ball(radius, bumps, n=40):
    """A closed ball of 12 n² triangles with bumps, which are a share of the radius."""
    v, t = grid([-1, -1, 1], [2, 0, 0], [0, 2, 0], n, n)
    turned = [v, v[:, [1, 2, 0]], v[:, [2, 0, 1]]]
    v, t = join(*[(p, t) for p in turned], *[(-p, t[:, ::-1]) for p in turned])
    v /= np.linalg.norm(v, axis=1)[:, None]
    v *= radius * (1 + bumps * np.sin(7 * v[:, :1]) * np.cos(5 * v[:, 1:2]))
    return np.round(v, 6), t  # the sides' common edges agree in all bits


def save(figure, name):
    """Writes a small image with a palette next to this file."""
    figure.set_size_inches(6, 3.6)
    figure.tight_layout()
    figure.canvas.draw()
    image = Image.fromarray(np.asarray(figure.canvas.buffer_rgba())[..., :3])
    image.quantize(48).save(__file__.replace("shapes.py", name), optimize=True)
