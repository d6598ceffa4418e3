"""Evaluate designs of the pentapod: every quantity of its atlas, in compiled loops.

What is integrated is the mean over Sobol points of several scramblings, added to until the
tolerance is reached; errors come from the scatter of the scramblings. Extremes are searched for
from the worst points.
"""

from __future__ import annotations

import math
import threading
from typing import Any

import numpy as np
import numpy.typing as npt

from fivebar_atlas.errors import InputError
from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.pentapod.atlas_options import HOME, AtlasOptions
from fivebar_atlas.mechanisms.pentapod.determinant_along import determinant_at
from fivebar_atlas.mechanisms.pentapod.drawn_lines import diamond_angle
from fivebar_atlas.mechanisms.pentapod.extremes import LIMB_FORCE, SINGULAR_VALUE, search_worst
from fivebar_atlas.mechanisms.pentapod.integration import (
    HITS,
    LARGEST,
    SHARE,
    SHARE_LCI,
    SHARE_VALUE,
    SINGULAR,
    SUMS,
    WORK,
    Work,
    integrate,
)
from fivebar_atlas.mechanisms.pentapod.jacobian import jacobian, without_unit
from fivebar_atlas.mechanisms.pentapod.kinematics import inverse_displacement
from fivebar_atlas.mechanisms.pentapod.pose import set_orientation, set_position
from fivebar_atlas.mechanisms.pentapod.sampling import (
    SCRAMBLINGS,
    deviates,
    points_of_level,
    points_up_to,
)
from fivebar_atlas.numerics.records import allocate_record

# Bits of ``status``.
NO_USABLE_POSE = 1
DEGENERATE_DESIGN = 2
GCI_TOLERANCE_NOT_REACHED = 4
SHARE_TOLERANCE_NOT_REACHED = 8
SINGULAR_POSES = 16

# LCI at home, and derivative of the constraint by α there as a share of the size, that are 0.
_DEGENERATE = 1e-9
# Points of a scrambling at most at a tolerance of 1e-3; a tighter one is worth more of them, and
# this factor bounds the memory that they take.
_MOST_POINTS, _MOST_FACTOR = 1 << 15, 4
# Quantile of Student's t for the scrambling means: two-sided, 99.5 %.
_STUDENT = 3.2860385709462347
# Of shares of the box, absolute, and the volume, relative, errors may be so many tolerances.
_SHARE_TOLERANCES = 2.0
# Shares of the box that may go unseen: with no more the odds of seeing nothing are 1 in 1,000.
_UNSEEN = math.log(1000.0)
# Where there are few usable points their scatter tells little: this over the square of their
# number is added to the relative errors of means.
_FEW = 25.0
# Poses that the search for each extreme begins at, of different scramblings.
_STARTS = 4

_BOX, _VOLUME = range(2)
# Arrays of results before those with thresholds, with errors beside where there are any.
_INTEGRATED = ("gci", "mean_least_singular_value", "usable_share", "workspace_volume")
_PLAIN = (
    "least_singular_value", "largest_limb_force",
    "home_lci", "home_least_singular_value", "home_largest_limb_force",
)  # fmt: skip
_THRESHOLD = ("good_condition_share", "good_condition_gci")
# Those that are 0 where nothing is usable.
_SHARES = ("usable_share", "workspace_volume", "good_condition_share")


class _Kept(threading.local):
    """The work space of each thread, kept from call to call."""

    work: Work | None = None


_KEPT = _Kept()


def work_space() -> Work:
    """Return the work space of this thread."""
    if _KEPT.work is None:
        _KEPT.work = allocate_record(WORK)
    return _KEPT.work


def evaluate_designs(
    designs: FloatArray, options: AtlasOptions, lci_thresholds: FloatArray, tolerance: float
) -> dict[str, npt.NDArray[Any]]:
    """Evaluate designs; the GIL is released in the compiled loops.

    Parameters
    ----------
    designs
        r_a and r_b with H = 1, shape (n, 2).
    options
        Geometry, pose box and limits.
    lci_thresholds
        Thresholds in (0, 1), shape (k,).
    tolerance
        Of means, relative; errors of the volume, relative, and of shares of the box, absolute,
        may be twice that.

    Returns
    -------
    dict
        Arrays by dataset name, shapes (n,) and (n, k). What does not exist is NaN, explained by
        ``status``. Shares and volumes are 0 where nothing is usable, and NaN, as all else is, of
        a degenerate design.
    """
    count, kinds = len(designs), len(lci_thresholds)
    out: dict[str, npt.NDArray[Any]] = {}
    for names, shape, has_error in (
        (_INTEGRATED, (count,), True),
        (_PLAIN, (count,), False),
        (_THRESHOLD, (count, kinds), True),
    ):
        for name in names:
            out[name] = np.full(shape, math.nan)
            if has_error:
                out[f"{name}_error"] = np.full(shape, math.nan)
    out["status"] = np.zeros(count, dtype=np.int16)
    w = work_space()
    for n, (r_a, r_b) in enumerate(designs.tolist()):
        if not set_design(w, r_a, r_b, options, out, n):
            out["status"][n] = DEGENERATE_DESIGN
            continue
        for name in _SHARES:
            out[name][n] = out[f"{name}_error"][n] = 0.0
        status = _evaluate_box(w, lci_thresholds, tolerance, out, n)
        out["status"][n] = status | _evaluate_volume(w, tolerance, out, n)
    return out


def set_design(
    w: Work, r_a: float, r_b: float, options: AtlasOptions,
    out: dict[str, npt.NDArray[Any]] | None = None, n: int = 0,
) -> bool:  # fmt: skip
    """Set the design of a work space.

    Parameters
    ----------
    w
        Work space.
    r_a, r_b
        The design, H = 1.
    options
        Geometry, pose box and limits.
    out, n
        Results, of which entry n receives what is true at home.

    Returns
    -------
    bool
        Whether there is such a design: not where joints are in one place, where the home pose is
        singular, or where α is not determined by the other coordinates there.
    """
    try:
        geometry = options.geometry(r_a, r_b)
    except InputError:
        return False
    home = np.array(HOME)
    length = options.length(r_b)
    g = without_unit(jacobian(geometry, home), length)
    sizes = np.linalg.svd(g, compute_uv=False)
    # dc/dα = (A_5 - p)·(e_z × n6) at home
    arm, axis = geometry.base[-1] - home[:3], geometry.axis
    slope = float(arm[1] * axis[0] - arm[0] * axis[1])
    if sizes[-1] <= _DEGENERATE * sizes[0] or abs(slope) <= _DEGENERATE * geometry.size:
        return False
    if out is not None:
        out["home_lci"][n] = sizes[-1] / sizes[0]
        out["home_least_singular_value"][n] = sizes[-1]
        columns = np.linalg.norm(np.linalg.inv(g), axis=0)
        out["home_largest_limb_force"][n] = columns[:-1].max()
    limbs = inverse_displacement(geometry, home)
    design = w.fibre.design
    design.base_joints[:], design.platform_joints[:], design.axis[:] = (
        geometry.base,
        geometry.platform,
        axis,
    )
    design.axis_offset[0] = geometry.platform[-1] @ axis
    design.home_directions[:] = limbs.directions
    design.least_square[:] = (options.limb_min * limbs.lengths) ** 2
    design.greatest_square[:] = (options.limb_max * limbs.lengths) ** 2
    design.base_cosine[0] = _cosine(options.base_joint_limit)
    design.platform_cosine[0] = _cosine(options.platform_joint_limit)
    design.branch[0] = math.copysign(1.0, slope)
    design.characteristic_length[0] = length
    set_orientation(w.fibre.pose, design, *(0.0, 1.0) * 3)
    set_position(w.fibre.pose, design, *HOME[:3])
    at_home = determinant_at(design, w.fibre.pose, np.array([0.0, 0.0, 1.0]), 0.0)
    design.determinant_sign[0] = math.copysign(1.0, at_home)
    _set_boxes(design, options)
    return True


def _cosine(angle: float) -> float:
    """Return the cosine of a joint limit, exactly -1 where there is none."""
    return -1.0 if angle >= math.pi else math.cos(angle)


def _set_boxes(design: Any, options: AtlasOptions) -> None:
    """Set the boxes of a design and what goes with them."""
    boxes = design.boxes
    boxes[_BOX] = options.box_least, options.box_greatest
    boxes[_VOLUME] = 0.0
    boxes[_VOLUME, :, :3] = [[-math.inf, -math.inf, 0.0], [math.inf, math.inf, math.inf]]
    boxes[_VOLUME, :, 3] = boxes[_BOX, :, 3]
    # a half turn is 2 by its sign, whatever rounding does to its sine
    design.alpha_range[:] = [
        math.copysign(2.0, angle)
        if abs(angle) >= math.pi
        else diamond_angle(math.sin(angle), math.cos(angle))
        for angle in boxes[_BOX, :, 3].tolist()
    ]
    last = design.base_joints[-1, :2]
    beside = last - np.clip(last, boxes[_BOX, 0, :2], boxes[_BOX, 1, :2])
    # no positions are in a box without ends that need no look
    design.nearest_square[:] = beside @ beside, -1.0
    design.box_volume[:] = np.prod(boxes[_BOX, 1, :3] - boxes[_BOX, 0, :3]), 1.0


def _most_levels(tolerance: float) -> int:
    """Return how many levels of points there are at this tolerance."""
    factor = min(max(1e-3 / tolerance, 1.0), _MOST_FACTOR)
    return next(n for n in range(100) if points_up_to(n) >= _MOST_POINTS * factor) + 1


def _evaluate_box(
    w: Work, thresholds: FloatArray, tolerance: float,
    out: dict[str, npt.NDArray[Any]], n: int,
) -> int:  # fmt: skip
    """Evaluate what is about the pose box; return the status."""
    sums = np.zeros((SCRAMBLINGS, SUMS + 2 * len(thresholds)))
    values = np.full((SCRAMBLINGS, 2), math.inf)
    coordinates = np.zeros((SCRAMBLINGS, 2, 5))
    status = 0
    for level in range(_most_levels(tolerance)):
        integrate(w, _BOX, points_of_level(level), thresholds, sums, values, coordinates)
        status = _set_means(sums, points_up_to(level), thresholds, tolerance, out, n)
        if status == 0:
            break
    has_singular = sums[:, SINGULAR].sum() > 0.0
    if sums[:, HITS].sum() > 0.0:
        has_singular = has_singular or _set_extremes(w, values, coordinates, out, n)
        if has_singular:
            out["least_singular_value"][n] = 0.0
            out["largest_limb_force"][n] = math.nan
    return status | (SINGULAR_POSES if has_singular else 0)


def _set_means(
    sums: FloatArray, points: int, thresholds: FloatArray, tolerance: float,
    out: dict[str, npt.NDArray[Any]], n: int,
) -> int:  # fmt: skip
    """Set shares and means from sums over so many points of each scrambling; return the status."""
    hits = float(sums[:, HITS].sum())
    unseen = _UNSEEN * float(sums[:, LARGEST].max()) / (SCRAMBLINGS * points)
    share, error = mean_and_error(sums[:, SHARE] / points)
    # an estimate without bias may be above 1, what it estimates is not
    out["usable_share"][n], out["usable_share_error"][n] = min(share, 1.0), max(error, unseen)
    allowed = _SHARE_TOLERANCES * tolerance
    status = 0 if max(error, unseen) <= allowed else SHARE_TOLERANCE_NOT_REACHED
    if hits == 0.0:
        out["good_condition_share_error"][n] = unseen
        return status | NO_USABLE_POSE
    few = _FEW / hits**2
    for name, column in (("gci", SHARE_LCI), ("mean_least_singular_value", SHARE_VALUE)):
        mean, error = ratio_and_error(sums[:, column], sums[:, SHARE])
        error += few * mean
        out[name][n], out[f"{name}_error"][n] = mean, error
        if not error <= tolerance * mean:
            status |= GCI_TOLERANCE_NOT_REACHED
    for t, threshold in enumerate(thresholds):
        parts = sums[:, SUMS + 2 * t]
        good, error = mean_and_error(parts / points)
        error = max(error, unseen)
        out["good_condition_share"][n, t] = min(good, 1.0)
        out["good_condition_share_error"][n, t] = error
        if error > allowed:
            status |= SHARE_TOLERANCE_NOT_REACHED
        if good > 0.0:
            mean, error = ratio_and_error(sums[:, SUMS + 2 * t + 1], parts)
            error += few * (share / good) ** 2 * mean
            # it is from the threshold to 1
            bound = max(mean - threshold, 1.0 - mean)
            out["good_condition_gci"][n, t] = mean
            out["good_condition_gci_error"][n, t] = min(error, bound)
    return status


def mean_and_error(values: FloatArray) -> tuple[float, float]:
    """Return the mean of independent unbiased estimates and its error, at 99.5 %."""
    mean = float(values.mean())
    return mean, _STUDENT * float(values.std(ddof=1)) / math.sqrt(len(values))


def ratio_and_error(above: FloatArray, below: FloatArray) -> tuple[float, float]:
    """Return the ratio of the means of pairs of estimates and its error, at 99.5 %.

    The error is linearised: that of the mean of the differences above - ratio below.
    """
    ratio = float(above.sum() / below.sum())
    _, error = mean_and_error(above - ratio * below)
    return ratio, error / float(below.mean())


def _set_extremes(
    w: Work, values: FloatArray, coordinates: FloatArray,
    out: dict[str, npt.NDArray[Any]], n: int,
) -> bool:  # fmt: skip
    """Search for extremes from the worst poses of scramblings; return if one is singular."""
    least = [math.inf, math.inf]
    worst = w.worst
    for which in (SINGULAR_VALUE, LIMB_FORCE):
        for start in np.argsort(values[:, which], kind="stable")[:_STARTS]:
            if not np.isfinite(values[start, which]):
                continue
            worst.value[:], worst.coordinates[:] = values[start], coordinates[start]
            if search_worst(w.fibre, w.poses, worst, which, deviates()):
                return True
            least[which] = min(least[which], float(worst.value[which]))
    out["least_singular_value"][n] = least[SINGULAR_VALUE]
    out["largest_limb_force"][n] = 1.0 / least[LIMB_FORCE]
    return False


def _evaluate_volume(w: Work, tolerance: float, out: dict[str, npt.NDArray[Any]], n: int) -> int:
    """Evaluate the workspace volume; return the status."""
    sums, none = np.zeros((SCRAMBLINGS, SUMS)), np.empty(0)
    values, coordinates = np.empty((SCRAMBLINGS, 2)), np.empty((SCRAMBLINGS, 2, 5))
    for level in range(_most_levels(tolerance)):
        integrate(w, _VOLUME, points_of_level(level), none, sums, values, coordinates)
        points = points_up_to(level)
        volume, error = mean_and_error(sums[:, SHARE] / points)
        if volume == 0.0:
            error = _UNSEEN * float(sums[:, LARGEST].max()) / (SCRAMBLINGS * points)
        out["workspace_volume"][n], out["workspace_volume_error"][n] = volume, error
        if error <= _SHARE_TOLERANCES * tolerance * volume:
            return 0
    return SHARE_TOLERANCE_NOT_REACHED
