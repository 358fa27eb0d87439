"""The overlays by name: what they are called and which key toggles them."""

from __future__ import annotations

from collections.abc import Set as AbstractSet
from dataclasses import dataclass

from .i18n import tr
from .points import Kind


@dataclass(frozen=True, slots=True)
class Layer:
    """One overlay that can be switched on and off."""

    name: str
    title: str
    key: str
    handles: frozenset[Kind] = frozenset()


def layers() -> tuple[Layer, ...]:
    """Return the overlays, in the order of the panel."""
    return (
        Layer("landmarks", tr("Landmarks"), "L", frozenset({"outline", "eye", "mouth"})),
        Layer("targets", tr("Targets"), "T", frozenset({"target"})),
        Layer("centre", tr("Centre and its candidates"), "C", frozenset({"centre"})),
        Layer("displacement", tr("Displacement, 3 × as long"), "V"),  # noqa: RUF001
        Layer("lattice", tr("Lattice"), "G"),
        Layer("domains", tr("Domains"), "D"),
        Layer("folds", tr("Folded cells"), "J"),
        Layer("heat", tr("Heat map of the move"), "H"),
        Layer("jacobian", tr("Jacobian map"), "K"),
        Layer("straight", tr("Straight lines and their bend"), "S"),
        Layer("protection", tr("Protected places"), "P"),
    )


def kinds(visible: AbstractSet[str]) -> set[Kind]:
    """Return the kinds of handles that the visible overlays show."""
    return {kind for layer in layers() if layer.name in visible for kind in layer.handles}


ON_AT_FIRST = frozenset({"landmarks", "targets", "centre", "folds", "protection"})
