"""Do dwellings have two hours of sun on 21 March? The verdicts of coarser steps, against 1 minute bisected."""

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import pvlib
import umbrage_surfaces as us
from shapes import box, grid, join, save

rng = np.random.default_rng(1)
places = [(x * 20, y * 17) for x in range(6) for y in range(6)]
blocks = [box(x, y, 0, 14, 10, h) for (x, y), h in zip(places, rng.uniform(9, 30, 36))]
front = grid([0, 43.99, 0], [14, 0, 0], [0, 0, 6], 28, 12)  # windows on south walls, half a metre apart
walls = [(front[0] + [x, y - 44, 0], front[1]) for x, y in places]
points = np.concatenate([v[t].mean(axis=1) for v, t in walls])
facets = us.Facets(*join(*blocks), unit="m")
times = pd.date_range("2026-03-21 05:00", "2026-03-21 20:00", freq="30s", tz="Europe/Berlin")
sun = pvlib.solarposition.get_solarposition(times, 48.1, 11.6)
seconds, suns = np.arange(len(times)) * 30.0, us.directions(sun.azimuth, sun.apparent_elevation)
hours = lambda step, bisect: facets.sun_hours(seconds, suns, points, step_s=step, bisect_s=bisect, refraction=True)
exact = hours(60, 1)
print(f"{len(points)} windows, two hours: {(exact.minutes >= 120).mean():.1%}; stated: {exact.stated}")
for minutes in (1, 5, 10, 15, 60):
    sampled = hours(60 * minutes, 60 * minutes).minutes
    off, flips = abs(sampled - exact.minutes), (sampled >= 120) != (exact.minutes >= 120)
    print(f"step {minutes:2} min: mean {off.mean():5.2f}, worst {off.max():5.1f} min, other verdicts {flips.mean():.2%}")
figure, axes = plt.subplots()
axes.hist(exact.minutes / 60, bins=48)
axes.set(xlabel="hours of sun on 21 March, 48.1 N", ylabel="windows", title="Sun of a housing estate's south walls")
save(figure, "housing.png")
