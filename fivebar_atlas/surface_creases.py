"""Triangles of a workspace's boundary cut along its creases, where two limits meet.

Marching cubes know no creases: triangles across one cut it off. Here each side between corners on
different limits gets a point at which both slacks are 0, found by Newton's method, and each
triangle between three limits the corner in which they meet; triangles are then divided by limits.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fivebar_atlas.mechanisms.arrays import BoolArray, FloatArray, IntArray

#: Takes points, shape (n, 3); returns slacks, shape (n, limits).
Slacks = Callable[[FloatArray], FloatArray]

# Steps of Newton's method, that of its differences as a share of the reach, and what is 0.
_STEPS, _DIFFERENCE, _ROUNDING = 6, 1e-5, 1e-9


def cut_at_creases(
    slacks: Slacks, vertices: FloatArray, faces: IntArray, reach: float
) -> tuple[FloatArray, IntArray, IntArray, BoolArray]:
    """Return triangles of which each has one limit.

    Parameters
    ----------
    slacks
        The slacks.
    vertices
        Points on the boundary, shape (n, 3).
    faces
        Corners of triangles of a closed surface, shape (m, 3).
    reach
        Farthest that a crease may be from the side of a triangle across it.

    Returns
    -------
    vertices
        The same and then the new ones, shape (n + k, 3).
    faces
        Triangles in the same sense, shape (p, 3).
    limits
        The limit that makes each, shape (p,).
    is_exact
        Which vertices are on the boundary but for rounding, shape (n + k,).
    """
    at_vertices = slacks(vertices)
    own = at_vertices.argmin(axis=1)
    first = len(vertices)
    sides = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    is_cut = own[sides[..., 0]] != own[sides[..., 1]]
    pairs, places = np.unique(sides[is_cut], axis=0, return_inverse=True)
    points, exact = _meeting(
        slacks, vertices, at_vertices, pairs, np.column_stack([own[pairs[:, 0]], own[pairs[:, 1]]]),
        reach,
    )  # fmt: skip
    new = np.full(sides.shape[:2], -1, dtype=np.int64)
    new[is_cut] = first + places.ravel()
    count = is_cut.sum(axis=1)
    whole = faces[count == 0]
    kept, limits = [whole], [own[whole[:, 0]]]
    # two corners on one limit: the third is cut off, turned so that it is the first
    for turn in range(3):
        order = [turn, (turn + 1) % 3, (turn + 2) % 3]
        chosen = (count == 2) & ~is_cut[:, order[1]]
        a, b, c = faces[chosen][:, order].T
        ab, ca = new[chosen][:, order[0]], new[chosen][:, order[2]]
        pieces = ((a, ab, ca), (ab, b, c), (ab, c, ca))
        kept += [np.column_stack(corners) for corners in pieces]
        limits += [own[a], own[b], own[b]]
    corner = faces[count == 3]
    middles, middle_exact = _meeting(slacks, vertices, at_vertices, corner, own[corner], reach)
    centre = first + len(points) + np.arange(len(corner))
    for one in range(3):
        after, before = new[count == 3][:, one], new[count == 3][:, (one + 2) % 3]
        kept.append(np.column_stack([corner[:, one], after, centre]))
        kept.append(np.column_stack([corner[:, one], centre, before]))
        limits += [own[corner[:, one]]] * 2
    together = np.vstack([vertices, points, middles])
    is_exact = np.concatenate([np.ones(first, dtype=np.bool_), exact, middle_exact])
    return together, np.vstack(kept), np.concatenate(limits), is_exact


def _meeting(
    slacks: Slacks,
    vertices: FloatArray,
    at_vertices: FloatArray,
    groups: IntArray,
    limits: IntArray,
    reach: float,
) -> tuple[FloatArray, BoolArray]:
    """Return points where two or three limits meet, near sides or triangles.

    Parameters
    ----------
    groups
        Vertices of each, shape (k, 2) or (k, 3).
    limits
        Their limits, of the same shape.

    Returns
    -------
    points
        Shape (k, 3); where the limits do not meet there, the middle.
    is_exact
        Where they do and no other limit is exceeded, shape (k,).
    """
    number = groups.shape[1]
    if number == 2:
        # where the slacks are equal if they are linear along the side
        rows = np.arange(len(groups))
        gaps = [
            at_vertices[groups[:, end], limits[:, 1]] - at_vertices[groups[:, end], limits[:, 0]]
            for end in (0, 1)
        ]
        total = gaps[0] - gaps[1]
        share = np.where(total > 0.0, gaps[0] / np.where(total > 0.0, total, 1.0), 0.5)[:, None]
        start = vertices[groups[rows, 0]] * (1.0 - share) + vertices[groups[rows, 1]] * share
    else:
        start = vertices[groups].mean(axis=1)
    if not len(groups):
        return start.reshape(0, 3), np.empty(0, dtype=np.bool_)
    points = start.copy()
    step = _DIFFERENCE * reach
    for _ in range(_STEPS):
        values = np.take_along_axis(slacks(points), limits, axis=1)
        slopes = np.stack(
            [
                np.take_along_axis(slacks(points + shift) - slacks(points - shift), limits, axis=1)
                for shift in step * np.eye(3)
            ],
            axis=-1,
        ) / (2.0 * step)
        moves = -(np.linalg.pinv(slopes, rcond=1e-6) @ values[..., None])[..., 0]
        sizes = np.linalg.norm(moves, axis=1)
        # a step that is too long is cut
        points = (
            points + moves * np.minimum(1.0, reach / np.where(sizes > 0.0, sizes, 1.0))[:, None]
        )
    values = slacks(points)
    closed = np.abs(np.take_along_axis(values, limits, axis=1)).max(axis=1) <= _ROUNDING
    is_exact = closed & (values.min(axis=1) >= -_ROUNDING)
    is_exact &= np.linalg.norm(points - start, axis=1) <= reach
    return np.where(is_exact[:, None], points, start), is_exact
