// Every texel of every level of a KTX 2 file as three.js reads it.
//
//     node ktx2_dump.mjs THREE FILE.ktx2 OUT.bin
//
// THREE is the folder of the npm package three. Writes the levels that its KTX2Loader makes one after another, unpacked,
// and prints the file's header, descriptor and values as ktx-parse reads them, and the sizes of the levels.

import { readFileSync, writeFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [folder, path, out] = process.argv.slice(2);
const addon = (name) => import(pathToFileURL(`${folder}/examples/jsm/${name}`));
const { read } = await addon("libs/ktx-parse.module.js");
const { KTX2Loader } = await addon("loaders/KTX2Loader.js");

const bytes = readFileSync(path);
const container = read(new Uint8Array(bytes));
const texture = await new Promise((resolve, reject) => {
    const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length);
    // A renderer without any hardware: none of these formats is transcoded.
    const renderer = { extensions: { has: () => false, get: () => null } };
    new KTX2Loader().detectSupport(renderer).parse(buffer, resolve, reject);
});
const mips = texture.mipmaps;
const raw = (data) => Buffer.from(data.buffer, data.byteOffset, data.byteLength);
writeFileSync(out, Buffer.concat(mips.map((level) => raw(level.data))));

const [descriptor] = container.dataFormatDescriptor;
const { vkFormat, typeSize, pixelWidth, pixelHeight, supercompressionScheme, keyValue } = container;
console.log(JSON.stringify({
    vkFormat, typeSize, pixelWidth, pixelHeight, supercompressionScheme, keyValue,
    model: descriptor.colorModel,
    primaries: descriptor.colorPrimaries,
    transfer: descriptor.transferFunction,
    samples: descriptor.samples.length,
    colorSpace: texture.colorSpace,
    levels: mips.map((level) => [level.width, level.height]),
}));
