// Loads KTX 2 and DDS files with three.js, and reads every level back in a shader. Behind 'plain:' a file is loaded as
// if the hardware had no compressed formats.

import * as THREE from 'three';
import { DDSLoader } from 'three/addons/loaders/DDSLoader.js';
import { base64, ktx2, level, renderer, say, words } from '/page.js';

const loaders = {
  dds: () => new DDSLoader(),
  ktx2: () => ktx2(renderer),
  plain: () => ktx2({ extensions: { has: () => false, get: () => null } }),
};
let kind, loader;
const formats = Object.fromEntries(Object.entries(THREE).filter(([k]) => k.endsWith('Format')).map(([k, v]) => [v, k]));

for (const file of words) {
  const plain = file.startsWith('plain:');
  const wanted = plain ? 'plain' : file.split('.').pop();
  if (wanted !== kind) {
    // three.js complains of two that load KTX 2 at once.
    loader?.dispose?.();
    [kind, loader] = [wanted, loaders[wanted]()];
  }
  const texture = await loader.loadAsync(`/files/${plain ? file.slice(6) : file}`);
  // As the loader's users are told for files that are not compressed.
  if (!texture.isCompressedTexture) texture.minFilter = THREE.LinearMipmapLinearFilter;
  say(`${file} format`, formats[texture.format]);
  say(`${file} filter`, texture.minFilter === THREE.LinearMipmapLinearFilter);
  say(`${file} linear`, texture.colorSpace === THREE.NoColorSpace);
  say(`${file} sizes`, texture.mipmaps.map((mip) => `${mip.width}x${mip.height}`).join(' '));
  texture.mipmaps.forEach((mip, number) => {
    say(`${file} ${number}`, base64(level(texture, number, mip.width, mip.height)));
  });
  texture.dispose();
}
