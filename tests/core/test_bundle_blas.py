"""OpenCV computes with NumPy's OpenBLAS by `resources/packaging/blas.c`, as in the bundle."""

import os
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import cv2
import numpy as np
import pytest
from kogao_resources import packaging

# Matrices large enough for LAPACK; E of two views takes eigenvalues.
COMPUTING = """
    import cv2, numpy as np
    libraries = open("/proc/self/maps").read()
    assert "our-blas" in libraries and "libopenblas" not in libraries.replace("openblas64", "")
    for kind in (np.float32, np.float64):
        rng = np.random.default_rng(1)
        a, right = (rng.normal(size=(150, size)).astype(kind) for size in (120, 3))
        close = dict(rtol=0, atol=1e4 * np.finfo(kind).eps)
        definite = a.T @ a / 150 + np.eye(120, dtype=kind)
        ways = ((cv2.DECOMP_LU, a[:120]), (cv2.DECOMP_CHOLESKY, definite), (cv2.DECOMP_QR, a),
                (cv2.DECOMP_SVD, a))
        for way, matrix in ways:
            _, x = cv2.solve(matrix, right[: len(matrix)], flags=way)
            expected = np.linalg.lstsq(matrix, right[: len(matrix)], rcond=None)[0]
            np.testing.assert_allclose(x, expected, rtol=0, atol=close["atol"] * 10)
        assert not cv2.solve(np.zeros((120, 120), kind), right[:120], flags=cv2.DECOMP_LU)[0]
        assert not cv2.solve(-definite, right[:120], flags=cv2.DECOMP_CHOLESKY)[0]
        w, u, vt = cv2.SVDecomp(a)
        np.testing.assert_allclose(u * w.T @ vt, a, **close)
        np.testing.assert_allclose(
            cv2.gemm(a, definite, 2.0, a, 3.0), 2 * a @ definite + 3 * a, rtol=0,
            atol=close["atol"] * 10)
        b, c = (rng.normal(size=(120, 120, 2)).astype(kind) for _ in range(2))
        found = cv2.gemm(b, c, 2.0, None, 0.0) @ [1, 1j]
        np.testing.assert_allclose(found, 2 * (b @ [1, 1j]) @ (c @ [1, 1j]), rtol=0,
                                   atol=close["atol"] * 100)
    places = rng.uniform((-1, -1, 4), (1, 1, 8), (60, 3))
    turn, _ = cv2.Rodrigues(np.array([0.1, -0.2, 0.05]))
    first, second = (one[:, :2] / one[:, 2:] for one in (places, places @ turn.T + [1, 0.2, 0.1]))
    essential, _ = cv2.findEssentialMat(first, second, np.eye(3), method=cv2.USAC_DEFAULT)
    ones = np.ones((60, 1))
    off = np.sum(np.hstack([second, ones]) @ essential * np.hstack([first, ones]), axis=1)
    assert np.median(np.abs(off)) < 1e-6
"""


def test_opencv_computes_with_numpys_library(tmp_path):
    site = Path(np.__file__).parents[1]
    found = sorted(site.glob("numpy.libs/libscipy_openblas64_*"))
    (replaced, *_) = [*Path(cv2.__file__).parents[1].glob("opencv_*.libs/libopenblas*"), None]
    if not sys.platform.startswith("linux") or not shutil.which("gcc") or not (found and replaced):
        pytest.skip("needs Linux, gcc, and NumPy and OpenCV as their wheels bring them")
    made, source = tmp_path / "our-blas.so", Path(packaging.__file__).with_name("blas.c")
    command = ["gcc", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", "-Wl,-z,defs"]
    command += [f"-Wl,-soname,{replaced.name}", "-o", made, source, *found]
    subprocess.run([*command, f"-Wl,-rpath,{found[0].parent}"], check=True)
    program = [sys.executable, "-c", textwrap.dedent(COMPUTING)]
    subprocess.run(program, check=True, env=os.environ | {"LD_PRELOAD": str(made)})
