"""Evidence files: the numbers behind a warped photo, as one compressed ``.npz`` file.

An evidence file holds no pixels of the photo. numpy reads the file without Kogao; all texts are
JSON. docs/python.md says what each array holds.
"""

from __future__ import annotations

import hashlib
import io
import json
import os
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final, get_args

import numpy as np
import numpy.typing as npt

from kogao_core import __version__
from kogao_core.base.atomic import atomic_write
from kogao_core.base.geometry import Array, Box, Image
from kogao_core.base.json_reader import BadFile
from kogao_core.base.wording import system_reason
from kogao_core.faces.targets import FacePairs
from kogao_core.field.field import Field
from kogao_core.paper.domain import mask_of
from kogao_core.paper.lattice import Grid, Lattice
from kogao_core.recipe.recipe import Recipe
from kogao_core.recipe.settings import DomainName

VERSION: Final = 1


@dataclass(frozen=True, eq=False, kw_only=True)
class Evidence:
    """The numbers behind a warped photo, as `Rendering.save_evidence` writes them.

    Parameters
    ----------
    points_px, targets_px : array of shape (N, 2)
        Landmarks of all outlines and their targets, px.
    face : array of shape (N,)
        Index of each point's face, from 0.
    centers_px : array of shape (F, 2)
        Centre of each face, px.
    lattices : tuple of Lattice
        Control points with origin and spacing; displacements add up.
    displacement_px : float32 array of shape (H, W, 2)
        Backward displacement of every pixel, px.
    det_j : float32 array of shape (H, W)
        Jacobian determinant; below 1 stretched, 0 or less folded.
    masks : dict
        The three domains of section 4 by name, bool arrays of shape (H, W).
    recipe : Recipe
        The choices.
    made : dict
        Versions, time and hashes.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> face = kogao.template_face((450, 480), 400)
    >>> kogao.render(photo.pixels, [face], kogao.Recipe(percent=5)).save_evidence("five.npz")
    >>> evidence = kogao.load_evidence("five.npz")
    >>> evidence.displacement_px.shape, sorted(evidence.masks)
    ((900, 900, 2), ['control-points', 'image', 'threshold'])
    """

    points_px: Array
    targets_px: Array
    face: npt.NDArray[np.intp]
    centers_px: Array
    lattices: tuple[Lattice, ...]
    displacement_px: npt.NDArray[np.float32]
    det_j: npt.NDArray[np.float32]
    masks: Mapping[DomainName, npt.NDArray[np.bool_]]
    recipe: Recipe
    made: Mapping[str, Any]

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the photo, px."""
        return self.det_j.shape[1], self.det_j.shape[0]


def gathered(
    field: Field,
    pairs: Sequence[FacePairs],
    image: Box,
    recipe: Recipe,
    threshold_px: float,
    result: Image,
    photo_sha256: str = "",
) -> Evidence:
    """Evaluate a field at every pixel, and return the values with points, recipe and hashes."""
    from kogao_core.base.machine import machine, networks

    xs, ys = np.arange(float(image.width)), np.arange(float(image.height))
    made = {
        "version": VERSION,
        "kogao": __version__,
        **machine(),
        "networks": networks(),
        "time": datetime.now(UTC).isoformat(timespec="seconds"),
        "photo_sha256": photo_sha256,
        "result_sha256": hashlib.sha256(np.ascontiguousarray(result).tobytes()).hexdigest(),
    }
    lengths = [len(pair.source_px) for pair in pairs]
    return Evidence(
        points_px=np.vstack([np.empty((0, 2)), *(pair.source_px for pair in pairs)]),
        targets_px=np.vstack([np.empty((0, 2)), *(pair.target_px for pair in pairs)]),
        face=np.repeat(np.arange(len(pairs)), lengths),
        centers_px=np.array([pair.center_px for pair in pairs]).reshape(-1, 2),
        lattices=field.lattices,
        displacement_px=field.on_grid(xs, ys).transpose(1, 2, 0).astype(np.float32),
        det_j=field.det_jacobian(xs, ys).astype(np.float32),
        masks={
            name: mask_of(field.lattices, image, name, threshold_px)
            for name in get_args(DomainName)
        },
        recipe=recipe,
        made=made,
    )


def to_bytes(evidence: Evidence) -> bytes:
    """Return an evidence file."""
    arrays: dict[str, Any] = {
        name: getattr(evidence, name)
        for name in ("points_px", "targets_px", "face", "centers_px", "displacement_px", "det_j")
    }
    for number, lattice in enumerate(evidence.lattices):
        arrays |= {
            f"phi_{number}": lattice.phi,
            f"origin_px_{number}": np.array(lattice.grid.origin_px),
            f"first_{number}": np.array(lattice.first),
            f"spacing_px_{number}": np.array(lattice.grid.spacing_px),
        }
    arrays |= {_domain(name): mask for name, mask in evidence.masks.items()}
    arrays["recipe"] = np.array(json.dumps(evidence.recipe.to_dict()))
    arrays["made"] = np.array(json.dumps(dict(evidence.made)))
    out = io.BytesIO()
    np.savez_compressed(out, **arrays)
    return out.getvalue()


def save(evidence: Evidence, path: str | os.PathLike[str]) -> None:
    """Write an evidence file; an existing file is replaced."""
    atomic_write(to_bytes(evidence), Path(path))


def load(path: str | os.PathLike[str]) -> Evidence:
    """Read an evidence file.

    Parameters
    ----------
    path : str or path
        A file that `Rendering.save_evidence`, the editor or ``kogao-cli warp --evidence`` wrote.

    Returns
    -------
    Evidence
        The numbers behind a warped photo.

    Raises
    ------
    BadFile
        If the file can't be read or is not an evidence file.

    Examples
    --------
    >>> import kogao_core as kogao
    >>> photo = kogao.read(kogao.sample())
    >>> face = kogao.template_face((450, 480), 400)
    >>> kogao.render(photo.pixels, [face], kogao.Recipe(percent=5)).save_evidence("five.npz")
    >>> float(kogao.load_evidence("five.npz").det_j.min()) > 0.5
    True
    """
    try:
        # Without pickles a file can't run code.
        with Path(path).open("rb") as data, np.load(data, allow_pickle=False) as file:
            return _read(file)
    except OSError as error:
        raise BadFile(
            "{path} can't be read ({reason})", path=path, reason=system_reason(error)
        ) from None
    except (KeyError, TypeError, ValueError, zipfile.BadZipFile, EOFError) as error:
        raise BadFile("{path} is not an evidence file ({error})", path=path, error=error) from None


def _read(file: Any) -> Evidence:
    made = json.loads(str(file["made"]))
    if made["version"] != VERSION:
        raise ValueError("another version")
    displacement, det_j = file["displacement_px"], file["det_j"]
    masks = {name: file[_domain(name)] for name in get_args(DomainName)}
    height, width = det_j.shape
    if displacement.shape != (height, width, 2) or any(
        mask.shape != (height, width) or mask.dtype != np.bool_ for mask in masks.values()
    ):
        raise ValueError("arrays of different sizes")
    count = sum(name.startswith("phi_") for name in file.files)
    lattices = tuple(
        Lattice(
            Grid(tuple(file[f"origin_px_{k}"].tolist()), float(file[f"spacing_px_{k}"])),
            tuple(file[f"first_{k}"].tolist()),
            file[f"phi_{k}"],
        )
        for k in range(count)
    )
    recipe = Recipe.from_dict(json.loads(str(file["recipe"])))
    return Evidence(
        points_px=file["points_px"],
        targets_px=file["targets_px"],
        face=file["face"],
        centers_px=file["centers_px"],
        lattices=lattices,
        displacement_px=displacement,
        det_j=det_j,
        masks=masks,
        recipe=recipe,
        made=made,
    )


def _domain(name: DomainName) -> str:
    return f"domain_{name.replace('-', '_')}"
