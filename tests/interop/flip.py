"""FLIP error maps by NVIDIA's own program.

    python flip.py REFERENCE.f32 TEST.f32 OUT.f32 SHAPE.json

The pictures are little-endian floats, sRGB 0 to 1, by row, column and channel; SHAPE.json holds
[rows, columns, pixels per degree]. Writes one float a pixel to OUT.f32.
"""

import json
import sys
from importlib import metadata

import flip_evaluator
import numpy

reference, test, out, shape = sys.argv[1:]
with open(shape) as file:
    rows, columns, pixels_per_degree = json.load(file)


def picture(path):
    return numpy.fromfile(path, "<f4").reshape(rows, columns, 3)


error, _, _ = flip_evaluator.evaluate(
    picture(reference), picture(test), "LDR", applyMagma=False, parameters={"ppd": pixels_per_degree}
)
numpy.asarray(error, "<f4").reshape(rows, columns, -1)[:, :, 0].tofile(out)
json.dump({"version": metadata.version("flip_evaluator")}, sys.stdout)
