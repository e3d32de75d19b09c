"""Quaternions w x y z of length 1 and vectors of one body, as tuples, for the compiled loops: R(q) turns body axes to space axes."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt
from typing import TypeVar, cast

from numba import njit

Quat = tuple[float, float, float, float]
Vector = tuple[float, float, float]
Function = TypeVar("Function", bound=Callable[..., object])


def compiled(function: Function) -> Function:
    """The same by Numba; division by zero gives no error but inf."""
    return cast(Function, njit(error_model="numpy", nogil=True)(function))


@compiled
def product(p: Quat, q: Quat) -> Quat:
    """p o q: R(p o q) = R(p) R(q)."""
    return (
        p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3],
        p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
        p[0] * q[2] - p[1] * q[3] + p[2] * q[0] + p[3] * q[1],
        p[0] * q[3] + p[1] * q[2] - p[2] * q[1] + p[3] * q[0],
    )


@compiled
def normalised(q: Quat) -> Quat:
    """Of length 1."""
    part = 1.0 / sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
    return q[0] * part, q[1] * part, q[2] * part, q[3] * part


@compiled
def turned_by(q: Quat, v: Vector, h: float) -> Quat:
    """N[q + h/2 (0, v) o q]: a first-order step of time h with the spin v in space."""
    d = product((0.0, v[0], v[1], v[2]), q)
    return normalised((q[0] + 0.5 * h * d[0], q[1] + 0.5 * h * d[1], q[2] + 0.5 * h * d[2], q[3] + 0.5 * h * d[3]))


@compiled
def turned_in_body(q: Quat, p: Quat, u: Vector, h: float) -> Quat:
    """N[q + h/2 p o (0, u)]: a first-order step from q with the spin u along the body axes of p."""
    d = product(p, (0.0, u[0], u[1], u[2]))
    return normalised((q[0] + 0.5 * h * d[0], q[1] + 0.5 * h * d[1], q[2] + 0.5 * h * d[2], q[3] + 0.5 * h * d[3]))


@compiled
def to_space(q: Quat, v: Vector) -> Vector:
    """R v."""
    w, x, y, z = q
    return (
        (w * w + x * x - y * y - z * z) * v[0] + 2.0 * (x * y - w * z) * v[1] + 2.0 * (x * z + w * y) * v[2],
        2.0 * (x * y + w * z) * v[0] + (w * w - x * x + y * y - z * z) * v[1] + 2.0 * (y * z - w * x) * v[2],
        2.0 * (x * z - w * y) * v[0] + 2.0 * (y * z + w * x) * v[1] + (w * w - x * x - y * y + z * z) * v[2],
    )


@compiled
def to_body(q: Quat, v: Vector) -> Vector:
    """R^T v."""
    return to_space((q[0], -q[1], -q[2], -q[3]), v)


@compiled
def spin_of(q: Quat, angmom: Vector, inertia: Vector) -> Vector:
    """omega = R I^-1 R^T L."""
    m = to_body(q, angmom)
    return to_space(q, (m[0] / inertia[0], m[1] / inertia[1], m[2] / inertia[2]))


@compiled
def pushed(v: Vector, force: Vector, h: float) -> Vector:
    """v + h force."""
    return v[0] + h * force[0], v[1] + h * force[1], v[2] + h * force[2]


@compiled
def dot(a: Vector, b: Vector) -> float:
    """a.b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def length(v: Vector) -> float:
    """|v|."""
    return sqrt(dot(v, v))
