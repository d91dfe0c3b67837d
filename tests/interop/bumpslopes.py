"""OpenImageIO's own raw slope moments of a normal map: what `maketx --bumpslopes` writes.

    python bumpslopes.py NORMAL DECODED.png OUT.exr

decodes NORMAL to DECODED.png, so that both tools can be given the very same pixels (JPEG decoders differ by a step),
and makes OUT.exr from that, as

    maketx --bumpslopes --bumpformat normal --wrap periodic --filter box -d float -o OUT.exr DECODED.png

Two traps: without "bumprange" the Python call writes zeros and returns True; and OpenImageIO multiplies colours by
alpha as it reads, which bends the normals of RGBA files, unless told not to.
"""

import json
import sys

import OpenImageIO as oiio


def fail(what):
    sys.exit(what + ": " + oiio.geterror())


source, decoded, out = sys.argv[1:]
straight = oiio.ImageSpec()
straight.attribute("oiio:UnassociatedAlpha", 1)
image = oiio.ImageBuf(source, 0, 0, straight)
image = oiio.ImageBufAlgo.channels(image, (0, 1, 2))
if not image.write(decoded):
    fail(decoded)

options = oiio.ImageSpec()
options.set_format(oiio.FLOAT)
options.attribute("maketx:bumpformat", "normal")
options.attribute("maketx:bumprange", "auto")
options.attribute("maketx:filtername", "box")
options.attribute("wrapmodes", "periodic,periodic")
if not oiio.ImageBufAlgo.make_texture(oiio.MakeTxBumpWithSlopes, decoded, out, options):
    fail(out)
json.dump({"version": oiio.VERSION_STRING}, sys.stdout)
