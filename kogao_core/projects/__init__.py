"""What was done to a photo, as a file; `interchange/`: landmarks for other programs.

It may use the rooms up to `warp`.
"""
