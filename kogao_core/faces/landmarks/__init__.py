"""Landmark sources: networks, the paper's AAM, and a mean face to place by hand."""

from kogao_core.faces.choices import CHOICES, Choice, Measured
from kogao_core.faces.landmarks.locked import ModelRefused
from kogao_core.faces.landmarks.mesh import MeshSource
from kogao_core.faces.landmarks.sources import (
    check_networks,
    find,
    networks_are_here,
    source,
    template_face,
)
