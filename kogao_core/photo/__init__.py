"""Read and write photos: upright pixels at full bit depth, with metadata.

This package may import `base` and `recipe`, and contains no face code.
"""

from kogao_core.photo.errors import CannotDisclose, CannotWrite, RefusedOutput, UnreadablePhoto
from kogao_core.photo.formats import FORMATS, READABLE
from kogao_core.photo.formats.companions import accompanied, has_gain_map
from kogao_core.photo.in_place import check_in_place, write_in_place
from kogao_core.photo.model import Photo
from kogao_core.photo.reading import MAX_MEGAPIXELS, read
from kogao_core.photo.writing import bits_of, check_holds, check_output, write
