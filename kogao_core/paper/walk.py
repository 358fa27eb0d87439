"""The paper, from landmarks to figure 15, in one doctest.

A face of 21 landmarks on an oval; the eyes are at y = 150, the mouth at y = 250.

>>> import numpy as np
>>> from kogao_core.base.geometry import Box
>>> from kogao_core.paper import domain, fit, targets
>>> from kogao_core.paper.lattice import Grid
>>> turn = np.radians(np.linspace(-20.0, 200.0, 21))
>>> landmarks = np.column_stack([240.0 - 90.0 * np.cos(turn), 190.0 + 120.0 * np.sin(turn)])
>>> eyes, mouth = np.array([240.0, 150.0]), np.array([240.0, 250.0])

3.2: candidate 2 is the centre, and each target lies at 4 % of D towards it.

>>> center = targets.center_candidates(eyes, mouth)[1]
>>> pairs = targets.aim(landmarks, center, 0.04)
>>> center.tolist(), round(pairs.warp_distance_px, 2)
([240.0, 230.0], 3.52)

3.3: the lattice is as wide as the landmarks are apart (why not as the warp distance: decision 03).

>>> apart = float(np.hypot(*np.diff(landmarks, axis=0).T).mean())
>>> grid = Grid((240.0, 190.0), fit.spacing_px(1.0, apart))
>>> round(grid.spacing_px, 1)
20.7

2.1, 2.2: eqs. (3) and (4) give the control points, eq. (1) the displacement of any point. Where
landmarks share control points, the approximation misses the targets by about a tenth.

>>> problem = fit.Problem(grid, pairs.target_px, pairs.displacement_px)
>>> lattice = fit.approximate(problem)
>>> missed = np.hypot(*(lattice.at(pairs.target_px) - pairs.displacement_px).T)
>>> lattice.shape, round(float(missed.mean()), 2)
((11, 13), 0.4)

[12]: levels of finer lattices make up for it.

>>> finer = fit.multilevel(problem)
>>> missed = np.hypot(*(finer.at(pairs.target_px) - pairs.displacement_px).T)
>>> bool(missed.max() < 0.05)
True

4.1, 4.2: pixels of the photo, within reach of control points (figure 14), and that move by more
than a threshold (figure 15).

>>> photo = Box(0, 0, 480, 360)
>>> domain.pixel_counts([lattice], photo, 0.5)
{'image': 172800, 'control-points': 85541, 'threshold': 31743}
"""
