// SPDX-License-Identifier: Apache-2.0
// What stands for a geon, a mesh, a cloud and a gripper in the picture, in millimetres.
import * as THREE from './three.module.js';

function positions({ x, y, z }) {
  const at = new Float32Array(3 * x.length);
  for (let i = 0; i < x.length; ++i) at.set([1e3 * x[i], 1e3 * y[i], 1e3 * z[i]], 3 * i);
  return at;
}

// The points of all views, each view in a colour of its own.
export function cloudOf({ vertex }, viewColor) {
  const geometry = new THREE.BufferGeometry(), color = new THREE.Color(), colors = new Float32Array(3 * vertex.x.length);
  for (let i = 0; i < vertex.x.length; ++i) {
    color.set(viewColor(vertex.view ? vertex.view[i] : 0));
    colors.set([color.r, color.g, color.b], 3 * i);
  }
  geometry.setAttribute('position', new THREE.BufferAttribute(positions(vertex), 3));
  geometry.setAttribute('color', new THREE.BufferAttribute(colors, 3));
  return new THREE.Points(geometry, new THREE.PointsMaterial({ size: 2.2, sizeAttenuation: false, vertexColors: true }));
}

// The mesh with each triangle in the colour that `colorOf(triangle)` says.
export function meshOf(ply, colorOf) {
  const p = positions(ply.vertex), faces = ply.face.vertex_indices ?? ply.face.vertex_index, color = new THREE.Color();
  const at = new Float32Array(9 * faces.length), colors = new Float32Array(9 * faces.length);
  faces.forEach((face, f) => {
    color.set(colorOf(f));
    for (let k = 0; k < 3; ++k) {
      at.set(p.subarray(3 * face[k], 3 * face[k] + 3), 9 * f + 3 * k);
      colors.set([color.r, color.g, color.b], 9 * f + 3 * k);
    }
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(at, 3));
  geometry.setAttribute('color', new THREE.BufferAttribute(colors, 3));
  geometry.computeVertexNormals();
  return new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({ vertexColors: true, side: THREE.DoubleSide, roughness: 0.85 }));
}

function place(object, pose) {
  const q = pose.quaternion;
  object.position.set(...pose.position_mm);
  object.quaternion.set(q.x, q.y, q.z, q.w);
  return object;
}

// The surface of a geon: rings along its axis, tapered and bent as the description says, with lids.
export function geonOf(part, color) {
  const [a, b, c] = part.size_mm, [kx, ky] = part.taper, bend = part.bend_per_mm;
  const box = part.type.includes('cuboid'), ball = part.type === 'ellipsoid', round = box ? 64 : 48, along = 36, at = [], index = [];
  const put = (x, y, z) => {
    x *= kx * z / c + 1;
    y *= ky * z / c + 1;
    if (bend > 0) {
      const r = 1 / bend, angle = z * bend;
      at.push(r - (r - x) * Math.cos(angle), y, (r - x) * Math.sin(angle));
    } else {
      at.push(x, y, z);
    }
  };
  for (let j = 0; j <= along; ++j) {
    // The first and the last ring are the middles of the lids.
    const v = Math.PI * j / along, lid = j === 0 || j === along;
    const z = ball ? -c * Math.cos(v) : c * (2 * Math.max(0, Math.min(along - 2, j - 1)) / (along - 2) - 1);
    const scale = ball ? Math.sin(v) : lid ? 0 : 1;
    for (let i = 0; i < round; ++i) {
      const u = 2 * Math.PI * i / round, m = box ? Math.max(Math.abs(Math.cos(u)), Math.abs(Math.sin(u))) : 1;
      put(scale * a * Math.cos(u) / m, scale * b * Math.sin(u) / m, z);
      if (j === along) continue;
      const n = (i + 1) % round, here = j * round, next = here + round;
      index.push(here + i, here + n, next + i, next + i, here + n, next + n);
    }
  }
  let geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.Float32BufferAttribute(at, 3));
  geometry.setIndex(index);
  // Lids and boxes have edges, which shared normals would round.
  if (!ball) geometry = geometry.toNonIndexed();
  geometry.computeVertexNormals();
  const material = new THREE.MeshStandardMaterial({ color, side: THREE.DoubleSide, roughness: 0.7, flatShading: !ball });
  const mesh = place(new THREE.Mesh(geometry, material), part.pose);
  mesh.userData.part = part.id;
  return mesh;
}

// A parallel gripper: two fingers, a palm and the way it comes, z forwards, x across.
export function gripperOf(grasp, color) {
  const group = new THREE.Group(), material = new THREE.MeshStandardMaterial({ color, transparent: true, opacity: 0.75, roughness: 0.5 });
  const box = (x, y, z, cx, cz) => {
    const part = new THREE.Mesh(new THREE.BoxGeometry(x, y, z), material);
    part.position.set(cx, 0, cz);
    group.add(part);
  };
  for (const side of [-1, 1]) box(6, 14, 45, side * (grasp.opening_mm / 2 + 3), -22.5);
  box(grasp.opening_mm + 12, 14, 6, 0, -48);
  box(5, 5, 30, 0, -66);
  return place(group, grasp.pose);
}
