"""Kogao: automatic small-face warping by fast B-spline approximation (Seo, Chen and Aoki, 2011)."""

__version__ = "0.1.0"
