"""Straight lines and people behind a face: found, held by the fit, and measured.

It may use the rooms up to `projects`. `pipeline` holds what is found here.
"""
