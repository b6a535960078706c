"""Rigorous efficiencies of eight gratings, and how far scalar theory is from them.

Solves Maxwell's equations by the boundary integral method of `gratinglab`
(BSD-3-Clause), writes `efficiencies.csv` and prints the checks and tables of
README.md. About three minutes on one core.

    pip install gratinglab==0.1.12 numpy==2.4.6
    python3 make.py
"""

from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

import numpy as np
from gratinglab.problem import Problem
from gratinglab.profiles import Blazed, Lamellar, Sinusoidal
from gratinglab.solvers.integral._boundary import physical_boundary
from gratinglab.solvers.integral._core import solve_transverse
from gratinglab.solvers.integral._finite import solve_finite_states
from gratinglab.solvers.integral._nystrom import OperatorAssembler

VERSIONS = {"gratinglab": "0.1.12", "numpy": "2.4.6"}
CONSTANTS = Path(__file__).parent.parent / "src" / "optics" / "constants"
ANGLES = (0.0, 30.0, 60.0)  # incidence in air, degrees
WAVELENGTHS = (450.0, 550.0, 650.0)  # in vacuum, nm
POLARISATIONS = ("TE", "TM")  # E along the grooves, H along the grooves

# Points on one period of the surface: of the table, and of the convergence check.
POINTS, COARSE = 800, 400
# Kress's grading of the points towards edges; 0 on a surface without edges.
GRADING = 4
# Orders below these are left out: of the differences, and of the ratios.
WEAK, STRONG = 0.01, 0.1
# The energy balance may err by this; an order at grazing exit would break it.
BALANCE = 1e-4

# No light enters a medium whose index is imaginary: it reflects all, as a perfect conductor.
PERFECT = 1e6j


class Grating(NamedTuple):
    name: str
    profile: str
    period: float  # µm
    height: float  # µm, peak to valley
    duty: float | None  # the raised share of a lamellar period
    metal: str
    cover: str | float  # a file of constants or an index; 1 is air


GRATINGS = (
    Grating("holographic shallow", "sinusoidal", 2.5, 0.1, None, "aluminium", 1.0),
    Grating("holographic deep", "sinusoidal", 1.0, 0.25, None, "aluminium", 1.0),
    Grating("blazed", "blazed", 2.5, 0.25, None, "aluminium", 1.0),
    Grating("CD", "lamellar", 1.6, 0.12, 0.35, "aluminium", "polycarbonate"),
    Grating("DVD", "lamellar", 0.74, 0.105, 0.35, "aluminium", "polycarbonate"),
    Grating("covered relief", "sinusoidal", 1.6, 0.005, None, "aluminium", 1.58),
    Grating("covered relief perfect", "sinusoidal", 1.6, 0.005, None, "perfect", 1.58),
    Grating("fine and deep", "sinusoidal", 0.625, 0.3, None, "aluminium", 1.0),
)


def constants(medium, nm):
    """n + ik of a file of constants, linear in wavelength between its nodes."""
    lines = (CONSTANTS / f"{medium}.csv").read_text(encoding="utf-8").splitlines()
    rows = np.array([[float(x) for x in line.split(",")] for line in lines if line[0].isdigit()])
    return complex(np.interp(nm, rows[:, 0], rows[:, 1]), np.interp(nm, rows[:, 0], rows[:, 2]))


def cover_index(grating, nm):
    return grating.cover if isinstance(grating.cover, float) else constants(grating.cover, nm).real


def metal_index(grating, nm):
    return PERFECT if grating.metal == "perfect" else constants(grating.metal, nm)


def shape(grating):
    if grating.profile == "sinusoidal":
        return Sinusoidal(depth_fraction=grating.height / grating.period)
    if grating.profile == "blazed":
        return Blazed(blaze_angle=float(np.degrees(np.arctan(grating.height / grating.period))))
    return Lamellar(depth_fraction=grating.height / grating.period, duty_cycle=grating.duty)


class Solver:
    """The integral method on one grating, with `points` points per period.

    Maxwell's equations below a cover of index n are those in air with the
    wavelength, the metal's index and the sine of incidence divided by n.
    """

    def __init__(self, grating, points):
        self.grating = grating
        self.period = 1000.0 * grating.period
        problem = Problem(period=self.period, profile=shape(grating))
        self.boundary = physical_boundary(problem, points, grading=0 if grating.profile == "sinusoidal" else GRADING)
        self.terms = points // 2
        self.assembler = OperatorAssembler(self.boundary, period=self.period, terms=self.terms)

    def solve(self, degrees, nm, metal=None):
        """For TE and TM: {order: efficiency} of every order in the cover, and absorption.

        The solver's light comes from +x and its order m leaves at
        -sin θi + m λ/d. Ours leaves at -sin θi - m λ/d, hence the sign.
        """
        cover = cover_index(self.grating, nm)
        metal = metal_index(self.grating, nm) if metal is None else metal
        self.assembler.clear()
        common = dict(
            wavelength=nm / cover,
            period=self.period,
            sin_alpha=np.sin(np.radians(degrees)) / cover,
            terms=self.terms,
            assembler=self.assembler,
        )
        if metal == PERFECT:
            solved = [solve_transverse(self.boundary, polarization=p, **common) for p in POLARISATIONS]
            absorbed = [0.0, 0.0]
        else:
            states = [(1.0, 0.0), (0.0, 1.0)]
            solved = solve_finite_states(self.boundary, index=metal / cover, incidents=states, **common)
            absorbed = [s.absorption for s in solved]
        orders = [dict(zip((-s.orders).tolist(), s.efficiencies.tolist())) for s in solved]
        return list(zip(orders, absorbed))


def outgoing_sine(grating, degrees, nm, order):
    """sin θr in air of an order, on the axis of sin θi."""
    return -np.sin(np.radians(degrees)) - order * nm / (1000.0 * grating.period)


def fourier(grating, order, z):
    """|c_m(z)|² of physics.md's closed forms, z in rad/µm."""
    psi = z * grating.height
    if grating.profile == "sinusoidal":
        t = (np.arange(4096) + 0.5) / 4096.0
        return abs(np.mean(np.exp(0.5j * psi * np.cos(2 * np.pi * t) + 2j * np.pi * order * t))) ** 2
    if grating.profile == "blazed":
        return np.sinc(psi / (2 * np.pi) + order) ** 2
    if order == 0:
        return abs(1 - grating.duty + grating.duty * np.exp(1j * psi)) ** 2
    return 4 * np.sin(psi / 2) ** 2 * (np.sin(np.pi * order * grating.duty) / (np.pi * order)) ** 2


def fresnel(index, cosine):
    """Rs and Rp of a medium of complex index relative to the one above."""
    inside = np.sqrt(index**2 - 1 + cosine**2 + 0j)
    rs = (cosine - inside) / (cosine + inside)
    rp = (index**2 * cosine - inside) / (index**2 * cosine + inside)
    return abs(rs) ** 2, abs(rp) ** 2


def scalar(grating, degrees, nm, order, polarisation, obliquity, phase="inside"):
    """Our model: η = R O |c_m(k n w')|², directions inside the cover, S = 1."""
    n = cover_index(grating, nm)
    k = 2000.0 * np.pi / nm  # rad/µm
    sines = np.array([np.sin(np.radians(degrees)), outgoing_sine(grating, degrees, nm, order)])
    si, sr = sines / n
    ci, cr = np.sqrt(1 - si**2), np.sqrt(1 - sr**2)
    w, u = -(ci + cr), -(si + sr)
    half = np.sqrt(u**2 + w**2) / 2
    if grating.metal == "perfect":
        reflectance = 1.0
    else:
        reflectance = fresnel(metal_index(grating, nm) / n, half)[POLARISATIONS.index(polarisation)]
    if obliquity == "stam":
        o = (1 + si * sr + ci * cr) ** 2 / (ci * cr * w**2)
    elif polarisation == "TE":
        o = 4 * ci * cr / w**2
    else:
        o = 4 * (1 + si * sr) ** 2 / (ci * cr * w**2)
    z = k * n * w if phase == "inside" else -k * np.sqrt(1 - sines**2).sum()
    return reflectance * o * fourier(grating, order, z)


def table():
    """All rows, with the worst energy balance and the worst change on doubling the points."""
    rows, balance, change = [], {}, {}
    for g in GRATINGS:
        fine, coarse = Solver(g, POINTS), Solver(g, COARSE)
        balance[g.name], change[g.name] = [0.0, 0.0], [0.0, 0.0]
        for degrees in ANGLES:
            for nm in WAVELENGTHS:
                solved, rough = fine.solve(degrees, nm), coarse.solve(degrees, nm)
                for p, polarisation in enumerate(POLARISATIONS):
                    orders, absorbed = solved[p]
                    error = abs(sum(orders.values()) + absorbed - 1)
                    balance[g.name][p] = max(balance[g.name][p], error)
                    step = max(abs(orders[m] - rough[p][0][m]) for m in orders)
                    change[g.name][p] = max(change[g.name][p], step)
                    for m in sorted(orders):
                        if abs(outgoing_sine(g, degrees, nm, m)) < 1:
                            rows.append((g, degrees, nm, polarisation, m, orders[m]))
        print(f"{g.name}: solved", flush=True)
    return rows, balance, change


def write(rows):
    head = "grating,profile,period_um,height_um,duty,metal,n,k,cover_index,theta_i_deg,polarisation,wavelength_nm,order,theta_r_deg,efficiency"
    lines = [head]
    for g, degrees, nm, polarisation, m, efficiency in rows:
        index = metal_index(g, nm)
        theta = np.degrees(np.arcsin(outgoing_sine(g, degrees, nm, m))) + 0.0  # no -0
        duty = "" if g.duty is None else f"{g.duty:g}"
        lines.append(
            f"{g.name},{g.profile},{g.period:g},{g.height:g},{duty},{g.metal},{index.real:.6g},{index.imag:.6g},"
            f"{cover_index(g, nm):.6g},{degrees:g},{polarisation},{nm:g},{m},{theta:.5f},{efficiency:.4e}"
        )
    (Path(__file__).parent / "efficiencies.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")


def small_relief():
    """A perfect conductor with 1 nm of relief against first-order perturbation theory."""
    g = Grating("", "sinusoidal", 1.6, 0.001, None, "perfect", 1.0)
    solver, worst = Solver(g, COARSE), 0.0
    for degrees in ANGLES:
        for p, (orders, _) in enumerate(solver.solve(degrees, 550.0)):
            for m in (-1, 1):
                if m in orders:
                    si, sr = np.sin(np.radians(degrees)), outgoing_sine(g, degrees, 550.0, m)
                    ci, cr = np.sqrt(1 - si**2), np.sqrt(1 - sr**2)
                    kh = 2 * np.pi / 0.55 * g.height / 4
                    theory = 4 * kh**2 * (ci * cr if p == 0 else (1 + si * sr) ** 2 / (ci * cr))
                    worst = max(worst, abs(orders[m] / theory - 1))
    print(f"perfect conductor, 1 nm of relief, first orders over perturbation theory: 1 ± {worst:.1e}")


def flat_mirror():
    """A relief of 1e-6 nm of aluminium against Fresnel's formulas."""
    g, worst = Grating("", "sinusoidal", 1.6, 1e-9, None, "aluminium", 1.58), 0.0
    solver = Solver(g, COARSE)
    for degrees in ANGLES:
        cosine = np.sqrt(1 - (np.sin(np.radians(degrees)) / 1.58) ** 2)
        expected = fresnel(metal_index(g, 550.0) / 1.58, cosine)
        for (orders, _), r in zip(solver.solve(degrees, 550.0), expected):
            worst = max(worst, abs(orders[0] - r))
    print(f"flat aluminium under 1.58 against Fresnel: {worst:.1e}")


def known_lamellar():
    """The example of physics.md: a perfect conductor, 20 degrees, 550 nm, order 0."""
    g = Grating("", "lamellar", 2.0, 0.1, 0.5, "perfect", 1.0)
    te, tm = (orders[0] for orders, _ in Solver(g, POINTS).solve(20.0, 550.0))
    print(f"lamellar, 2 µm, 0.1 µm deep: TE {te:.3f}, TM {tm:.3f}, scalar {scalar(g, 20.0, 550.0, 0, 'TE', 'stam'):.3f}")


def pairs(rows, grating, light, obliquity):
    """(rigorous, scalar) of every order of a grating, for TE, TM or unpolarised light."""
    orders = {}
    for g, *direction, polarisation, m, efficiency in rows:
        if g == grating:
            model = scalar(g, *direction, m, polarisation, obliquity)
            orders.setdefault((*direction, m), {})[polarisation] = np.array([efficiency, model])
    return [(p["TE"] + p["TM"]) / 2 if light == "both" else p[light] for p in orders.values()]


def compare(rows):
    """How far the model is from the rigorous values, with Stam's obliquity and with those of TE and TM."""
    print(f"\nRatios are rigorous over scalar, where both are above {STRONG:g}\n")
    print("| grating | light | orders | Stam worst | mean | TE/TM worst | mean | ratio, Stam | ratio, TE/TM |")
    print("| --- " * 9 + "|")
    for g in GRATINGS:
        for light in (*POLARISATIONS, "both"):
            errors, ratios = [], []
            for obliquity in ("stam", "exact"):
                values = np.array(pairs(rows, g, light, obliquity))
                values = values[values[:, 0] > WEAK]
                differences = abs(values[:, 1] - values[:, 0])
                errors += [f"{differences.max():.3f}", f"{differences.mean():.3f}"]
                strong = values[values.min(axis=1) > STRONG]
                ratio = strong[:, 0] / strong[:, 1]
                ratios.append(f"{ratio.min():.2f} – {ratio.max():.2f}")
            print(f"| {g.name} | {light} | {len(values)} | {' | '.join(errors + ratios)} |")


def cover_check(rows):
    print("\n| metal | θi | λ nm | m | TE inside | TM inside | TE air's phase | TM air's phase | TE, TE obliquity | TM, TM obliquity |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for g in GRATINGS:
        if not g.name.startswith("covered"):
            continue
        for degrees in ANGLES:
            for nm in WAVELENGTHS:
                here = [r for r in rows if r[0] == g and r[1:3] == (degrees, nm) and abs(r[4]) <= 1]
                for m in sorted({r[4] for r in here}):
                    pair = [next(r[5] for r in here if r[3:5] == (p, m)) for p in POLARISATIONS]
                    cells = [
                        f"{e / scalar(g, degrees, nm, m, p, obliquity, phase):.3f}"
                        for obliquity, phase in (("stam", "inside"), ("stam", "air"), ("exact", "inside"))
                        for e, p in zip(pair, POLARISATIONS)
                    ]
                    print(f"| {g.metal} | {degrees:g} | {nm:g} | {m} | {' | '.join(cells)} |")


if __name__ == "__main__":
    for package, wanted in VERSIONS.items():
        if version(package) != wanted:
            raise SystemExit(f"needs {package} {wanted}, found {version(package)}")
    small_relief()
    flat_mirror()
    known_lamellar()
    rows, balance, change = table()
    if max(map(max, balance.values())) > BALANCE:
        raise SystemExit(f"energy balance: {balance}")
    write(rows)
    print(f"\n{len(rows)} rows\n\n| grating | balance TE | TM | {COARSE} to {POINTS} points TE | TM |\n| --- | --- | --- | --- | --- |")
    for g in GRATINGS:
        cells = [f"{x:.1e}" for x in (*balance[g.name], *change[g.name])]
        print(f"| {g.name} | {' | '.join(cells)} |")
    compare(rows)
    cover_check(rows)
