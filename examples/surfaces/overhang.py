"""EnergyPlus's question: the sunlit share of a box's south wall below an overhang, against its closed form."""

import matplotlib.pyplot as plt
import numpy as np
import umbrage_surfaces as us
from shapes import box, grid, join, save

W, H, D = 8.0, 2.7, 1.0  # wall: width and height; depth of the overhang at its top, as wide as the wall
wall = grid([0, 0, 0], [W, 0, 0], [0, 0, H], 4, 3)
overhang = grid([0, -D, H], [W, 0, 0], [0, D, 0], 1, 1)
facets = us.Facets(*join(wall, overhang, box(0, 0.01, 0, W, 6, H)), unit="m")
heights = np.linspace(2, 78, 39)
azimuths = np.array([120.0, 150.0, 180.0])
errors = []
figure, axes = plt.subplots()
for azimuth in azimuths:
    suns = us.directions(np.full(39, azimuth), heights)
    answer = facets.lit_area(suns)
    lit = answer.area_m2[:, : len(wall[1])].sum(axis=1)
    # Closed form: the overhang's shadow is a parallelogram, moved sideways and down along the wall.
    sideways, down = abs(suns[:, 0] / -suns[:, 1]) * D, suns[:, 2] / -suns[:, 1] * D
    depth = np.minimum(down, H)
    at_depth = sideways * depth / down  # the slanted side's shift where the shadow leaves the wall
    shadow = np.where(at_depth < W, depth * (W - at_depth / 2), W * W / sideways * down / 2)
    errors.append(abs(lit - (W * H - shadow)).max())
    axes.plot(heights, lit / (W * H), label=f"azimuth {azimuth:.0f}")
print(f"greatest error against the closed form: {max(errors):.1e} m2 of {W * H} m2; stated: {answer.stated}")
axes.set(xlabel="height of the sun, degrees", ylabel="lit share", title="South wall below an overhang of 1 m")
axes.legend()
save(figure, "overhang.png")
