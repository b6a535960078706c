"""Writes `srgb.csv`: how much of a white light the three primaries of sRGB have, at each wavelength.

The method is that of I. Mallett and C. Yuksel 2019, "Spectral primary decomposition for rendering with sRGB
reflectance" (Eurographics Symposium on Rendering): the smoothest three spectra that are nowhere negative, add up to 1,
and have the colours of the primaries under D65. The spectra are solved here, for the table's linear interpolation.

    pip install colour-science==0.4.7 cvxpy==1.9.3
    python3 make.py
"""

from pathlib import Path

import colour
import cvxpy
import numpy as np

FIRST, LAST, STEP = 380, 780, 5
# IEC 61966-2-1, XYZ to linear sRGB
TO_RGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])


def weights():
    """What a node of the table adds to X, Y, Z of a white of Y = 1: an array of 3 rows."""
    nm = np.arange(FIRST, LAST + 1)
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    observer = np.array([observer[n] for n in nm])
    power = colour.SDS_ILLUMINANTS["D65"]
    light = observer * np.interp(nm, power.wavelengths, power.values)[:, None]
    light[[0, -1]] *= 0.5
    light /= light[:, 1].sum()
    nodes = np.arange(FIRST, LAST + 1, STEP)
    tents = np.maximum(0.0, 1.0 - np.abs(nm[None, :] - nodes[:, None]) / STEP)
    return nodes, (tents @ light).T


def primaries():
    nodes, light = weights()
    shares = cvxpy.Variable((3, len(nodes)))
    colours = TO_RGB @ light @ shares.T
    rules = [shares >= 0, cvxpy.sum(shares, axis=0) == 1]
    # blue is what remains, so that the rounding of the matrix stays there
    rules += [colours[:, :2] == np.eye(3)[:, :2]]
    bends = cvxpy.sum_squares(cvxpy.diff(shares, axis=1))
    cvxpy.Problem(cvxpy.Minimize(bends), rules).solve(solver=cvxpy.CLARABEL)
    found = np.clip(shares.value, 0.0, 1.0)
    print("RGB of the three, column by column:")
    print(TO_RGB @ light @ found.T)
    return nodes, found


def main():
    nodes, shares = primaries()
    lines = [
        "# Shares of the primaries of sRGB in a white light. They add up to 1.",
        "# Method: I. Mallett and C. Yuksel 2019, Eurographics Symposium on Rendering. Written by make.py.",
        "wavelength_nm,red,green,blue",
    ]
    for nm, (red, green, _) in zip(nodes, shares.T):
        red, green = round(red, 6), round(green, 6)
        lines.append(f"{nm},{red:.6f},{green:.6f},{abs(1.0 - red - green):.6f}")
    Path(__file__).with_name("srgb.csv").write_text("\n".join(lines) + "\n")


main()
