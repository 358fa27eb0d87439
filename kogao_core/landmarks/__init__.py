"""Where faces come from: the mesh network, or a mean face placed by hand."""

from kogao_core.landmarks.mesh import MeshSource
from kogao_core.landmarks.template import template_face

__all__ = ["MeshSource", "template_face"]
