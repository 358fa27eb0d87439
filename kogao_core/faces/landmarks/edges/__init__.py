"""Finer outlines: where the visible edge of the face runs near the mesh's silhouette."""

from kogao_core.faces.landmarks.edges.refine import EdgeNetwork

__all__ = ["EdgeNetwork"]
