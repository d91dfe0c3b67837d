"""What OpenImageIO finds in an OpenEXR file, as JSON: its levels, their sizes, and statistics of every channel.

    python exr_levels.py FILE.exr

prints {"levels": [{"width", "height", "channels": [{"name", "type", "min", "max", "mean"}]}], "tile": [w, h],
"compression", "rounding"}. Exit status 1, with the reason on stderr, if OpenImageIO cannot read the file.
"""

import json
import sys

import numpy
import OpenImageIO as oiio


def levels(path):
    image = oiio.ImageInput.open(path)
    if image is None:
        sys.exit(oiio.geterror())
    found = []
    while image.seek_subimage(0, len(found)):
        spec = image.spec()
        texels = image.read_image(0, len(found), 0, spec.nchannels, oiio.FLOAT)
        if texels is None:
            sys.exit(image.geterror())
        texels = numpy.asarray(texels).reshape(spec.height, spec.width, spec.nchannels)
        channels = []
        for c, name in enumerate(spec.channelnames):
            values = texels[:, :, c]
            channels.append({
                "name": name,
                "type": str(spec.channelformat(c)),
                "min": float(values.min()),
                "max": float(values.max()),
                "mean": float(values.mean(dtype=numpy.float64)),
            })
        found.append({"width": spec.width, "height": spec.height, "channels": channels})
        first = spec if len(found) == 1 else first
    return {
        "levels": found,
        "tile": [first.tile_width, first.tile_height],
        "compression": first.get_string_attribute("compression"),
        "rounding": first.get_int_attribute("openexr:roundingmode", -1),
    }


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    json.dump(levels(sys.argv[1]), sys.stdout, indent=1)
    print()
