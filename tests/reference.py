"""High-accuracy reference values of one five-bar design, with an error estimate.

Independent of the package: no import of it, Cartesian columns where the package integrates along
rays, closed-form boundary curves of its own. Conventions as in `naive`.

How it works
------------
1. *Boundary curves.* For a given x every possible boundary ordinate is known: four reach circles,
   two fold circles (B1 = B2), and the mid-point coupler curve (B1, P, B2 in line). With
   Q = x**2 + y**2, K = r1**2 + r3**2 - r2**2 the latter reads
   Q (Q - K)**2 = 4 r3**2 (Q - x**2) (r1**2 - Q), a cubic in Q.
2. *Cells.* The abscissae where those curves have vertical tangents, touch or cross are closed
   forms or roots of a cubic. Between two neighbouring ones the order of the curves that bound the
   region is fixed, so the region of one assembly mode falls into cells, each between two labelled
   curves. The sign of det B is evaluated in every cell, not derived.
3. *Components.* Cells left and right of a critical abscissa are linked where their limiting
   slices overlap in an interval. The component of largest area is the usable workspace. No grid
   takes part in it.
4. *Columns.* Within a cell the outer integral runs over x, the inner over y, each in a variable
   that clusters at both ends, which turns square roots into polynomials. Both are adaptive
   Gauss-Kronrod rules; columns are split at their maxima of the LCI (near an isotropic point the
   LCI has a kink) and at their crossings of the threshold, cells at the isotropic points and at
   the abscissae where the number of crossings changes.
5. *Error.* Everything is done twice, with other clustering, other sampling and another tolerance.
   The error estimate is the larger of the difference and the estimate of the finer run. What it
   cannot know is an island of the good-condition workspace that neither run has sampled; in some
   400 cases checked with denser sampling there was none above 1e-8 of the area.

The x axis cuts every cell it passes, for the sake of the columns next to a small hole. Widths and
heights near rounding (r3 within 1e-4 of 1.5, components of area below 1e-12) cost digits, which the
error estimate reports.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Index = NDArray[np.int_]
Mask = NDArray[np.bool_]

EPS = float(np.finfo(float).eps)

# Gauss (10) and Kronrod (21) rule on [-1, 1]: the non-negative half, largest node first.
_KRONROD_NODES = (
    0.995657163025808080735527280689003,
    0.973906528517171720077964012084452,
    0.930157491355708226001207180059508,
    0.865063366688984510732096688423493,
    0.780817726586416897063717578345042,
    0.679409568299024406234327365114874,
    0.562757134668604683339000099272694,
    0.433395394129247190799265943165784,
    0.294392862701460198131126602103866,
    0.148874338981631210884826001129720,
    0.0,
)
_KRONROD_WEIGHTS = (
    0.011694638867371874278064396062192,
    0.032558162307964727478818972459390,
    0.054755896574351996031381300244580,
    0.075039674810919952767043140916190,
    0.093125454583697605535065465083366,
    0.109387158802297641899210590325805,
    0.123491976262065851077958109585166,
    0.134709217311473325928054001771707,
    0.142775938577060080797094273138717,
    0.147739104901338491374841515972068,
    0.149445554002916905664936468389821,
)
_GAUSS_WEIGHTS = (
    0.066671344308688137593568809893332,
    0.149451349150580593145863396957658,
    0.219086362515982043995534934228163,
    0.269266719309996355091226921569469,
    0.295524224714752870173815619188769,
)


def _full_rule() -> tuple[Array, Array, Array]:
    """Nodes on [0, 1], Kronrod weights and Gauss weights, 21 of each, weights adding up to 1."""
    half = np.array(_KRONROD_NODES)
    kronrod = np.array(_KRONROD_WEIGHTS)
    gauss = np.zeros(11)
    gauss[1::2] = _GAUSS_WEIGHTS

    def mirror(w: Array) -> Array:
        return np.concatenate([w, w[-2::-1]]) / 2

    nodes = np.concatenate([(1 - half) / 2, (1 + half[-2::-1]) / 2])
    return nodes, mirror(kronrod), mirror(gauss)


NODES, KRONROD, GAUSS = _full_rule()


def gauss_kronrod(values: Array, width: Array) -> tuple[Array, Array]:
    """Integral and error estimate of panels from values at `NODES` along axis 1.

    The estimate is QUADPACK's: the difference of the two rules raised to the power at which the
    Kronrod rule converges, with a floor at rounding.
    """
    width = width.reshape(width.shape + (1,) * (values.ndim - 2))
    integral = np.tensordot(values, KRONROD, axes=(1, 0))
    difference = np.abs(integral - np.tensordot(values, GAUSS, axes=(1, 0)))
    size = np.tensordot(np.abs(values), KRONROD, axes=(1, 0))
    spread = np.tensordot(np.abs(values - integral[:, None]), KRONROD, axes=(1, 0))
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = spread * np.minimum(1.0, (200 * difference / spread) ** 1.5)
    error = np.where(spread > 0, scaled, difference)
    return integral * width, np.maximum(error, 20 * EPS * size) * width


# --------------------------------------------------------------------------------------------------
# The mechanism
# --------------------------------------------------------------------------------------------------


class Mechanism(NamedTuple):
    """One design in one mode pair."""

    r1: float
    r2: float
    r3: float
    s1: int
    s2: int
    assembly: int

    @property
    def outer(self) -> float:
        """Radius of the outer reach circles."""
        return self.r1 + self.r2

    @property
    def inner(self) -> float:
        """Radius of the inner reach circles."""
        return abs(self.r1 - self.r2)

    @property
    def k(self) -> float:
        """The constant K of the mid-point coupler curve."""
        return self.r1**2 + self.r3**2 - self.r2**2


class Posture(NamedTuple):
    """What the LCI depends on: squared sines at the elbows, sine and cosine of angle B1 P B2."""

    sin_squared_1: Array
    sin_squared_2: Array
    sin_gamma: Array
    cos_gamma: Array


def posture(m: Mechanism, x: Array, y: Array) -> Posture:
    """Posture at (x, y), meaningful where both legs reach."""
    links = []
    squared_sines = []
    for base, sign in ((-m.r3, m.s1), (m.r3, m.s2)):
        vx = x - base
        d2 = np.maximum(vx * vx + y * y, 1e-300)
        d = np.sqrt(d2)
        # Factors, not a difference of squares: no cancellation at the reach circles.
        sine2 = (m.outer - d) * (m.outer + d) * (d - m.inner) * (d + m.inner)
        sine2 = np.maximum(sine2, 0.0) / (4 * m.r1**2 * m.r2**2)
        along = (1 - (m.r1 - m.r2) * (m.r1 + m.r2) / d2) / 2
        across = -sign * m.r1 * m.r2 * np.sqrt(sine2) / d2
        links.append((along * vx - across * y, along * y + across * vx))
        squared_sines.append(sine2)
    (e1x, e1y), (e2x, e2y) = links
    scale = 1 / m.r2**2
    return Posture(
        squared_sines[0],
        squared_sines[1],
        (e1x * e2y - e1y * e2x) * scale,
        (e1x * e2x + e1y * e2y) * scale,
    )


def has_assembly(m: Mechanism, x: Array, y: Array) -> Mask:
    """Where both legs reach and det B has the sign of the assembly mode."""
    mask = np.ones(np.broadcast(x, y).shape, bool)
    for base in (-m.r3, m.r3):
        d = np.hypot(x - base, y)
        mask &= (m.inner < d) & (d < m.outer)
    return mask & (m.assembly * posture(m, x, y).sin_gamma > 0)


def conditioning(m: Mechanism, x: Array, y: Array) -> tuple[Array, Array]:
    """Give the LCI c and the smooth quantity q = 2 / (c + 1/c).

    The rows of J are unit vectors over r1 sin(beta_i), so c + 1/c is
    (sin(beta1)/sin(beta2) + sin(beta2)/sin(beta1)) / abs(sin(gamma)). In c the root of 1 - q**2 is
    written as a sum of squares, or the kink at isotropic points would be lost to rounding.
    """
    a, b, sin_gamma, cos_gamma = posture(m, x, y)
    product = 2 * np.sqrt(a * b)
    total = a + b
    numerator = product * np.abs(sin_gamma)
    root = np.sqrt((a - b) ** 2 + (product * cos_gamma) ** 2)
    total = np.maximum(total, 1e-300)
    return numerator / (total + root), numerator / total


# --------------------------------------------------------------------------------------------------
# Boundary curves
# --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Arc:
    """Upper (side = +1) or lower (-1) half of a circle with its centre at (cx, cy)."""

    cx: float
    cy: float
    radius: float
    side: int
    is_reach: bool

    def ordinate(self, x: Array) -> Array:
        """Ordinate at x; the extreme one beyond the circle."""
        dx = x - self.cx
        return self.cy + self.side * np.sqrt(
            np.maximum((self.radius - dx) * (self.radius + dx), 0.0)
        )

    def exists(self, x: float) -> bool:
        """Whether the circle reaches x."""
        return abs(x - self.cx) < self.radius


@dataclass(frozen=True)
class Axis:
    """The x axis: no boundary, but a cut, since the inner reach circles are narrowest there.

    A column that passes a small hole closely has its finest detail next to the axis, and columns
    cluster at their ends.
    """

    is_reach: bool = False

    def ordinate(self, x: Array) -> Array:
        """Zero."""
        return np.zeros_like(x)


@dataclass(frozen=True)
class Coupler:
    """One branch of the mid-point coupler curve: which root of the cubic, which sign of y."""

    m: Mechanism
    root: int
    real_roots: int
    side: int
    is_reach: bool = False

    def ordinate(self, x: Array) -> Array:
        """Ordinate at x, zero where the branch has ended."""
        roots = coupler_roots(self.m, x)
        if self.real_roots == 1:
            xi = _lone_root(roots)
        else:
            xi = np.sort(roots.real, axis=-1)[..., self.root]
        squared = self.m.k - x * x + 2 * self.m.r3 * xi
        y: Array = self.side * np.sqrt(np.maximum(squared, 0.0))
        return y


def _lone_root(roots: Complex) -> Array:
    """Pick the real root of cubics with one: least imaginary; near a double root, most remote."""
    gaps = np.abs(roots[..., :, None] - roots[..., None, :])
    gaps[..., range(3), range(3)] = np.inf
    remote = np.argmax(gaps.min(axis=-1), axis=-1)
    imaginary = np.abs(roots.imag)
    clear = imaginary.max(axis=-1) > 1e-5 * np.abs(roots).max(axis=-1)
    choice = np.where(clear, np.argmin(imaginary, axis=-1), remote)
    return np.take_along_axis(roots.real, choice[..., None], axis=-1)[..., 0]


Curve = Arc | Axis | Coupler


def coupler_roots(m: Mechanism, x: Array) -> Complex:
    """Roots xi of the coupler cubic at x, where Q = K + 2 r3 xi.

    In this variable the cubic stays regular as r3 -> 0, where two of its roots in Q coincide.
    """
    x2 = np.asarray(x, float) ** 2
    rest = m.k - x2
    w = m.r2**2 - m.r3**2
    c3 = np.full_like(x2, 2 * m.r3)
    c2 = np.full_like(x2, m.k + 4 * m.r3**2)
    c1 = 2 * m.r3 * (rest - w)
    c0 = -rest * w
    companion = np.zeros((*x2.shape, 3, 3))
    companion[..., 1, 0] = companion[..., 2, 1] = 1.0
    for row, c in enumerate((c0, c1, c2)):
        companion[..., row, 2] = -c / c3
    xi = np.linalg.eigvals(companion).astype(complex)
    c0, c1, c2, c3 = (c[..., None] for c in (c0, c1, c2, c3))
    for _ in range(3):
        value = c0 + xi * (c1 + xi * (c2 + xi * c3))
        slope = c1 + xi * (2 * c2 + 3 * xi * c3)
        with np.errstate(divide="ignore", invalid="ignore"):
            moved = xi - value / slope
        better = np.abs(c0 + moved * (c1 + moved * (c2 + moved * c3))) < np.abs(value)
        xi = np.where(better, moved, xi)
    return xi


def boundary_curves(m: Mechanism, x: float) -> list[Curve]:
    """Every curve that may bound a cell on the column x, whatever the mode."""
    arcs = []
    for side in (1, -1):
        for radius in (m.outer, m.inner):
            arcs += [Arc(base, 0.0, radius, side, is_reach=True) for base in (-m.r3, m.r3)]
        if m.r1 >= m.r3:
            height = np.sqrt((m.r1 - m.r3) * (m.r1 + m.r3))
            arcs += [Arc(0.0, h, m.r2, side, is_reach=False) for h in (height, -height)]
        if m.r3 == 0 and m.k > 0:
            arcs.append(Arc(0.0, 0.0, np.sqrt(m.k), side, is_reach=False))
    curves: list[Curve] = [Axis(), *(arc for arc in arcs if arc.exists(x))]
    if m.r3 > 0:
        xi = coupler_roots(m, np.array([x]))[0]
        real = np.abs(xi.imag) <= 1e-9 * np.abs(xi).max()
        count = 3 if real.all() else 1
        values = np.sort(xi.real) if count == 3 else _lone_root(xi[None])
        for index, value in enumerate(values):
            q = m.k + 2 * m.r3 * value
            if x * x <= q <= m.r1**2 * (1 + 1e-12):
                curves += [Coupler(m, index, count, side) for side in (1, -1)]
    return curves


def critical_abscissae(m: Mechanism) -> Array:
    """Where boundary curves have vertical tangents, touch or cross; sorted, with the two ends."""
    r1, r2, r3 = m.r1, m.r2, m.r3
    width = m.outer - r3
    found = [0.0, width, r2, r1]
    found += [abs(r3 + s * radius) for s in (1, -1) for radius in (m.outer, m.inner)]
    if m.k > 0:
        found.append(np.sqrt(m.k))
    if r1 >= r3:
        # Fold circles touch reach circles at P in line with A_i and B1 = B2 = (0, h).
        found.append(np.sqrt(max(r2**2 - r1**2 + r3**2, 0.0)))
        found += [abs(r3 * r2 / r1)] + [abs(r3 * (2 + s * r2 / r1)) for s in (1, -1)]
    if r3 > 0:
        # An outer and an inner reach circle cross.
        found.append((m.outer**2 - m.inner**2) / (4 * r3))
        for s in (1, -1):
            # The coupler curve touches a reach circle at A_i, B1, P, B2 in line.
            link = r1 + s * 2 * r2
            if link != 0:
                cosine = (link**2 + 4 * r3**2 - r1**2) / (4 * r3 * link)
                found.append(abs(-r3 + (r1 + s * r2) * cosine))
        # Vertical tangents of the coupler curve: x**2 as a function of xi is stationary.
        q = Polynomial([m.k, 2 * r3])
        w = Polynomial([r2**2 - r3**2, -2 * r3])
        xi = Polynomial([0.0, 1.0])
        stationary = r3 * w * (w - xi**2) - q * xi * (w + r3 * xi)
        for root in stationary.roots():
            t = float(np.real(root))
            if w(t) != 0:
                found.append(float(np.sqrt(max(q(t) * (1 - t**2 / w(t)), 0.0))))
    else:
        # Every point of two rings is isotropic.
        if 2 * r1**2 >= r2**2:
            root = np.sqrt(2 * r1**2 - r2**2)
            found += [abs(r2 + s * root) / np.sqrt(2) for s in (1, -1)]
    x = np.array(found, dtype=np.float64)
    x = np.sort(np.concatenate([-x, x])[np.concatenate([x, x]) <= width])
    # Twins within rounding of each other make empty panels.
    keep = np.append(np.diff(x) > 1e-12 * min(1.0, r1, r2), True)
    return np.asarray(x[keep])


# --------------------------------------------------------------------------------------------------
# Cells and components
# --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Cell:
    """Part of the region between two critical abscissae and two labelled curves."""

    left: float
    right: float
    lower: Curve
    upper: Curve

    def slice(self, x: Array) -> tuple[Array, Array]:
        """Give the ends of the columns at x; the length is never negative."""
        low = self.lower.ordinate(x)
        return low, np.maximum(self.upper.ordinate(x), low)


def cells_between(m: Mechanism, left: float, right: float) -> list[Cell]:
    """Cells of the region between two neighbouring critical abscissae, bottom up."""
    x = left + 0.4142 * (right - left)
    curves = boundary_curves(m, x)
    y = np.array([float(c.ordinate(np.array([x]))[0]) for c in curves])
    # Among coincident curves a reach circle goes last, so that it separates.
    order = sorted(range(len(curves)), key=lambda i: (y[i], curves[i].is_reach))
    kept: list[int] = []
    for i in order:
        if kept and y[i] - y[kept[-1]] < 1e-13 * m.outer:
            if curves[i].is_reach:
                kept[-1] = i
        else:
            kept.append(i)
    cells: list[Cell] = []
    start: Curve | None = None
    for i, j in pairwise(kept):
        at = y[i] + np.array([0.25, 0.5, 0.75]) * (y[j] - y[i])
        valid = has_assembly(m, np.full(3, x), at)
        if y[j] - y[i] > 1e-7 and valid.any() != valid.all():
            raise ArithmeticError(f"det B changes sign between boundary curves: {m}, x = {x}")
        if valid[1]:
            start = start or curves[i]
            if curves[j].is_reach or isinstance(curves[j], Axis):
                cells.append(Cell(left, right, start, curves[j]))
                start = None
        elif start is not None:
            cells.append(Cell(left, right, start, curves[i]))
            start = None
    return cells


def components(m: Mechanism) -> list[list[Cell]]:
    """Find the connected components of the region, each as its cells."""
    x = critical_abscissae(m)
    columns = [cells_between(m, a, b) for a, b in pairwise(x)]
    cells = [cell for column in columns for cell in column]
    parent = list(range(len(cells)))

    def root(i: int) -> int:
        while parent[i] != i:
            i = parent[i]
        return i

    for i, (a, b) in enumerate(pairwise(cells)):
        if a.left == b.left and isinstance(a.upper, Axis) and isinstance(b.lower, Axis):
            parent[root(i + 1)] = root(i)

    offset = 0
    tolerance = 1e-7 * min(1.0, m.r1, m.r2)
    for before, after in pairwise(columns):
        for i, a in enumerate(before):
            for j, b in enumerate(after, len(before)):
                a_low, a_high = a.slice(np.array([a.right]))
                b_low, b_high = b.slice(np.array([b.left]))
                if min(a_high[0], b_high[0]) - max(a_low[0], b_low[0]) > tolerance:
                    parent[root(offset + j)] = root(offset + i)
        offset += len(before)
    groups: dict[int, list[Cell]] = {}
    for i, cell in enumerate(cells):
        groups.setdefault(root(i), []).append(cell)
    return list(groups.values())


# --------------------------------------------------------------------------------------------------
# Outer integrals
# --------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Settings:
    """One level of refinement."""

    rtol: float
    order: int  # 2 or 4: how fast the columns cluster at the ends of a strip
    samples: int  # of q along a column, in search of extrema and crossings
    columns: int  # of a strip, in search of changes of the number of crossings


class Strip(NamedTuple):
    """A piece of a cell on which the integrals over columns are smooth."""

    cell: Cell
    left: float
    right: float


def cluster(t: Array, order: int) -> tuple[Array, Array]:
    """Map of [0, 1] onto itself, like t**order at 0 and mirrored at 1, and its derivative."""
    if order == 2:
        return t * t * (3 - 2 * t), 6 * t * (1 - t)
    value = t**4 * (35 + t * (-84 + t * (70 - 20 * t)))
    return value, 140 * (t * (1 - t)) ** 3


class Columns(NamedTuple):
    """Columns x with the ends of their intervals, and dx/dt."""

    x: Array
    low: Array
    length: Array
    dx: Array

    def take(self, index: Index | Mask) -> "Columns":
        """Select columns."""
        return Columns(*(part[index] for part in self))


def columns_of(strips: Sequence[Strip], owner: Index, t: Array, order: int) -> Columns:
    """Columns at the parameters t of the strips `owner`, all flat arrays of one length."""
    left = np.array([s.left for s in strips])[owner]
    right = np.array([s.right for s in strips])[owner]
    u, du = cluster(t, order)
    x = left + (right - left) * u
    low = np.empty_like(x)
    high = np.empty_like(x)
    for i in np.unique(owner):
        mine = owner == i
        low[mine], high[mine] = strips[i].cell.slice(x[mine])
    return Columns(x, low, high - low, (right - left) * du)


def integrate_strips(
    count: int,
    integrand: Callable[[Index, Array], Array],
    tolerance: Callable[[Array], Array],
) -> tuple[Array, Array]:
    """Adaptive integrals over [0, 1] of a vector-valued function on each of many strips.

    Parameters
    ----------
    count : int
        Number of strips.
    integrand : callable
        From strip numbers and parameters, both (n,), to values (n, k).
    tolerance : callable
        From the sum over strips (k,) to the tolerances of that sum (k,).

    Returns
    -------
    value, error : ndarray
        Shape (count, k).
    """

    def panels(owner: Index, a: Array, b: Array) -> tuple[Array, Array]:
        parts = []
        for i in range(0, owner.size, 500):  # for the sake of memory
            width = (b - a)[i : i + 500]
            t = a[i : i + 500, None] + width[:, None] * NODES
            values = integrand(np.repeat(owner[i : i + 500], NODES.size), t.ravel())
            parts.append(gauss_kronrod(values.reshape(*t.shape, -1), width))
        return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])

    owner = np.arange(count)
    a, b = np.zeros(count), np.ones(count)
    value, error = panels(owner, a, b)
    for _ in range(60):
        share = np.max(error / tolerance(value.sum(axis=0)), axis=1)
        order = np.argsort(share)
        # The smallest contributions, up to half the tolerance, are left as they are.
        refine = order[np.cumsum(share[order]) > 0.5]
        refine = refine[(b - a)[refine] > 1e-6]
        # Beyond so many panels it is rounding that is refined; the error estimate says so.
        if share.sum() <= 1 or refine.size == 0 or owner.size > 3000:
            break
        middle = (a[refine] + b[refine]) / 2
        new_owner = np.concatenate([owner[refine]] * 2)
        new_a = np.concatenate([a[refine], middle])
        new_b = np.concatenate([middle, b[refine]])
        new_value, new_error = panels(new_owner, new_a, new_b)
        keep = np.ones(owner.size, bool)
        keep[refine] = False
        owner = np.concatenate([owner[keep], new_owner])
        a, b = np.concatenate([a[keep], new_a]), np.concatenate([b[keep], new_b])
        value = np.concatenate([value[keep], new_value])
        error = np.concatenate([error[keep], new_error])
    totals = np.zeros((2, count, value.shape[1]))
    np.add.at(totals[0], owner, value)
    np.add.at(totals[1], owner, error)
    return totals[0], totals[1]


def areas(cells: Sequence[Cell], order: int) -> tuple[Array, Array]:
    """Area and error estimate of every cell."""
    strips = [Strip(c, c.left, c.right) for c in cells]

    def height(owner: Index, t: Array) -> Array:
        columns = columns_of(strips, owner, t, order)
        return (columns.length * columns.dx)[:, None]

    value, error = integrate_strips(len(cells), height, lambda total: 1e-12 * total + 1e-16)
    return value[:, 0], error[:, 0]


# --------------------------------------------------------------------------------------------------
# Columns
# --------------------------------------------------------------------------------------------------


def column_conditioning(m: Mechanism, columns: Columns, t: Array) -> tuple[Array, Array, Array]:
    """LCI, q and dy/dt at the parameter t in [0, 1] of each column; t may have a second axis."""
    x, low, length, _ = (c.reshape(c.shape + (1,) * (t.ndim - 1)) for c in columns)
    u, du = cluster(t, 2)
    index, q = conditioning(m, x, low + length * u)
    return index, q, length * du


def golden_maxima(
    f: Callable[[Array], Array], a: Array, b: Array, steps: int
) -> tuple[Array, Array]:
    """Maxima of many functions at once between a and b by golden sections, and their values."""
    golden = (np.sqrt(5) - 1) / 2
    c, d = b - golden * (b - a), a + golden * (b - a)
    fc, fd = f(c), f(d)
    for _ in range(steps):
        left = fc > fd
        a, b = np.where(left, a, c), np.where(left, d, b)
        new = np.where(left, b - golden * (b - a), a + golden * (b - a))
        value = f(new)
        c, d = np.where(left, new, d), np.where(left, c, new)
        fc, fd = np.where(left, value, fd), np.where(left, fc, value)
    return np.where(fc > fd, c, d), np.maximum(fc, fd)


class Samples(NamedTuple):
    """q along columns: flat, sorted by column and parameter, refined extrema included."""

    column: Index
    t: Array
    q: Array
    is_maximum: Mask
    is_minimum: Mask


def column_extrema(
    m: Mechanism, columns: Columns, grid: Array, q: Array, sign: int
) -> tuple[Index, Array, Array]:
    """Refine the maxima (sign = +1) or minima (-1) of samples q, shape (columns, grid).

    Returns column numbers, parameters and values.
    """
    inside = sign * q[:, 1:-1]
    row, k = np.nonzero((inside >= sign * q[:, :-2]) & (inside > sign * q[:, 2:]))
    mine = columns.take(row)
    # q is flat at an extremum: beyond 1e-8 its parameter is lost in rounding anyway.
    t, value = golden_maxima(
        lambda t: sign * column_conditioning(m, mine, t)[1], grid[k], grid[k + 2], 30
    )
    return row, t, sign * value


def sample_columns(m: Mechanism, columns: Columns, count: int) -> Samples:
    """Sample q along columns, and add its local extrema, found by golden sections."""
    n = columns.x.size
    # Next to the ends geometrically: on the x axis q may have an extremum however close.
    end = 0.5 ** np.arange(7, 0, -1) / count
    grid = np.concatenate([[0.0], end, np.arange(1, count) / count, 1 - end[::-1], [1.0]])
    q = column_conditioning(m, columns, np.tile(grid, (n, 1)))[1]
    # All ends but those on the x axis are singular, with q = 0 up to rounding.
    q[:, [0, -1]] = np.where(q[:, [0, -1]] < 1e-3, 0.0, q[:, [0, -1]])
    parts = [
        (np.repeat(np.arange(n), grid.size), np.tile(grid, n), q.ravel()),
        column_extrema(m, columns, grid, q, 1),
        column_extrema(m, columns, grid, q, -1),
    ]
    kind = np.repeat([0, 1, -1], [part[0].size for part in parts])
    column = np.concatenate([part[0] for part in parts])
    t, q = (np.concatenate([part[i] for part in parts]) for i in (1, 2))
    order = np.lexsort((t, column))
    return Samples(column[order], t[order], q[order], kind[order] == 1, kind[order] == -1)


def find_roots(f: Callable[[Array], Array], a: Array, b: Array, fa: Array, fb: Array) -> Array:
    """Roots of many bracketed functions at once, by Chandrupatla's method."""
    x1, f1, x2, f2 = b, fb, a, fa
    t = np.full_like(a, 0.5)
    for _ in range(80):
        x = x1 + t * (x2 - x1)
        fx = f(x)
        same = np.sign(fx) == np.sign(f1)
        x3, f3 = np.where(same, x1, x2), np.where(same, f1, f2)
        x2, f2 = np.where(same, x2, x1), np.where(same, f2, f1)
        x1, f1 = x, fx
        width = np.abs(x2 - x1)
        with np.errstate(divide="ignore", invalid="ignore"):
            limit = np.where(width > 0, 2 * EPS / width, 1.0)
            if np.all((limit > 0.5) | (f1 == 0)):
                break
            xi, phi = (x1 - x2) / (x3 - x2), (f1 - f2) / (f3 - f2)
            inverse = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
            step = f1 / (f2 - f1) * f3 / (f2 - f3)
            step += (x3 - x1) / (x2 - x1) * f1 / (f3 - f1) * f2 / (f3 - f2)
        limit = np.minimum(limit, 0.5)
        t = np.clip(np.where(inverse & np.isfinite(step), step, 0.5), limit, 1 - limit)
    return np.where(np.abs(f1) < np.abs(f2), x1, x2)


def crossings(m: Mechanism, columns: Columns, samples: Samples, q: float) -> tuple[Index, Array]:
    """Where q is crossed: column numbers and parameters."""
    above = samples.q >= q
    change = (above[1:] != above[:-1]) & (samples.column[1:] == samples.column[:-1])
    i = np.nonzero(change)[0]
    row = samples.column[i]
    mine = columns.take(row)
    return row, find_roots(
        lambda t: column_conditioning(m, mine, t)[1] - q,
        samples.t[i],
        samples.t[i + 1],
        samples.q[i] - q,
        samples.q[i + 1] - q,
    )


def column_integrals(
    m: Mechanism, columns: Columns, levels: Sequence[float], samples: int, tolerance: float
) -> Array:
    """Integrals over columns, shape (n, 2 + 2 len(levels)).

    The LCI over the column; then for every level of q the length of the part above it; then the
    LCI over those parts; last the error estimate of the first.
    """
    n = columns.x.size
    result = np.zeros((n, 2 + 2 * len(levels)))
    probed = sample_columns(m, columns, samples)
    # Only a maximum near 1 is sharp.
    sharp = probed.is_maximum & (probed.q > 0.9)
    column = [np.arange(n), np.arange(n), probed.column[sharp]]
    cut = [np.zeros(n), np.ones(n), probed.t[sharp]]
    for level in levels:
        row, t = crossings(m, columns, probed, level)
        column.append(row)
        cut.append(t)
    rows, cuts = np.concatenate(column), np.concatenate(cut)
    order = np.lexsort((cuts, rows))
    rows, cuts = rows[order], cuts[order]
    panel = np.nonzero((rows[1:] == rows[:-1]) & (cuts[1:] > cuts[:-1]))[0]
    row, a, b = rows[panel], cuts[panel], cuts[panel + 1]

    middle = column_conditioning(m, columns.take(row), (a + b) / 2)[1]
    good = middle[:, None] >= np.array(levels)
    lengths = columns.length[row] * (cluster(b, 2)[0] - cluster(a, 2)[0])
    for k in range(len(levels)):
        result[:, 1 + k] = np.bincount(row, lengths * good[:, k], n)

    while row.size:
        t = a[:, None] + (b - a)[:, None] * NODES
        index, _, dy = column_conditioning(m, columns.take(row), t)
        value, error = gauss_kronrod(index * dy, b - a)
        done = (error <= tolerance) | (b - a < 1e-12)
        # Beyond so many panels it is rounding that is refined; the error estimate says so.
        done |= row.size > 12 * n + 3000
        result[:, 0] += np.bincount(row[done], value[done], n)
        result[:, -1] += np.bincount(row[done], error[done], n)
        for k in range(len(levels)):
            part = done & good[:, k]
            result[:, 1 + len(levels) + k] += np.bincount(row[part], value[part], n)
        middle = (a + b) / 2
        row, good = np.tile(row[~done], 2), np.tile(good[~done], (2, 1))
        a, b = (
            np.concatenate([a[~done], middle[~done]]),
            np.concatenate([middle[~done], b[~done]]),
        )
    return result


# --------------------------------------------------------------------------------------------------
# Where to split cells
# --------------------------------------------------------------------------------------------------


def isotropic_points(m: Mechanism) -> Array:
    """Isotropic points off the y axis, shape (n, 2); the axis is a critical abscissa anyway.

    Both elbow angles have the same sine on x**2 + y**2 = r1**2 + r2**2 - r3**2; there the point is
    isotropic where B1 P B2 is a right angle.
    """
    radius = np.sqrt(max(m.r1**2 + m.r2**2 - m.r3**2, 0.0))

    def cosine(angle: Array) -> Array:
        return posture(m, radius * np.cos(angle), radius * np.sin(angle)).cos_gamma

    angle = np.linspace(-np.pi, np.pi, 2001)
    value = cosine(angle)
    # Where the cosine vanishes identically (or nearly) its sign is noise.
    change = (np.sign(value[1:]) != np.sign(value[:-1])) & (np.abs(np.diff(value)) > 1e-9)
    i = np.nonzero(change)[0]
    root = find_roots(cosine, angle[i], angle[i + 1], value[i], value[i + 1])
    return np.stack([radius * np.cos(root), radius * np.sin(root)], axis=1)


def split_at_isotropic_points(m: Mechanism, cells: Sequence[Cell]) -> list[Strip]:
    """Turn cells into strips, cut at the isotropic points they contain."""
    points = isotropic_points(m)
    strips = []
    for cell in cells:
        low, high = cell.slice(points[:, 0])
        hit = (points[:, 1] > low) & (points[:, 1] < high)
        cuts = points[hit, 0]
        cuts = np.sort(cuts[(cuts > cell.left) & (cuts < cell.right)])
        edges = [cell.left, *cuts, cell.right]
        strips += [Strip(cell, a, b) for a, b in pairwise(edges) if b - a > 1e-12]
    return strips


def axis_crossings(m: Mechanism, left: float, right: float, level: float) -> Array:
    """Abscissae between left and right where q crosses a level on the x axis."""

    def excess(t: Array) -> Array:
        x = left + (right - left) * cluster(t, 2)[0]
        return conditioning(m, x, np.zeros_like(x))[1] - level

    t = np.linspace(0.0, 1.0, 801)
    value = excess(t)
    inside = value[1:-1]
    high = np.nonzero((inside >= value[:-2]) & (inside > value[2:]))[0]
    low = np.nonzero((inside <= value[:-2]) & (inside < value[2:]))[0]
    peaks, _ = golden_maxima(excess, t[high], t[high + 2], 30)
    pits, _ = golden_maxima(lambda t: -excess(t), t[low], t[low + 2], 30)
    t = np.sort(np.concatenate([t, peaks, pits]))
    value = excess(t)
    i = np.nonzero((value[1:] >= 0) != (value[:-1] >= 0))[0]
    root = find_roots(excess, t[i], t[i + 1], value[i], value[i + 1])
    return left + (right - left) * cluster(root, 2)[0]


def split_at_axis_crossings(m: Mechanism, strips: Sequence[Strip], level: float) -> list[Strip]:
    """Cut strips along the x axis where a level curve of q crosses the axis.

    A level curve that bulges across the axis leaves a narrow lens on its other side.
    """
    result = []
    for strip in strips:
        edges = [strip.left, strip.right]
        if isinstance(strip.cell.lower, Axis) or isinstance(strip.cell.upper, Axis):
            edges = sorted([*edges, *axis_crossings(m, strip.left, strip.right, level)])
        result += [Strip(strip.cell, a, b) for a, b in pairwise(edges) if b - a > 1e-13]
    return result


class Crossing(NamedTuple):
    """How columns meet a level of q."""

    number: Index  # how often they cross it
    hump: Array  # by how little their highest hump below it fails to reach it, negative
    dip: Array  # by how little their lowest dip above it fails to reach it, negative


def count_crossings(
    m: Mechanism,
    strips: Sequence[Strip],
    owner: Index,
    t: Array,
    level: float,
    settings: Settings,
) -> Crossing:
    """Look how the columns at parameters t of strips `owner` meet a level of q."""
    columns = columns_of(strips, owner, t, settings.order)
    s = sample_columns(m, columns, settings.samples)
    above = s.q >= level
    change = (above[1:] != above[:-1]) & (s.column[1:] == s.column[:-1])
    count = np.bincount(s.column[1:][change], minlength=t.size)
    hump, dip = np.full(t.size, -np.inf), np.full(t.size, -np.inf)
    low = s.is_maximum & ~above
    np.maximum.at(hump, s.column[low], s.q[low] - level)
    high = s.is_minimum & above
    np.maximum.at(dip, s.column[high], level - s.q[high])
    return Crossing(count, hump, dip)


def split_at_level_tangents(
    m: Mechanism, strips: Sequence[Strip], level: float, settings: Settings
) -> list[Strip]:
    """Cut strips where the number of crossings of a level of q changes from column to column.

    That is where the level curve has a vertical tangent. Strips are sampled; between columns with
    the same number the extremum of q closest to the level is followed to its own extremum, lest an
    island between two columns be missed.
    """
    n = settings.columns
    grid = (np.arange(n) + 0.5) / n

    def probe(who: Index, t: Array) -> Crossing:
        return count_crossings(m, strips, who, t, level, settings)

    probed = probe(np.repeat(np.arange(len(strips)), n), np.tile(grid, len(strips)))
    count = probed.number.reshape(-1, n)
    who, k = np.nonzero(count[:, 1:] != count[:, :-1])
    brackets = [(who, grid[k], grid[k + 1], count[who, k])]

    def add_islands(component: int) -> None:
        closeness = probed[component].reshape(-1, n)
        left, middle, right = closeness[:, :-2], closeness[:, 1:-1], closeness[:, 2:]
        equal = (count[:, 1:-1] == count[:, :-2]) & (count[:, 1:-1] == count[:, 2:])
        with np.errstate(invalid="ignore"):
            # Worth following if a multiple of what a parabola adds would reach the level.
            near = middle + 0.5 * (2 * middle - left - right) > 0
        who, k = np.nonzero(equal & near & (middle > left) & (middle >= right))
        before = count[who, k + 1]
        hit = np.full(who.size, np.nan)

        def follow(t: Array) -> Array:
            here = probe(who, t)
            changed = here.number != before
            hit[changed] = t[changed]
            return np.asarray(here[component])

        if who.size:
            golden_maxima(follow, grid[k], grid[k + 2], 24)
        found = np.isfinite(hit)
        who, k, hit, before = who[found], k[found], hit[found], before[found]
        brackets.extend((who, grid[k + side], hit, before) for side in (0, 2))

    add_islands(Crossing._fields.index("hump"))
    add_islands(Crossing._fields.index("dip"))

    who, before = (np.concatenate([p[i] for p in brackets]) for i in (0, 3))
    a, b = (np.concatenate([p[i] for p in brackets]) for i in (1, 2))
    if who.size:
        for _ in range(42):
            middle = (a + b) / 2
            same = probe(who, middle).number == before
            a, b = np.where(same, middle, a), np.where(same, b, middle)
    result = []
    for i, strip in enumerate(strips):
        width = strip.right - strip.left
        cuts = np.sort(strip.left + width * cluster(a[who == i], settings.order)[0])
        edges = [strip.left, *cuts, strip.right]
        result += [Strip(strip.cell, p, q) for p, q in pairwise(edges) if q - p > 1e-13]
    return result


# --------------------------------------------------------------------------------------------------
# The reference
# --------------------------------------------------------------------------------------------------


def mean_conditioning(m: Mechanism, strips: Sequence[Strip]) -> float:
    """Estimate the mean LCI, roughly, to scale tolerances with."""
    columns = columns_of(strips, np.arange(len(strips)), np.full(len(strips), 0.5), 2)
    index, _, dy = column_conditioning(m, columns, np.tile(NODES, (len(strips), 1)))
    return float(columns.dx @ (index * dy) @ KRONROD / (columns.dx @ dy @ KRONROD))


def integrals(
    m: Mechanism,
    cells: Sequence[Cell],
    area: float,
    thresholds: Sequence[float],
    settings: Settings,
) -> tuple[Array, Array]:
    """Integrals over the usable workspace and their error estimates, as in `column_integrals`."""
    levels = [2 * t / (1 + t * t) for t in thresholds]
    strips = split_at_isotropic_points(m, cells)
    for level in levels:
        strips = split_at_axis_crossings(m, strips, level)
        strips = split_at_level_tangents(m, strips, level, settings)
    width = max(c.right for c in cells) - min(c.left for c in cells)
    # The mean LCI may be small (it vanishes with r3 in the modes ++ and --), but far below 1e-4
    # rounding in sin(gamma) is above the tolerance, which no refinement would reach.
    guess = max(mean_conditioning(m, strips), 1e-4)
    column_tolerance = 1e-4 * settings.rtol * guess * area / width
    n = len(levels)
    # The last component is no target but the error made within columns.
    floor = area * np.array([guess / 2, *[1e-3] * (2 * n), np.inf])

    def integrand(owner: Index, t: Array) -> Array:
        columns = columns_of(strips, owner, t, settings.order)
        value = column_integrals(m, columns, levels, settings.samples, column_tolerance)
        return value * columns.dx[:, None]

    value, error = integrate_strips(
        len(strips), integrand, lambda total: settings.rtol * np.maximum(total, floor)
    )
    value, error = value.sum(axis=0), error.sum(axis=0)
    return value[:-1], error[:-1] + value[-1]


def reference(
    r1: float,
    r2: float,
    r3: float,
    s1: int,
    s2: int,
    assembly: int,
    thresholds: Sequence[float] = (0.5,),
    rtol: float = 1e-8,
) -> dict[str, Any]:
    """Usable workspace, its area and conditioning indices, with error estimates.

    Parameters
    ----------
    r1, r2, r3 : float
        Actuated link, distal link, half the base.
    s1, s2 : {+1, -1}
        Working mode.
    assembly : {+1, -1}
        Assembly mode, the sign of det B.
    thresholds : sequence of float
        LCI thresholds of the good-condition workspace, each in (0, 1).
    rtol : float
        Tolerance of the finer of the two runs, relative to each integral; for those over the
        good-condition workspace relative to a thousandth of the usable area, if that is more.

    Returns
    -------
    dict
        ``usable_workspace_area``, ``gci``, and the dictionaries ``good_condition_area`` and
        ``good_condition_gci`` keyed by threshold; to each of the four an ``..._error``, the
        absolute error estimate. ``runner_up_area`` is the area of the second largest component:
        where it equals the largest, the two mirror images tie and the indices are those of one of
        them. Without any component the areas are 0 and the means NaN.
    """
    m = Mechanism(float(r1), float(r2), float(r3), int(s1), int(s2), int(assembly))
    thresholds = [float(t) for t in thresholds]
    nothing = dict.fromkeys(thresholds, np.nan)
    exact = dict.fromkeys(thresholds, 0.0)
    result: dict[str, Any] = {
        "usable_workspace_area": 0.0,
        "usable_workspace_area_error": 0.0,
        "runner_up_area": 0.0,
        "gci": np.nan,
        "gci_error": np.nan,
        "good_condition_area": dict(exact),
        "good_condition_area_error": dict(exact),
        "good_condition_gci": dict(nothing),
        "good_condition_gci_error": dict(nothing),
    }
    parts = components(m) if m.outer > m.r3 else []
    if not parts:
        return result

    cells = [cell for part in parts for cell in part]
    ends = np.cumsum([0, *(len(part) for part in parts)])
    coarse_area, fine_area = areas(cells, 2), areas(cells, 4)
    sums = np.add.reduceat(fine_area[0], ends[:-1])
    best = int(np.argmax(sums))
    mine = slice(ends[best], ends[best + 1])
    area = float(sums[best])
    area_error = max(abs(area - float(coarse_area[0][mine].sum())), float(fine_area[1][mine].sum()))
    result["usable_workspace_area"] = area
    result["usable_workspace_area_error"] = area_error
    if len(parts) > 1:
        result["runner_up_area"] = float(np.sort(sums)[-2])

    coarse = Settings(rtol=10 * rtol, order=2, samples=64, columns=30)
    fine = Settings(rtol=rtol, order=4, samples=128, columns=60)
    other, _ = integrals(m, parts[best], area, thresholds, coarse)
    value, error = integrals(m, parts[best], area, thresholds, fine)
    error = np.maximum(error, np.abs(value - other))

    gci = float(value[0] / area)
    result["gci"] = gci
    result["gci_error"] = float((error[0] + gci * area_error) / area)
    n = len(thresholds)
    for k, t in enumerate(thresholds):
        good, mean = 1 + k, 1 + n + k
        result["good_condition_area"][t] = float(value[good])
        result["good_condition_area_error"][t] = float(error[good])
        if value[good] > 0:
            good_gci = float(value[mean] / value[good])
            result["good_condition_gci"][t] = good_gci
            result["good_condition_gci_error"][t] = float(
                (error[mean] + good_gci * error[good]) / value[good]
            )
    return result
