// Every texel of every level of a KTX 2 file of UASTC as Basis Universal's transcoder decodes it, and what else it makes
// of it.
//
//     node basis_dump.mjs THREE FILE.ktx2 OUT.bin [FORMAT]
//
// THREE is the folder of the npm package three. Writes the levels one after another, as RGBA of 8 bit or as blocks of a
// format that GPUs sample, and prints what the transcoder knows of the file and, for that format or else for all of them,
// how many bytes of blocks came of all levels, or 0 if any level failed.

import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";

const [folder, path, out, format] = process.argv.slice(2);
const at = `${folder}/examples/jsm/libs/basis/basis_transcoder`;
// (The package calls its files modules, which this one is not.)
const module = { exports: {} };
new Function("module", "exports", "require", "__filename", "__dirname", readFileSync(`${at}.js`, "utf8"))(
    module, module.exports, createRequire(import.meta.url), `${at}.js`, `${folder}/examples/jsm/libs/basis`,
);
const basis = await module.exports({ wasmBinary: readFileSync(`${at}.wasm`) });
basis.initializeBasis();

const file = new basis.KTX2File(new Uint8Array(readFileSync(path)));
if (!file.isValid() || !file.startTranscoding()) throw new Error(`${path} is not accepted`);
const levels = [...Array(file.getLevels()).keys()];
const transcode = (format, level) => {
    const blocks = new Uint8Array(file.getImageTranscodedSizeInBytes(level, 0, 0, format));
    return file.transcodeImage(blocks, level, 0, 0, format, 0, -1, -1) ? blocks : null;
};
const formats = { ETC1: 0, ETC2: 1, BC1: 2, BC3: 3, BC4: 4, BC5: 5, BC7: 6, ASTC: 10, EAC_R11: 20, EAC_RG11: 21 };
const texels = levels.map((level) => transcode(format ? formats[format] : 13, level));
if (texels.includes(null)) throw new Error(`${path} is not decoded`);
writeFileSync(out, Buffer.concat(texels));

const bytes = (format) => {
    const made = levels.map((level) => transcode(format, level));
    return made.includes(null) ? 0 : made.reduce((sum, blocks) => sum + blocks.length, 0);
};
console.log(JSON.stringify({
    size: [file.getWidth(), file.getHeight()],
    levels: levels.length,
    uastc: Boolean(file.isUASTC?.() ?? true),
    alpha: Boolean(file.getHasAlpha()),
    bytes: Object.fromEntries((format ? [format] : Object.keys(formats)).map((name) => [name, bytes(formats[name])])),
}));
