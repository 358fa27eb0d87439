"""Landmarks in and out: WebMorph's .tem, iBUG's .pts, CSV and JSON (docs/interchange.md)."""

from kogao_core.projects.interchange.points import PointSet
from kogao_core.projects.interchange.registry import (
    FORMATS,
    Format,
    Written,
    check_inside,
    file_for,
    files,
    read,
    read_all,
    write,
    write_points,
)
from kogao_core.projects.interchange.templates import TEMPLATES, Template, template

__all__ = [
    "FORMATS",
    "TEMPLATES",
    "Format",
    "PointSet",
    "Template",
    "Written",
    "check_inside",
    "file_for",
    "files",
    "read",
    "read_all",
    "template",
    "write",
    "write_points",
]
