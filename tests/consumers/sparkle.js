// A material far away in slow motion, drawn with one sample a pixel: with the mips of each folder that is named, and the
// truth, which has many samples of level 0 a pixel.

import * as THREE from 'three';
import { difference, ktx2, lit, mean, radiance, renderer, say, strip, words } from '/page.js';

const WIDTH = 64, HEIGHT = 48; // pixels
const FINER = 8; // of the truth, along each axis
const FRAMES = 12;
const TILES = 2; // across what is seen
const PEAK = 0.001; // share of the brightest pixels

const [normal, packed, ...folders] = words;
const loader = ktx2(renderer);

async function map(file, filter) {
  const texture = await loader.loadAsync(`/files/${file}`);
  texture.wrapS = texture.wrapT = THREE.RepeatWrapping;
  texture.minFilter = filter;
  texture.magFilter = THREE.LinearFilter;
  return texture;
}

async function material(folder, filter) {
  const [normalMap, orm] = await Promise.all([map(`${folder}/${normal}`, filter), map(`${folder}/${packed}`, filter)]);
  return new THREE.MeshStandardMaterial({
    normalMap, aoMap: orm, roughnessMap: orm, roughness: 1, metalnessMap: orm, metalness: 1,
  });
}

// A plane that leans back, larger than what is seen of it.
const plane = new THREE.PlaneGeometry(4, 4);
plane.attributes.uv.array.forEach((v, i, uv) => (uv[i] = 2 * TILES * v));
const mesh = new THREE.Mesh(plane);
mesh.rotation.x = -0.5;
const scene = lit([mesh]);

function picture(material, frame, finer) {
  // Third of a pixel a frame, and away by half a percent.
  const camera = new THREE.PerspectiveCamera(20, WIDTH / HEIGHT, 0.1, 100);
  camera.position.set((0.35 * 2 * frame) / WIDTH, 0.1, 4.2 * 1.005 ** frame);
  mesh.material = material;
  return radiance(scene, camera, WIDTH, HEIGHT, finer);
}

const frames = (material, finer) => [...Array(FRAMES).keys()].map((frame) => picture(material, frame, finer));
function peak(frames) {
  const sorted = frames.flatMap((frame) => [...frame]).sort((a, b) => b - a);
  return mean(sorted.slice(0, Math.round(PEAK * sorted.length)));
}

const truth = frames(await material(folders[0], THREE.LinearFilter), FINER);
const light = mean(truth.map(mean));
const change = (frames, t) => frames[t].map((v, i) => frames[t + 1][i] - v);
const changes = (frames) => frames.slice(1).map((_, t) => change(frames, t));
const [trueChanges, shown] = [changes(truth), {}];
const show = (name, picture) => (shown[name] = picture.map((v) => (0.3 * v) / light));
const moved = (changes) => mean(changes.map((change) => mean(change.map(Math.abs))));
show('truth', truth[0]);
say('truth', [light, peak(truth), moved(trueChanges) / light].map((v) => v.toPrecision(3)).join(' '));
for (const folder of folders) {
  const ours = frames(await material(folder, THREE.LinearMipmapLinearFilter), 1);
  const wrong = changes(ours).map((change, t) => change.map((v, i) => v - trueChanges[t][i]));
  show(folder, ours[0]);
  show(`${folder}: flicker`, wrong[0].map(Math.abs));
  say(folder, [
    moved(wrong) / light,
    moved(changes(ours)) / moved(trueChanges),
    peak(ours) / peak(truth),
    difference(ours, truth) / light,
    mean(ours.map(mean)) / light,
  ].map((v) => v.toPrecision(3)).join(' '));
}
say('picture', strip(shown, WIDTH, HEIGHT, 6));
