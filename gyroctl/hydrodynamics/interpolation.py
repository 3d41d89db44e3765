"""Cubic spline in plain numpy: twice continuously differentiable, real or complex values, along the last axis.

scipy's would do, but importing scipy.interpolate costs more than everything else in this package together.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def spline(x: NDArray[np.float64], y: NDArray[Any], at: NDArray[np.float64]) -> NDArray[Any]:
    """Values at `at` of the cubic spline through (x, y), its end slopes those of the parabolas through three points.

    Parameters
    ----------
    x : ndarray (n,)
        Increasing abscissae; two give a straight line, one a constant.
    y : ndarray (..., n)
        Ordinates, real or complex. Interpolating real and imaginary parts is safe here because every table is referred
        to the centre of the float, so that phases turn slowly; a phase of its own would need unwrapping, and has no
        value at zeros.
    at : ndarray (m,)
        Where to evaluate, within [x[0], x[-1]].

    Returns
    -------
    ndarray (..., m)
    """
    n = len(x)
    if n == 1:
        return np.repeat(y, len(at), axis=-1)
    h = np.diff(x)
    chord = np.diff(y, axis=-1) / h
    slopes = _slopes(h, chord) if n > 2 else np.repeat(chord, 2, axis=-1)
    i = np.clip(np.searchsorted(x, at, side="right") - 1, 0, n - 2)
    t, hi = (at - x[i]) / h[i], h[i]
    left, right = slopes[..., i], slopes[..., i + 1]
    rise = chord[..., i]
    bend = (3.0 * rise - 2.0 * left - right) + t * (left + right - 2.0 * rise)
    return np.asarray(y[..., i] + hi * t * (left + t * bend))


def _slopes(h: NDArray[np.float64], chord: NDArray[Any]) -> NDArray[Any]:
    """Slopes at the knots that make the second derivative continuous."""
    n = len(h) + 1
    matrix = np.zeros((n, n))
    right = np.zeros((*chord.shape[:-1], n), dtype=chord.dtype)
    inner = np.arange(1, n - 1)
    matrix[inner, inner - 1] = h[1:]
    matrix[inner, inner] = 2.0 * (h[1:] + h[:-1])
    matrix[inner, inner + 1] = h[:-1]
    right[..., 1:-1] = 3.0 * (h[1:] * chord[..., :-1] + h[:-1] * chord[..., 1:])
    matrix[0, 0] = matrix[-1, -1] = 1.0
    right[..., 0] = chord[..., 0] + (chord[..., 0] - chord[..., 1]) * h[0] / (h[0] + h[1])
    right[..., -1] = chord[..., -1] + (chord[..., -1] - chord[..., -2]) * h[-1] / (h[-1] + h[-2])
    columns = np.moveaxis(right, -1, 0)
    return np.moveaxis(np.linalg.solve(matrix, columns.reshape(n, -1)).reshape(columns.shape), 0, -1)
