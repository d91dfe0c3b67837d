// Loads KTX 2 files with PlayCanvas, as the preset's steps say, and reads every level back in a shader of our own.

import * as pc from 'playcanvas';
import { base64, say, words } from '/page.js';

const device = await pc.createGraphicsDevice(document.createElement('canvas'), { deviceTypes: ['webgl2'] });
const options = new pc.AppOptions();
Object.assign(options, { graphicsDevice: device, resourceHandlers: [pc.TextureHandler], componentSystems: [] });
const app = new pc.AppBase(device.canvas);
app.init(options);
// Its own copy is in no npm package; this is the same program.
const basis = '/three/examples/jsm/libs/basis/basis_transcoder';
pc.basisInitialize({ glueUrl: `${basis}.js`, wasmUrl: `${basis}.wasm` });

const load = (file) => new Promise((done, failed) => {
  const loaded = (error, asset) => (error ? failed(new Error(`${file}: ${error}`)) : done(asset.resource));
  app.assets.loadFromUrl(`/files/${file}`, 'texture', loaded);
});
// All before any is read, for the engine does not know what is done behind its back.
const textures = [];
for (const file of words) textures.push(await load(file));

const { gl } = device;
const program = gl.createProgram();
for (const [kind, text] of [
  [gl.VERTEX_SHADER, 'void main() { gl_Position = vec4(4.0 * vec2(gl_VertexID & 1, gl_VertexID >> 1) - 1.0, 0, 1); }'],
  [gl.FRAGMENT_SHADER, `precision highp float;
    uniform highp sampler2D map;
    uniform int level;
    out vec4 texel;
    void main() { texel = texelFetch(map, ivec2(gl_FragCoord.xy), level); }`],
]) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, `#version 300 es\n${text}`);
  gl.compileShader(shader);
  gl.attachShader(program, shader);
}
gl.linkProgram(program);
gl.useProgram(program);
gl.bindVertexArray(null);
for (const state of [gl.BLEND, gl.DEPTH_TEST, gl.STENCIL_TEST, gl.SCISSOR_TEST, gl.CULL_FACE]) gl.disable(state);
gl.colorMask(true, true, true, true);
gl.activeTexture(gl.TEXTURE0);
gl.uniform1i(gl.getUniformLocation(program, 'map'), 0);

function level(texture, number, width, height) {
  const target = gl.createRenderbuffer();
  gl.bindRenderbuffer(gl.RENDERBUFFER, target);
  gl.renderbufferStorage(gl.RENDERBUFFER, gl.RGBA8, width, height);
  gl.bindFramebuffer(gl.FRAMEBUFFER, gl.createFramebuffer());
  gl.framebufferRenderbuffer(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, target);
  gl.bindTexture(gl.TEXTURE_2D, texture.impl._glTexture);
  gl.uniform1i(gl.getUniformLocation(program, 'level'), number);
  gl.viewport(0, 0, width, height);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  const texels = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, texels);
  return texels;
}

textures.forEach((texture, i) => {
  const sizes = texture._levels.map((_, k) => [texture.width, texture.height].map((side) => Math.max(1, side >> k)));
  say(`${words[i]} format`, pc.pixelFormatInfo.get(texture.format).name);
  say(`${words[i]} filter`, texture.mipmaps && texture.minFilter === pc.FILTER_LINEAR_MIPMAP_LINEAR);
  say(`${words[i]} linear`, !texture.srgb);
  say(`${words[i]} sizes`, sizes.map(([width, height]) => `${width}x${height}`).join(' '));
  sizes.forEach(([width, height], k) => say(`${words[i]} ${k}`, base64(level(texture, k, width, height))));
});
