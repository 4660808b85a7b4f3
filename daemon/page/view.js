// SPDX-License-Identifier: Apache-2.0
// The 3D view: layers of one object, in the frame of the turntable, in millimetres.
import * as THREE from './three.module.js';
import { authorization, choose, partColor } from './page.js';

const place = document.getElementById('view');
let renderer, scene, camera, groups = {}, visible = { cloud: false, charge: false, parts: false, geons: true, grasps: false };
const eye = { azimuth: 0.6, elevation: 0.4, distance: 300, target: new THREE.Vector3(0, 0, 60) };

function start() {
  try {
    renderer = new THREE.WebGLRenderer({ antialias: true });
  } catch {
    place.textContent = 'This browser has no WebGL; the lists beside say what was found.';
    return false;
  }
  renderer.setClearColor(0xfbfbfa);
  place.append(renderer.domElement);
  scene = new THREE.Scene();
  camera = new THREE.PerspectiveCamera(35, 1, 1, 5000);
  camera.up.set(0, 0, 1);
  scene.add(new THREE.HemisphereLight(0xffffff, 0x888888, 2.0));
  const lamp = new THREE.DirectionalLight(0xffffff, 1.5);
  camera.add(lamp);
  scene.add(camera, new THREE.GridHelper(400, 20, 0xbbbbbb, 0xdddddd).rotateX(Math.PI / 2));
  new ResizeObserver(draw).observe(place);
  const pointers = new Map();
  let moved = 0;
  renderer.domElement.onpointerdown = (e) => { pointers.set(e.pointerId, e); moved = 0; renderer.domElement.setPointerCapture(e.pointerId); };
  renderer.domElement.onpointerup = (e) => { pointers.delete(e.pointerId); if (moved < 5) pick(e); };
  renderer.domElement.onpointermove = (e) => {
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
  renderer.domElement.onwheel = (e) => { e.preventDefault(); eye.distance *= Math.exp(e.deltaY * 0.001); draw(); };
  return true;
}

function draw() {
  if (!renderer) return;
  renderer.setSize(place.clientWidth, place.clientHeight);
  camera.aspect = place.clientWidth / Math.max(1, place.clientHeight);
  camera.updateProjectionMatrix();
  const c = Math.cos(eye.elevation);
  camera.position.set(Math.cos(eye.azimuth) * c, Math.sin(eye.azimuth) * c, Math.sin(eye.elevation)).multiplyScalar(eye.distance).add(eye.target);
  camera.lookAt(eye.target);
  renderer.render(scene, camera);
}

function pick(event) {
  const box = renderer.domElement.getBoundingClientRect();
  const at = new THREE.Vector2((event.clientX - box.left) / box.width * 2 - 1, 1 - (event.clientY - box.top) / box.height * 2);
  const ray = new THREE.Raycaster();
  ray.setFromCamera(at, camera);
  const hit = ray.intersectObjects(groups.geons?.children ?? [])[0];
  if (hit) choose(hit.object.userData.part);
}

// Reads a binary little-endian PLY of points or triangles, with float properties of vertices and faces.
function readPly(buffer) {
  const head = new TextDecoder('latin1').decode(buffer.slice(0, 4096));
  const end = head.indexOf('end_header\n') + 11;
  const elements = [];
  for (const line of head.slice(0, end).split('\n')) {
    const words = line.split(' ');
    if (words[0] === 'element') elements.push({ name: words[1], count: Number(words[2]), properties: [] });
    if (words[0] === 'property') elements.at(-1).properties.push(words[1] === 'list' ? { name: words[4], count: words[2], type: words[3] } : { name: words[2], type: words[1] });
  }
  const data = new DataView(buffer, end);
  let at = 0;
  const read = {
    uchar: () => data.getUint8(at++), uint8: () => data.getUint8(at++), char: () => data.getInt8(at++), int8: () => data.getInt8(at++),
    short: () => { at += 2; return data.getInt16(at - 2, true); }, ushort: () => { at += 2; return data.getUint16(at - 2, true); },
    int: () => { at += 4; return data.getInt32(at - 4, true); }, int32: () => { at += 4; return data.getInt32(at - 4, true); },
    uint: () => { at += 4; return data.getUint32(at - 4, true); }, uint32: () => { at += 4; return data.getUint32(at - 4, true); },
    float: () => { at += 4; return data.getFloat32(at - 4, true); }, float32: () => { at += 4; return data.getFloat32(at - 4, true); },
    double: () => { at += 8; return data.getFloat64(at - 8, true); }, float64: () => { at += 8; return data.getFloat64(at - 8, true); },
  };
  const result = {};
  for (const element of elements) {
    const columns = Object.fromEntries(element.properties.map((p) => [p.name, []]));
    for (let i = 0; i < element.count; ++i) {
      for (const p of element.properties) {
        columns[p.name].push(p.count ? Array.from({ length: read[p.count]() }, () => read[p.type]()) : read[p.type]());
      }
    }
    result[element.name] = columns;
  }
  return result;
}

const positions = (vertex) => new Float32Array(vertex.x.flatMap((x, i) => [1e3 * x, 1e3 * vertex.y[i], 1e3 * vertex.z[i]]));

function meshBy(ply, colorOf) {
  const p = positions(ply.vertex), faces = ply.face.vertex_indices ?? ply.face.vertex_index;
  const at = new Float32Array(faces.length * 9), colors = new Float32Array(faces.length * 9), color = new THREE.Color();
  faces.forEach((face, f) => {
    color.set(colorOf(f));
    face.slice(0, 3).forEach((v, k) => { at.set(p.subarray(3 * v, 3 * v + 3), 9 * f + 3 * k); colors.set([color.r, color.g, color.b], 9 * f + 3 * k); });
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(at, 3));
  geometry.setAttribute('color', new THREE.BufferAttribute(colors, 3));
  geometry.computeVertexNormals();
  return new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ vertexColors: true, side: THREE.DoubleSide }));
}

// The surface of a geon: a grid round its axis, tapered and bent as the description says.
function geonMesh(part, color) {
  const [a, b, c] = part.size_mm, [kx, ky] = part.taper, bend = part.bend_per_mm, box = part.type.includes('cuboid');
  const round = 48, along = 32, at = [], index = [];
  const ring = (t) => {
    if (part.type === 'ellipsoid') return (u) => [a * Math.cos(u), b * Math.sin(u)];
    if (!box) return (u) => [a * Math.cos(u), b * Math.sin(u)];
    return (u) => { const m = Math.max(Math.abs(Math.cos(u)), Math.abs(Math.sin(u))); return [a * Math.cos(u) / m, b * Math.sin(u) / m]; };
  };
  for (let j = 0; j <= along; ++j) {
    let z = c * (2 * Math.max(0, Math.min(along - 2, j - 1)) / (along - 2) - 1), scale = j === 0 || j === along ? 0 : 1;
    if (part.type === 'ellipsoid') { const v = Math.PI * j / along; z = -c * Math.cos(v); scale = Math.sin(v); }
    for (let i = 0; i < round; ++i) {
      let [x, y] = ring(j)(2 * Math.PI * i / round).map((v) => v * scale);
      x *= kx * z / c + 1;
      y *= ky * z / c + 1;
      let px = x, pz = z;
      if (bend > 0) { const r = 1 / bend, angle = z * bend; px = r - (r - x) * Math.cos(angle); pz = (r - x) * Math.sin(angle); }
      at.push(px, y, pz);
      if (j < along) {
        const n = (i + 1) % round;
        index.push(j * round + i, j * round + n, (j + 1) * round + i, (j + 1) * round + i, j * round + n, (j + 1) * round + n);
      }
    }
  }
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(at, 3));
  geometry.setIndex(index);
  geometry.computeVertexNormals();
  const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ color, side: THREE.DoubleSide, flatShading: box }));
  const q = part.pose.quaternion;
  mesh.position.set(...part.pose.position_mm);
  mesh.quaternion.set(q.x, q.y, q.z, q.w);
  mesh.userData.part = part.id;
  return mesh;
}

function graspMesh(grasp) {
  const group = new THREE.Group(), material = new THREE.MeshBasicMaterial({ color: 0x333333, wireframe: true });
  for (const side of [-1, 1]) {
    const finger = new THREE.Mesh(new THREE.BoxGeometry(8, 16, 45), material);
    finger.position.set(side * (grasp.opening_mm / 2 + 4), 0, -22.5);
    group.add(finger);
  }
  const q = grasp.pose.quaternion;
  group.position.set(...grasp.pose.position_mm);
  group.quaternion.set(q.x, q.y, q.z, q.w);
  return group;
}

const scaleColor = (t) => new THREE.Color().setHSL(0.75 - 0.6 * t, 0.65, 0.25 + 0.4 * t);

export async function show(object, grasps, folder) {
  if (!renderer && !start()) return;
  for (const group of Object.values(groups)) scene.remove(group);
  groups = Object.fromEntries(['cloud', 'charge', 'parts', 'geons', 'grasps'].map((name) => [name, new THREE.Group()]));
  object.parts.forEach((part, i) => groups.geons.add(geonMesh(part, partColor(i))));
  const best = new Map(grasps.map((g) => [g.part, g]).reverse());
  best.forEach((grasp) => groups.grasps.add(graspMesh(grasp)));
  const load = async (name) => readPly(await (await fetch(folder + name, { headers: authorization() })).arrayBuffer());
  const [cloud, mesh] = await Promise.all([load('cloud.ply'), load('mesh.ply')]);
  const points = new THREE.BufferGeometry();
  points.setAttribute('position', new THREE.BufferAttribute(positions(cloud.vertex), 3));
  groups.cloud.add(new THREE.Points(points, new THREE.PointsMaterial({ size: 1.2, color: 0x224466 })));
  const sorted = [...mesh.face.charge].map(Math.log).sort((p, q) => p - q);
  const low = sorted[Math.floor(sorted.length * 0.02)], high = sorted[Math.floor(sorted.length * 0.98)];
  groups.charge.add(meshBy(mesh, (f) => scaleColor(Math.min(1, Math.max(0, (Math.log(mesh.face.charge[f]) - low) / (high - low))))));
  groups.parts.add(meshBy(mesh, (f) => (mesh.face.part[f] < 0 ? '#555555' : partColor(mesh.face.part[f]))));
  const bounds = new THREE.Box3().setFromBufferAttribute(points.getAttribute('position'));
  bounds.getCenter(eye.target);
  eye.distance = 1.9 * bounds.getSize(new THREE.Vector3()).length();
  for (const group of Object.values(groups)) scene.add(group);
  layers(visible);
}

export function layers(wanted) {
  visible = wanted;
  for (const [name, group] of Object.entries(groups)) group.visible = Boolean(wanted[name]);
  draw();
}

export function highlight(id) {
  for (const mesh of groups.geons?.children ?? []) mesh.material.emissive.set(mesh.userData.part === id ? 0x333333 : 0x000000);
  draw();
}
