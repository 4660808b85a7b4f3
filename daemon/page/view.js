// SPDX-License-Identifier: Apache-2.0
// The 3D view: layers of one object, in the frame of the turntable, in millimetres.
import * as THREE from './three.module.js';
import { file } from './connection.js';
import { readPly } from './ply.js';
import { cloudOf, geonOf, gripperOf, meshOf } from './shapes.js';

export const partColor = (i) =>
  ['#4285cc', '#ed8c33', '#5cad5c', '#d15257', '#9470c2', '#996b57', '#e685c2', '#bdbd47', '#42bdcc', '#858f99'][i % 10];
const viewColor = (i) => `hsl(${(i * 137.5 + 200) % 360}, 65%, 45%)`;
const chargeColor = (t) => `hsl(${270 - 220 * t}, ${60 + 15 * t}%, ${22 + 38 * t}%)`;

const place = document.getElementById('view'), legend = document.getElementById('legend');
place.append(legend);
const eye = { azimuth: 0.6, elevation: 0.35, distance: 400, target: new THREE.Vector3(0, 0, 60) };
let renderer, scene, camera, groups = {}, facts = {}, picked = () => {}, wanted = 0;
let visible = { cloud: false, charge: false, parts: false, geons: true, grasps: false };

export function onPick(use) { picked = use; }

function start() {
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true, alpha: true });
  } catch {
    document.getElementById('hint').textContent = 'This browser has no WebGL; the lists say what was found.';
    return false;
  }
  renderer.setPixelRatio(Math.min(2, devicePixelRatio));
  place.prepend(renderer.domElement);
  scene = new THREE.Scene();
  camera = new THREE.PerspectiveCamera(32, 1, 1, 10000);
  camera.up.set(0, 0, 1);
  const lamp = new THREE.DirectionalLight(0xffffff, 1.6);
  lamp.position.set(-0.6, 0.8, 0.5);
  camera.add(lamp);
  scene.add(camera, new THREE.HemisphereLight(0xffffff, 0x99938a, 1.9));
  const grid = new THREE.GridHelper(400, 20, 0x9aa3ac, 0x9aa3ac).rotateX(Math.PI / 2);
  grid.material.transparent = true;
  grid.material.opacity = 0.35;
  scene.add(grid);
  new ResizeObserver(draw).observe(place);
  listen(renderer.domElement);
  return true;
}

// One finger or the mouse turns, two fingers or the wheel bring nearer, a click picks, two look at it from the front again.
function listen(canvas) {
  const pointers = new Map();
  let moved = 0;
  canvas.onpointerdown = (e) => {
    if (pointers.size === 0) moved = 0;
    pointers.set(e.pointerId, e);
    canvas.setPointerCapture(e.pointerId);
  };
  canvas.onpointercancel = (e) => pointers.delete(e.pointerId);
  canvas.onpointerup = (e) => {
    pointers.delete(e.pointerId);
    if (moved < 6) pick(e);
  };
  canvas.onpointermove = (e) => {
    const before = pointers.get(e.pointerId);
    if (!before) return;
    moved += Math.abs(e.clientX - before.clientX) + Math.abs(e.clientY - before.clientY);
    if (pointers.size === 1) {
      eye.azimuth -= (e.clientX - before.clientX) * 0.01;
      eye.elevation = Math.min(1.5, Math.max(-1.5, eye.elevation + (e.clientY - before.clientY) * 0.01));
    } else {
      const other = [...pointers.values()].find((p) => p.pointerId !== e.pointerId);
      const span = (p) => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY);
      eye.distance *= span(before) / Math.max(1, span(e));
    }
    pointers.set(e.pointerId, e);
    draw();
  };
  canvas.onwheel = (e) => { e.preventDefault(); eye.distance *= Math.exp(e.deltaY * 0.001); draw(); };
  canvas.ondblclick = () => { Object.assign(eye, { azimuth: 0.6, elevation: 0.35, distance: eye.first ?? 400 }); draw(); };
}

function draw() {
  if (!renderer) return;
  const width = place.clientWidth, height = Math.max(1, place.clientHeight);
  renderer.setSize(width, height);
  camera.aspect = width / height;
  camera.updateProjectionMatrix();
  const c = Math.cos(eye.elevation), far = eye.distance * Math.max(1, 0.9 / camera.aspect);
  camera.position.set(Math.cos(eye.azimuth) * c, Math.sin(eye.azimuth) * c, Math.sin(eye.elevation)).multiplyScalar(far).add(eye.target);
  camera.lookAt(eye.target);
  renderer.render(scene, camera);
}

function pick(event) {
  const box = renderer.domElement.getBoundingClientRect(), ray = new THREE.Raycaster();
  ray.setFromCamera(new THREE.Vector2((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2), camera);
  // Geons may be picked through whatever layer is shown over them.
  const hit = ray.intersectObjects(groups.geons?.children ?? [])[0];
  picked(hit ? hit.object.userData.part : null);
}

function dispose(group) {
  group.traverse((object) => { object.geometry?.dispose(); object.material?.dispose(); });
  scene.remove(group);
}

// Draws a described object: geons at once, cloud and mesh when they have come from `folder`.
export async function show(object, grasps, folder) {
  if (!renderer && !start()) return;
  const mine = ++wanted;
  const make = Object.fromEntries(Object.keys(visible).map((name) => [name, new THREE.Group()]));
  object.parts.forEach((part, i) => make.geons.add(geonOf(part, partColor(i))));
  const best = new Map([...grasps].reverse().map((grasp) => [grasp.part, grasp]));
  for (const [part, grasp] of best) make.grasps.add(gripperOf(grasp, partColor(object.parts.findIndex((p) => p.id === part))));
  const load = async (name) => readPly(await (await file(folder + name)).arrayBuffer());
  const [cloud, mesh] = await Promise.all([load('cloud.ply'), load('mesh.ply')]);
  if (mine !== wanted) return;  // another one was asked for meanwhile
  make.cloud.add(cloudOf(cloud, viewColor));
  const charge = Array.from(mesh.face.charge, Math.log), sorted = [...charge].sort((p, q) => p - q);
  const low = sorted[Math.floor(sorted.length * 0.02)], high = sorted[Math.floor(sorted.length * 0.98)];
  make.charge.add(meshOf(mesh, (f) => chargeColor(Math.min(1, Math.max(0, (charge[f] - low) / (high - low || 1))))));
  make.parts.add(meshOf(mesh, (f) => (mesh.face.part[f] < 0 ? '#555555' : partColor(mesh.face.part[f]))));
  Object.values(groups).forEach(dispose);
  groups = make;
  facts = { views: cloud.vertex.view ? Math.max(...new Set(cloud.vertex.view)) + 1 : 0, ratio: Math.exp(high - low) };
  const bounds = new THREE.Box3().setFromObject(make.geons).union(new THREE.Box3().setFromObject(make.cloud));
  bounds.getCenter(eye.target);
  eye.distance = eye.first = 2.1 * bounds.getSize(new THREE.Vector3()).length();
  for (const group of Object.values(groups)) scene.add(group);
  layers(visible);
}

function describeLayers() {
  legend.replaceChildren();
  const line = (color, text) => {
    const row = document.createElement('div'), patch = document.createElement('i');
    patch.style.background = color;
    row.append(text, patch);
    legend.append(row);
  };
  if (visible.cloud) for (let i = 0; i < Math.min(facts.views, 12); ++i) line(viewColor(i), `view ${i + 1}`);
  if (visible.charge && facts.ratio) {
    const scale = document.createElement('div');
    scale.className = 'scale';
    scale.style.background = `linear-gradient(to right, ${[0, 0.25, 0.5, 0.75, 1].map(chargeColor).join(', ')})`;
    legend.append('charge density', scale, `1 to ${facts.ratio.toFixed(1)}`);
  }
}

export function layers(shown) {
  visible = shown;
  for (const [name, group] of Object.entries(groups)) group.visible = Boolean(shown[name]);
  // Behind the data a geon would hide what it stands for.
  const over = visible.cloud || visible.charge || visible.parts || visible.grasps;
  for (const mesh of groups.geons?.children ?? []) {
    Object.assign(mesh.material, { transparent: over, opacity: over ? 0.45 : 1, depthWrite: !over });
  }
  describeLayers();
  draw();
}

export function highlight(id) {
  for (const mesh of groups.geons?.children ?? []) mesh.material.emissive.set(mesh.userData.part === id ? 0x444444 : 0x000000);
  draw();
}
