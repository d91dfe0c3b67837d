// Squares far away, drawn with one sample a pixel: each model that is named, and the truth, which is the first with many
// samples a pixel.

import * as THREE from 'three';
import { difference, lit, mean, models, radiance, say, words } from '/page.js';

const SIDE = 32; // pixels
const FINER = 8; // of the truth, along each axis
const FRAMES = 4;
const LIGHTS = [[0.3, 0.6, 2], [-1, 0.5, 1.2]]; // the first near the mirrored view

function picture(model, frame, finer) {
  // The square of 0 to 1 fills the picture, but for a quarter of a pixel a frame.
  const camera = new THREE.PerspectiveCamera(20, 1, 0.1, 100);
  const far = 0.5 / Math.tan(Math.PI / 18);
  camera.position.set(0.5 + (0.25 * frame) / SIDE, 0.5, far);
  return radiance(lit([model], LIGHTS), camera, SIDE, SIDE, finer);
}

const frames = (model, finer) => [...Array(FRAMES).keys()].map((frame) => picture(model, frame, finer));

const loaded = await models(words);
const truth = frames(loaded[0], FINER);
const light = mean(truth.map(mean));
loaded.forEach((model, i) => {
  const ours = frames(model, 1);
  say(words[i], [difference(ours, truth), mean(ours.map(mean))].map((v) => (v / light).toPrecision(3)).join(' '));
  model.traverse(({ material }) => {
    const levels = (map) => `${map.isCompressedTexture ? 'compressed' : 'picture'} ${map.mipmaps?.length ?? 0}`;
    if (material) say(`${words[i]} maps`, [material.normalMap, material.roughnessMap, material.aoMap].map(levels).join(', '));
  });
});
