"""Project files with the edits of a photo; `interchange`: landmarks for other programs.

Modules here may import the packages up to `warp`.
"""
