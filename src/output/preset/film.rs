//! Renderers of film: OpenImageIO's texture system, and RenderMan.

use super::{Compress, Fact, Preset, nothing};
use crate::image::Sides;
use crate::material::NormalY;
use crate::output::Format;

/// OpenImageIO, and the renderers that read textures with it.
pub const OIIO: Preset = Preset {
    name: "oiio",
    engine: "OpenImageIO 3, Arnold, Cycles",
    format: Format::Exr,
    compress: Compress::None,
    normal_z: true,
    normal_y: NormalY::OpenGl,
    packed: None,
    packed_suffix: "",
    without_metal: 0.0,
    sides: Sides::Any,
    facts: &[
        Fact {
            text: "The EXR files are tiled and have all levels: OpenImageIO reads each as it was written.",
            source: "OpenImageIO 3.2.2, in the tests of mipfold (tests/interop.rs)",
            checked: true,
        },
        Fact {
            text: "Do not run maketx over such a file: it takes level 0 and makes plain mips of it.",
            source: "OpenImageIO 3.2.2, run on an EXR file of mipfold",
            checked: true,
        },
        Fact {
            text: "For .tx files build with --format png, and give maketx the levels: it keeps them bit for bit.",
            source: "OpenImageIO 3.2.2, maketx --mipimage, run on PNGs of mipfold",
            checked: true,
        },
        Fact {
            text: "Normals in EXR run from -1 to 1: a node that turns colours into vectors must not do so again.",
            source: "mipfold's own",
            checked: true,
        },
        Fact {
            text: "Where neither file nor shader names a wrap mode, texels beyond the border are black: ask for periodic.",
            source: "OpenImageIO, src/doc/maketx.rst, --wrap",
            checked: true,
        },
        Fact {
            text: "Colour management must leave the files alone: raw, or non-colour; maketx marks PNGs as sRGB.",
            source: "OpenImageIO 3.2.2, maketx, run on PNGs of mipfold",
            checked: true,
        },
        Fact {
            text: "--moments writes the slope moments in the channels of maketx --bumpslopes, for shaders that turn bumps \
                   into roughness themselves.",
            source: "OpenImageIO, src/doc/maketx.rst, --bumpslopes; tests/interop.rs of mipfold",
            checked: true,
        },
    ],
    load: "Use the files as textures as they are, with periodic wrap where they tile.
See their levels.
 oiiotool --info -v {normal}
Or make .tx files of levels that were written as PNG:
 maketx --wrap {wrap} LEVEL0 --mipimage LEVEL1 --mipimage LEVEL2 -o OUT",
    aside: nothing,
};

/// RenderMan.
pub const RENDERMAN: Preset = Preset {
    name: "renderman",
    engine: "RenderMan 24",
    format: Format::Png,
    compress: Compress::None,
    normal_z: true,
    normal_y: NormalY::OpenGl,
    packed: None,
    packed_suffix: "",
    without_metal: 0.0,
    sides: Sides::PowerOfTwo,
    facts: &[
        Fact {
            text: "PRMan wants tiles of its own sizes and its own metadata, which maketx --prman writes.",
            source: "OpenImageIO, src/doc/maketx.rst, --prman",
            checked: true,
        },
        Fact {
            text: "maketx keeps levels given as --mipimage bit for bit.",
            source: "OpenImageIO 3.2.2, maketx --mipimage, run on PNGs of mipfold",
            checked: true,
        },
        Fact {
            text: "txmake makes mips of its own, unless -usermipmap and a picture a level are given.",
            source: "RenderMan 20, manual page of txmake",
            checked: true,
        },
        Fact {
            text: "txmake resizes textures whose sides are no powers of two if told to.",
            source: "RenderMan 24 documentation, txmake, -resize",
            checked: true,
        },
        Fact {
            text: "Both tools make texels beyond the border black unless told periodic.",
            source: "OpenImageIO, src/doc/maketx.rst, --wrap; RenderMan 24 documentation, txmake, -mode",
            checked: true,
        },
        Fact {
            text: "For PxrBumpRoughness build with --moments: the channels are those of maketx --bumpslopes, but PRMan's \
                   metadata is missing in that file.",
            source: "OpenImageIO, src/doc/maketx.rst, --bumpslopes and --prman-metadata",
            checked: false,
        },
    ],
    load: "Make a texture of the levels, for each map.
 maketx --prman --wrap {wrap} {normal} \\
   $(printf -- '--mipimage {normal.level} ' $(seq 1 {normal.last})) \\
   -o normal.tex
 maketx --prman --wrap {wrap} {packed} \\
   $(printf -- '--mipimage {packed.level} ' $(seq 1 {packed.last})) \\
   -o roughness.tex
Or with RenderMan's own tool, all levels in order, the largest first:
 txmake -mode periodic -usermipmap LEVEL0 LEVEL1 LEVEL2 OUT
Read them linear, without conversion of colours: PxrNormalMap for the normals, with the orientation OpenGL.",
    aside: nothing,
};
