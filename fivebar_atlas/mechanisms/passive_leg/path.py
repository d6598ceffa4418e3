"""Whether a manipulator with a passive leg can follow a path of straight segments in one mode pair.

A path that begins in the usable workspace leaves it at the first point where a leg is straight,
J_x is singular, or a passive joint is at its limit. Between its corners nothing is sampled: a piece
of a segment is done with where the bounds of :mod:`containment` say that there is no such point on
it, and is halved otherwise, until all pieces are done with or one is left that
is shorter than ``TOUCH``. The same bounds tell that inputs turn by less than a radian on a piece,
so that they are continuous along the path.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from fivebar_atlas.mechanisms.arrays import FloatArray
from fivebar_atlas.mechanisms.mode_pairs import mode_signs
from fivebar_atlas.mechanisms.passive_leg.loci import (
    FOLDED,
    LEVEL_LINKS,
    PASSIVE_LEG,
    SINGULAR_PLATFORM,
    STRETCHED,
    Curve,
)
from fivebar_atlas.mechanisms.passive_leg.outline import UsableWorkspace
from fivebar_atlas.mechanisms.paths import checked_corners, columns, nearest_of
from fivebar_atlas.mechanisms.planar import PathFault, PathReport
from fivebar_atlas.planar_geometry import LIMIT, PolylineArc

if TYPE_CHECKING:
    from fivebar_atlas.mechanisms.passive_leg.passive_leg import PassiveLeg

#: What comes closer than this to a singular point or a limit, R = 1, counts as on it.
TOUCH = 1e-12

# Pieces that segments are cut into at first are no longer than this; those of this length that are
# still open meet something.
_FIRST, _SHORTEST = 0.05, 1e-13
# Pieces that are looked at together.
_BLOCK = 4096
# Inputs turn by less than this, in radians, from the middle to an end of a piece.
_LARGEST_TURN = 1.0
# What margins are of, in their order.
_O = Curve("O", "$O$", "serial", "the passive leg has no length")
_CURVES = (_O, PASSIVE_LEG, *STRETCHED, *FOLDED, *LEVEL_LINKS, SINGULAR_PLATFORM)


def check_path(design: PassiveLeg, mode: str, points: npt.ArrayLike) -> PathReport:
    """Tell whether a path can be followed in a mode pair, exactly between its corners too.

    A path is feasible if all its points lie in the usable workspace, farther than ``TOUCH`` from
    its boundary. Corners may repeat.

    Parameters
    ----------
    design
        The design.
    mode
        Canonical label of a mode pair.
    points
        Corners, shape (n, 2), joined by straight segments.

    Returns
    -------
    PathReport
        Input angles in radians: in (-π, π] at the first corner, and continuous along the path from
        there. Distances are those from the boundary of the usable workspace.

    Raises
    ------
    InputError
        If there are no points, or not two finite coordinates for each.
    """
    corners = checked_corners(points)
    workspace = design.usable_workspace(mode)
    inputs = np.full((len(corners), 2), np.nan)
    lci, distances = np.full(len(corners), np.nan), np.full(len(corners), np.nan)
    nearest = [""] * len(corners)
    fault = _fault_at_start(design, mode, workspace, corners[0])
    if fault is None and workspace is not None:
        pieces, fault = _followed(design, mode, corners)
        count = len(corners) if fault is None else fault.segment + (fault.share > 0.0)
        reached = corners[:count]
        inputs[:count] = _input_angles(design, mode, corners, pieces, count)
        lci[:count] = design.lci(*columns(reached), mode)
        distances[:count], nearest[:count] = boundary_distances(design, workspace, reached)
    return PathReport(mode, corners, inputs, lci, distances, tuple(nearest), fault)


def boundary_distances(
    design: PassiveLeg, workspace: UsableWorkspace, points: FloatArray
) -> tuple[FloatArray, list[str]]:
    """Return how far points of a workspace are from its boundary, and the name of what is next.

    Isolated singular points count as boundary.
    """
    # segments first, whose distance is in closed form
    arcs = sorted(workspace.region.arcs, key=lambda each: not isinstance(each.arc, PolylineArc))
    isolated = [
        (_O.name if point == (0.0, 0.0) else FOLDED[0 if point[0] > 0.0 else 1].name, point)
        for point in design.isolated_singular_points()
    ]
    return nearest_of(arcs, isolated, points)


@dataclasses.dataclass(frozen=True, slots=True)
class _Pieces:
    """Pieces of a path: number of the segment, and shares of it where they begin and end."""

    segment: npt.NDArray[np.int64]
    low: FloatArray
    high: FloatArray

    def of(self, chosen: npt.NDArray[np.bool_]) -> _Pieces:
        return _Pieces(self.segment[chosen], self.low[chosen], self.high[chosen])

    def before(self, stop: tuple[int, float] | None) -> _Pieces:
        """Return the pieces that begin before a place on the path."""
        if stop is None:
            return self
        segment, share = stop
        return self.of((self.segment < segment) | ((self.segment == segment) & (self.low < share)))

    @property
    def middle(self) -> FloatArray:
        return 0.5 * (self.low + self.high)

    def halved(self) -> _Pieces:
        """Return both halves of every piece, in order."""
        ends = np.stack([self.low, self.middle, self.high], axis=1)
        return _Pieces(np.repeat(self.segment, 2), ends[:, :-1].ravel(), ends[:, 1:].ravel())

    def points(self, corners: FloatArray, share: FloatArray) -> FloatArray:
        """Return points at shares of the segments, shape (n, 2)."""
        starts, ends = corners[self.segment], corners[self.segment + 1]
        return np.asarray(starts + share[:, None] * (ends - starts))


def _together(pieces: Sequence[_Pieces]) -> _Pieces:
    """Return all pieces of several lots in order."""
    if not pieces:
        return _Pieces(np.empty(0, np.int64), np.empty(0), np.empty(0))
    return _Pieces(
        np.concatenate([each.segment for each in pieces]),
        np.concatenate([each.low for each in pieces]),
        np.concatenate([each.high for each in pieces]),
    )


def _first_pieces(corners: FloatArray) -> _Pieces:
    """Cut all segments into pieces of moderate length."""
    lengths = np.hypot(*np.diff(corners, axis=0).T)
    counts = np.maximum(np.ceil(lengths / _FIRST), 1.0).astype(np.int64)
    segment = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(segment)) - np.repeat(np.cumsum(counts) - counts, counts)
    return _Pieces(segment, number / counts[segment], (number + 1) / counts[segment])


def _followed(
    design: PassiveLeg, mode: str, corners: FloatArray
) -> tuple[_Pieces, PathFault | None]:
    """Return pieces that are free of singularities and limits up to the first fault, if any."""
    done: list[_Pieces] = []
    stop: tuple[int, float] | None = None  # segment and share from which on nothing matters
    open_ones = _first_pieces(corners) if len(corners) > 1 else None
    lengths = np.hypot(*np.diff(corners, axis=0).T)
    while open_ones is not None and len(open_ones.segment):
        place = np.arange(len(open_ones.segment))
        later, open_ones = open_ones.of(place >= _BLOCK), open_ones.of(place < _BLOCK)
        width = (open_ones.high - open_ones.low) * lengths[open_ones.segment]
        least, turns = design.bounds_on_segments(
            open_ones.points(corners, open_ones.low),
            open_ones.points(corners, open_ones.high),
            mode,
        )
        is_done = (least > 0.0) & (turns.max(axis=1) < _LARGEST_TURN)
        done.append(open_ones.of(is_done))
        left, width = open_ones.of(~is_done), width[~is_done]
        # the first place that is bad, or a piece that is too short to be anything else
        bad = _is_bad(design, mode, left.points(corners, left.high)) | (width <= _SHORTEST)
        bad_middle = _is_bad(design, mode, left.points(corners, left.middle))
        found = np.flatnonzero(bad | bad_middle)
        if found.size:
            first = int(found[0])
            share = float((left.middle if bad_middle[first] else left.high)[first])
            stop = (int(left.segment[first]), share)
        open_ones = _together([left.of(width > _SHORTEST).halved(), later]).before(stop)
    together = _together(done).before(stop)
    if stop is None:
        return together, None
    segment, share = stop
    position = corners[segment] + share * (corners[segment + 1] - corners[segment])
    return together, _fault(design, mode, segment, share, position)


def _margins(design: PassiveLeg, mode: str, points: FloatArray) -> FloatArray:
    """Return how far poses are from what ends a workspace, shape (n, 9), in lengths.

    In the order of ``_CURVES``: l, and that times the angle to the limit; distances of the legs
    from being stretched and folded; heights of the platform over the elbows, infinite where they
    do not matter; l det J_x in the mode pair over links, positive if right. The last ones are
    infinite where a leg does not reach.
    """
    signs = mode_signs(mode)
    x, y = columns(points)
    length, theta = np.hypot(x, y), np.arctan2(-x, y)
    c, s = np.cos(theta), np.sin(theta)
    outer, inner = design.l_a + design.l_b, abs(design.l_a - design.l_b)
    reaches = [np.hypot(design.r - c, length + leg * s) for leg in (1.0, -1.0)]
    p1, q1, p2, q2 = design.upper_links(x, y, mode).T
    sizes = design.l_b * (length + 2.0 * design.r)
    f = length * (p1 * q2 - p2 * q1) - 2.0 * design.r * q1 * q2
    heights = (q1, q2) if design.passive_joint_limits else (np.inf + 0.0 * q1, np.inf + 0.0 * q2)
    margins = [
        length,
        (design.theta_limit - np.abs(theta)) * length,
        *(outer - reach for reach in reaches),
        *(reach - inner for reach in reaches),
        *heights,
        -signs[2] * f / sizes,
    ]
    together = np.stack(margins, axis=1)
    return np.where(np.isnan(together), np.inf, together)


def _is_bad(design: PassiveLeg, mode: str, points: FloatArray) -> npt.NDArray[np.bool_]:
    """Tell which points are singular, at a limit, or beyond."""
    return np.asarray(_margins(design, mode, points).min(axis=1, initial=np.inf) <= TOUCH)


def _fault_at_start(
    design: PassiveLeg, mode: str, workspace: UsableWorkspace | None, start: FloatArray
) -> PathFault | None:
    """Return why a path cannot begin at a point, None if it can."""
    x, y = (float(each) for each in start)

    def fault(phrase: str, gap: float = 0.0) -> PathFault:
        return PathFault(0, 0.0, (x, y), "", "", "", phrase, gap)

    if workspace is None:
        return fault(f"the usable workspace of {mode} is empty")
    margins = _margins(design, mode, start[None])[0]
    if margins[0] > TOUCH and margins[1] < -TOUCH:
        return fault("the passive leg is beyond its limit")
    reaching = margins[2:6]
    worst = int(np.argmin(reaching))
    if reaching[worst] < -TOUCH:
        leg, near = 1 + worst % 2, f", b{1 + worst % 2} too near to B{1 + worst % 2}"
        phrase = f"C is out of reach of leg {leg}{near if worst >= 2 else ''}, by {{gap}}"
        return fault(phrase, -float(reaching[worst]))
    if margins[8] < -TOUCH:
        return fault("C lies in the other assembly mode")
    if margins[6:8].min() < -TOUCH:
        leg = 1 + int(np.argmin(margins[6:8]))
        return fault(f"the upper link of leg {leg} is above the platform")
    if margins.min() <= TOUCH:
        return _fault(design, mode, 0, 0.0, start)
    if not workspace.contains(x, y):
        return fault(
            "C lies in another part of the workspace, not connected with the usable workspace"
        )
    return None


def _fault(
    design: PassiveLeg, mode: str, segment: int, share: float, position: FloatArray
) -> PathFault:
    """Return the fault at a point on a singular locus or at a limit."""
    curve = _CURVES[int(np.argmin(_margins(design, mode, position[None])[0]))]
    x, y = (float(each) for each in position)
    phrase = f"meets {curve.name}: {curve.reason}"
    kind = "" if curve.kind == LIMIT else curve.kind  # a limit is no singularity
    return PathFault(segment, share, (x, y), curve.name, curve.symbol, kind, phrase)


def _input_angles(
    design: PassiveLeg, mode: str, corners: FloatArray, pieces: _Pieces, count: int
) -> FloatArray:
    """Return input angles at the first corners, shape (count, 2), continuous along the path."""
    if count == 1:
        return design.inputs(*columns(corners[:1]), mode)
    places = np.concatenate([pieces.segment + pieces.low, pieces.segment + pieces.middle])
    points = np.concatenate(
        [pieces.points(corners, pieces.low), pieces.points(corners, pieces.middle)]
    )
    keep = places < count - 1
    places = np.concatenate([places[keep], np.arange(count, dtype=np.float64)])
    points = np.concatenate([points[keep], corners[:count]])
    order = np.argsort(places, kind="stable")
    angles = np.unwrap(design.inputs(*columns(points[order]), mode), axis=0)
    found = np.empty_like(angles)
    found[order] = angles
    at_corners = found[-count:]
    # whole turns are not counted before the path begins
    first = design.inputs(*columns(corners[:1]), mode)[0]
    return np.asarray(at_corners - np.round((at_corners[0] - first) / (2 * np.pi)) * 2 * np.pi)
