"""Every texel of every level of an OpenEXR file as OpenImageIO reads it.

    python exr_dump.py FILE.exr OUT.bin

writes the levels one after another as 32-bit little-endian floats, texel by texel, and prints
{"levels": [[width, height], ...], "channels": [names in the order of the floats], "types": [...],
"tiled": bool, "wrapmodes": "periodic,periodic" or the like}.
"""

import json
import sys

import numpy
import OpenImageIO as oiio

path, out = sys.argv[1:]
image = oiio.ImageInput.open(path) or sys.exit(oiio.geterror())
first = image.spec()
sizes = []
with open(out, "wb") as file:
    while image.seek_subimage(0, len(sizes)):
        spec = image.spec()
        texels = image.read_image(0, len(sizes), 0, spec.nchannels, oiio.FLOAT)
        if texels is None:
            sys.exit(image.geterror())
        file.write(numpy.asarray(texels, dtype="<f4").tobytes())
        sizes.append([spec.width, spec.height])
json.dump({
    "levels": sizes,
    "channels": list(first.channelnames),
    "types": [str(first.channelformat(c)) for c in range(first.nchannels)],
    "tiled": first.tile_width > 0,
    "wrapmodes": first.get_string_attribute("wrapmodes"),
}, sys.stdout)
