"""Landmarks in and out: WebMorph's .tem, iBUG's .pts, CSV and JSON (docs/interchange.md)."""

from kogao_core.projects.interchange.registry import (
    FORMATS,
    Format,
    Written,
    check_inside,
    files,
    read,
    write,
)
from kogao_core.projects.interchange.templates import TEMPLATES, Template, template

__all__ = [
    "FORMATS",
    "TEMPLATES",
    "Format",
    "Template",
    "Written",
    "check_inside",
    "files",
    "read",
    "template",
    "write",
]
