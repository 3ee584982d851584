"""Lit share of a binary asteroid as the Sun sees it: the primary eclipses its moon, and the moon the primary."""

import matplotlib.pyplot as plt
import numpy as np
import umbrage_surfaces as us
from shapes import ball, join, save

primary, moon = ball(400.0, 0.1), ball(85.0, 0.05)
shares, angles = [], np.linspace(0, 360, 73)
for angle in np.radians(angles):
    place = 1180 * np.array([np.cos(angle), np.sin(angle), 0])  # orbit of Dimorphos around Didymos, metres
    facets = us.Facets(*join(primary, (moon[0] + place, moon[1])), unit="m", sides="front", certify=True)
    answer = facets.lit_area(np.array([[1.0, 0.0, 0.05]]))
    n = len(primary[1])
    shares.append([answer.projected_m2[0, n:].sum(), answer.projected_m2[0, :n].sum()])
shares = np.array(shares) / np.max(shares, axis=0)
print(f"moon: {shares[:, 0].min():.4f} of its greatest lit area, primary: {shares[:, 1].min():.4f}; {answer.stated}")
figure, axes = plt.subplots()
axes.plot(angles, shares, label=["moon", "primary"])
axes.set(xlabel="moon's place, degrees from the Sun", ylabel="lit share of the greatest", title="Binary asteroid")
axes.legend()
save(figure, "asteroid.png")
