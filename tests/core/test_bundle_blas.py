"""NumPy's OpenBLAS answers what OpenCV asks of its own, by `resources/packaging/blas.c`."""

import ctypes
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from kogao_resources import packaging

REALS = {"s": np.float32, "d": np.float64}
TALL, WIDE = 150, 120


@pytest.fixture(scope="module")
def blas(tmp_path_factory):
    found = sorted(Path(np.__file__).parents[1].glob("numpy.libs/libscipy_openblas64_*"))
    if not sys.platform.startswith("linux") or shutil.which("gcc") is None or not found:
        pytest.skip("needs Linux, gcc and NumPy as its wheel brings it")
    made = tmp_path_factory.mktemp("blas") / "blas.so"
    source = Path(packaging.__file__).with_name("blas.c")
    command = ["gcc", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-Wl,-z,defs"]
    command += ["-o", made, source, *found, f"-Wl,-rpath,{found[0].parent}"]
    subprocess.run(command, check=True)
    return ctypes.CDLL(str(made))


@pytest.fixture(params=REALS)
def case(request, blas):
    """Functions of a precision, and matrices as Fortran has them: any, and positive definite."""
    rng = np.random.default_rng(1)
    a = np.asfortranarray(rng.normal(size=(TALL, WIDE)), REALS[request.param])
    definite = np.asfortranarray(a.T @ a + np.eye(WIDE), REALS[request.param])
    return lambda name, *given: _call(blas, f"{request.param}{name}_", *given), a, definite


def _call(blas, name, *given):
    """Call a function of LAPACK; its last argument, info, is answered."""
    info = ctypes.c_int32(-99)
    sent = [
        ctypes.byref(ctypes.c_int32(one)) if isinstance(one, int)
        else one if isinstance(one, bytes)
        else ctypes.c_void_p(one.ctypes.data)
        for one in given
    ]  # fmt: skip
    getattr(blas, name)(*sent, ctypes.byref(info))
    return info.value


def _close(one, other):
    eps = np.finfo(one.dtype).eps
    np.testing.assert_allclose(one, other, rtol=0, atol=1e4 * eps * np.abs(other).max())


def _work(a, rows=64 * TALL):
    return np.zeros(rows, a.dtype)


def _columns(a, count=3):
    return np.asfortranarray(np.random.default_rng(2).normal(size=(len(a), count)), a.dtype)


def test_equations_are_solved_and_pivots_come_back(case):
    call, a, _ = case
    square = a[:WIDE].copy(order="F")
    given, pivots = square.copy(order="F"), np.full(WIDE, -1, np.int32)
    right = _columns(square)
    x = right.copy(order="F")
    assert call("gesv", WIDE, 3, given, WIDE, pivots, x, WIDE) == 0
    _close(square @ x, right)
    assert pivots.min() >= 1
    assert pivots.max() <= WIDE
    again, same = square.copy(order="F"), np.zeros(WIDE, np.int32)
    assert call("getrf", WIDE, WIDE, again, WIDE, same) == 0
    _close(again, given)
    np.testing.assert_array_equal(same, pivots)


def test_what_cannot_be_solved_is_said(case):
    call, a, definite = case
    zeros, pivots = np.zeros((WIDE, WIDE), a.dtype, "F"), np.zeros(WIDE, np.int32)
    assert call("gesv", WIDE, 3, zeros, WIDE, pivots, _columns(definite), WIDE) == 1
    assert call("potrf", b"L", WIDE, -definite, WIDE) == 1


def test_positive_definite_equations_are_solved(case):
    call, _, definite = case
    right = _columns(definite)
    given, x = definite.copy(order="F"), right.copy(order="F")
    assert call("posv", b"L", WIDE, 3, given, WIDE, x, WIDE) == 0
    _close(definite @ x, right)
    again = definite.copy(order="F")
    assert call("potrf", b"L", WIDE, again, WIDE) == 0
    _close(np.tril(again) @ np.tril(again).T, definite)


def test_least_squares_and_reflections_agree(case):
    call, a, _ = case
    right = _columns(a)
    given, x = a.copy(order="F"), right.copy(order="F")
    work = _work(a)
    assert call("gels", b"N", TALL, WIDE, 3, given, TALL, x, TALL, work, len(work)) == 0
    _close(x[:WIDE], np.linalg.lstsq(a, right, rcond=None)[0])
    factors, tau = a.copy(order="F"), np.zeros(WIDE, a.dtype)
    assert call("geqrf", TALL, WIDE, factors, TALL, tau, work, len(work)) == 0
    _close(np.abs(np.triu(factors[:WIDE])), np.abs(np.linalg.qr(a)[1]))


def test_singular_values_are_found(case):
    call, a, _ = case
    given, s = a.copy(order="F"), np.zeros(WIDE, a.dtype)
    u, vt = np.zeros((TALL, WIDE), a.dtype, "F"), np.zeros((WIDE, WIDE), a.dtype, "F")
    work, scratch = _work(a, 8 * WIDE * WIDE), np.full(8 * WIDE, -1, np.int32)
    sizes = (s, u, TALL, vt, WIDE, work, len(work), scratch)
    assert call("gesdd", b"S", TALL, WIDE, given, TALL, *sizes) == 0
    _close(u * s @ vt, a)


def test_eigenvalues_are_found(blas):
    a = np.asfortranarray(np.random.default_rng(1).normal(size=(WIDE, WIDE)))
    re, im, work = np.zeros(WIDE), np.zeros(WIDE), _work(a)
    sides = (np.zeros(1), 1, np.zeros(1), 1)
    given = (a.copy(order="F"), WIDE, re, im, *sides, work, len(work))
    assert _call(blas, "dgeev_", b"N", b"N", WIDE, *given) == 0
    _close(np.sort_complex(re + 1j * im), np.sort_complex(np.linalg.eigvals(a)))


@pytest.mark.parametrize("letter", "sdcz")
def test_matrices_are_multiplied(blas, letter):
    rng = np.random.default_rng(1)
    kind = {**REALS, "c": np.complex64, "z": np.complex128}[letter]
    a, b, c = ((rng.normal(size=(30, 30, 2)) @ [1, 1j]) for _ in range(3))
    a, b, c = ((one if letter in "cz" else one.real).astype(kind) for one in (a, b, c))
    real = {"s": ctypes.c_float, "d": ctypes.c_double}.get(letter)
    size, row_major, as_it_is = ctypes.c_int32(30), 101, 111
    expected = 2 * a @ b + 3 * c
    held = np.array([2, 3], kind)
    alpha, beta = (
        (real(2), real(3)) if real else (ctypes.c_void_p(held[at:].ctypes.data) for at in (0, 1))
    )
    getattr(blas, f"cblas_{letter}gemm")(
        row_major, as_it_is, as_it_is, size, size, size, alpha, ctypes.c_void_p(a.ctypes.data),
        size, ctypes.c_void_p(b.ctypes.data), size, beta, ctypes.c_void_p(c.ctypes.data), size,
    )  # fmt: skip
    _close(c, expected)
