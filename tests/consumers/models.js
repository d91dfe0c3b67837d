// Loads two models, draws both, and says how far the second looks from the first and what its materials' textures are.

import * as THREE from 'three';
import { lit, mean, models, radiance, say, strip, words } from '/page.js';

const SIDE = 400; // pixels

// From the front.
function picture(model) {
  const scene = lit([model, new THREE.HemisphereLight(0xffffff, 0x444444, 1)]);
  const box = new THREE.Box3().setFromObject(model);
  const [size, centre] = [box.getSize(new THREE.Vector3()), box.getCenter(new THREE.Vector3())];
  const half = Math.max(size.x, size.y) / 2;
  const camera = new THREE.OrthographicCamera(-half, half, half, -half, 0, 4 * half);
  camera.position.copy(centre).add(new THREE.Vector3(0, 0, 2 * half));
  return radiance(scene, camera, SIDE, SIDE);
}

const slots = ['map', 'normalMap', 'roughnessMap', 'metalnessMap', 'aoMap'];
const loaded = await models(words);
const told = new Set();
loaded[1].traverse((node) => node.material && slots.forEach((slot) => {
  const texture = node.material[slot];
  if (texture) {
    const { isCompressedTexture, mipmaps, image } = texture;
    const kind = isCompressedTexture ? 'compressed' : 'plain';
    told.add(`${node.material.name} ${slot} ${kind} ${mipmaps.length} ${Math.max(image.width, image.height)}`);
  }
}));
say('textures', [...told].sort().join('; '));
const [before, after] = loaded.map(picture);
say('light', mean(before).toPrecision(4));
say('far', (mean(before.map((v, i) => Math.abs(v - after[i]))) / mean(before)).toPrecision(3));
say('picture', strip({ before, after }, SIDE, SIDE, 1));
