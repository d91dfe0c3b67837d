// What the pages of this folder share.

import * as THREE from 'three';

const lines = [];

// A line of what the page found.
export const say = (name, value) => lines.push(`${name}=${value}`);

// Sends what the page found, and lets the console's reader know that nothing follows.
export async function ended() {
  document.body.append(document.createElement('pre'));
  document.body.lastChild.textContent = lines.filter((line) => line.length < 200).join('\n');
  console.info('this page has ended');
  await fetch('/ended', { method: 'POST', body: lines.join('\n') });
}

// An error is the end, too, and stands on the console.
addEventListener('error', ended);
addEventListener('unhandledrejection', ended);

// The words behind the address's question mark.
export const words = decodeURIComponent(location.search.slice(1)).split(',');

// Bytes as text.
export function base64(bytes) {
  let text = '';
  for (let i = 0; i < bytes.length; i += 0x8000) text += String.fromCharCode(...bytes.subarray(i, i + 0x8000));
  return btoa(text);
}

// What a scene looks like: width * height pixels of 4 numbers, from below.
export function drawn(renderer, scene, camera, width, height, type) {
  const target = new THREE.WebGLRenderTarget(width, height, { type });
  const texels = new (type === THREE.FloatType ? Float32Array : Uint8Array)(4 * width * height);
  renderer.setRenderTarget(target);
  renderer.render(scene, camera);
  renderer.readRenderTargetPixels(target, 0, 0, width, height, texels);
  renderer.setRenderTarget(null);
  target.dispose();
  return texels;
}

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
const [scene, camera] = [new THREE.Scene().add(whole), new THREE.Camera()];
whole.frustumCulled = false;

// The texels of a level as shaders see them at their centres, under the texture's own filters: first row first.
export function level(renderer, texture, number, width, height) {
  Object.assign(reader.uniforms, { map: { value: texture }, level: { value: number } });
  reader.uniforms.size.value.set(width, height);
  return drawn(renderer, scene, camera, width, height, THREE.UnsignedByteType);
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
