"""The bit-exact models: what the circuits compute, to the last bit.

    moments = selfproj.model.moments(image, threshold=20)      # image: uint8, (rows, columns)
    centroid = moments.m1 / moments.m0                         # row of the line in each column, from 1
"""

from ._core.model import GrayDecoder, Mode, Moments, Select, match, median3x3, moments

__all__ = ["GrayDecoder", "Mode", "Moments", "Select", "match", "median3x3", "moments"]
