// What the pages of this folder share.

import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { KTX2Loader } from 'three/addons/loaders/KTX2Loader.js';

/* global lines: the page has them */

// A line of what the page found.
export const say = (name, value) => lines.push(`${name}=${value}`);

// The module that the address names, and the words for it.
export const [name, ...words] = decodeURIComponent(location.search.slice(1)).split(',');

export const renderer = new THREE.WebGLRenderer();

// A loader of KTX 2, into what a renderer can show.
export const ktx2 = (renderer) =>
  new KTX2Loader().setTranscoderPath('/three/examples/jsm/libs/basis/').setWorkerLimit(1).detectSupport(renderer);

// The scenes of glTF files.
export async function models(files) {
  const loader = new GLTFLoader().setKTX2Loader(ktx2(renderer));
  const scenes = [];
  for (const file of files) scenes.push((await loader.loadAsync(`/files/${file}`)).scene);
  return scenes;
}

// A scene of what is given and of two lights.
export function lit(things, places = [[0.3, 1.6, 2], [-1, 0.5, 1.2]]) {
  const scene = new THREE.Scene().add(...things);
  for (const place of places) {
    const light = new THREE.DirectionalLight(0xffffff, 2);
    light.position.set(...place);
    scene.add(light);
  }
  return scene;
}

export const mean = (values) => values.reduce((a, b) => a + b, 0) / values.length;

// Bytes as text.
export function base64(bytes) {
  let text = '';
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

// What a scene looks like: width * height pixels of 4 numbers, from below.
function drawn(scene, camera, width, height, type) {
  const target = new THREE.WebGLRenderTarget(width, height, { type });
  const texels = new (type === THREE.FloatType ? Float32Array : Uint8Array)(4 * width * height);
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  renderer.readRenderTargetPixels(target, 0, 0, width, height, texels);
  renderer.setRenderTarget(null);
  target.dispose();
  return texels;
}

// Radiance, green, of a scene, from below: each pixel the mean of finer * finer samples.
export function radiance(scene, camera, width, height, finer = 1) {
  const texels = drawn(scene, camera, width * finer, height * finer, THREE.FloatType);
  const pixels = new Float64Array(width * height);
  for (let y = 0; y < height * finer; y++) {
    for (let x = 0; x < width * finer; x++) {
      const sample = texels[4 * (y * width * finer + x) + 1];
      pixels[Math.floor(y / finer) * width + Math.floor(x / finer)] += sample / (finer * finer);
    }
  }
  return pixels;
}

// Root mean square difference of two lists of pictures.
export const difference = (ours, truth) =>
  Math.sqrt(mean(ours.map((picture, t) => mean(picture.map((v, i) => (v - truth[t][i]) ** 2)))));

const reader = new THREE.RawShaderMaterial({
  glslVersion: THREE.GLSL3,
  blending: THREE.NoBlending,
  depthTest: false,
  uniforms: { map: { value: null }, level: { value: 0 }, size: { value: new THREE.Vector2() } },
  vertexShader: 'in vec3 position; void main() { gl_Position = vec4(position, 1.0); }',
  fragmentShader: `precision highp float;
    uniform highp sampler2D map;
    uniform float level;
    uniform vec2 size;
    out vec4 texel;
    void main() { texel = textureLod(map, gl_FragCoord.xy / size, level); }`,
});
const whole = new THREE.Mesh(new THREE.PlaneGeometry(2, 2), reader);
whole.frustumCulled = false;

// The texels of a level as shaders see them at their centres, under the texture's own filters: first row first.
export function level(texture, number, width, height) {
  Object.assign(reader.uniforms, { map: { value: texture }, level: { value: number } });
  reader.uniforms.size.value.set(width, height);
  return drawn(new THREE.Scene().add(whole), new THREE.Camera(), width, height, THREE.UnsignedByteType);
}

// Pictures of radiance side by side, each width * height from below and scaled up: a PNG in base 64.
export function strip(pictures, width, height, scale) {
  const line = 20; // of text, in pixels
  const canvas = document.createElement('canvas');
  canvas.width = Object.keys(pictures).length * width * scale;
  canvas.height = height * scale + line;
  const context = canvas.getContext('2d');
  context.imageSmoothingEnabled = false;
  context.fillStyle = 'white';
  context.fillRect(0, 0, canvas.width, canvas.height);
  context.fillStyle = 'black';
  context.font = '14px sans-serif';
  Object.entries(pictures).forEach(([name, picture], i) => {
    const small = document.createElement('canvas');
    [small.width, small.height] = [width, height];
    const image = new ImageData(width, height);
    picture.forEach((v, j) => {
      const grey = 255 * Math.min(1, v) ** (1 / 2.2);
      image.data.set([grey, grey, grey, 255], 4 * ((height - 1 - Math.floor(j / width)) * width + (j % width)));
    });
    small.getContext('2d').putImageData(image, 0, 0);
    context.drawImage(small, i * width * scale, line, width * scale, height * scale);
    context.fillText(name, i * width * scale + 4, 15);
  });
  document.body.append(canvas);
  return canvas.toDataURL().split(',')[1];
}
