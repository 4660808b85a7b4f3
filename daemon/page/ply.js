// SPDX-License-Identifier: Apache-2.0
// Reads a binary little-endian PLY file: for each element an object of columns, a typed array a property, or an array of arrays
// for a list.

const kinds = {
  char: ['getInt8', 1, Int8Array], uchar: ['getUint8', 1, Uint8Array], short: ['getInt16', 2, Int16Array], ushort: ['getUint16', 2, Uint16Array],
  int: ['getInt32', 4, Int32Array], uint: ['getUint32', 4, Uint32Array], float: ['getFloat32', 4, Float32Array], double: ['getFloat64', 8, Float64Array],
};
Object.assign(kinds, { int8: kinds.char, uint8: kinds.uchar, int16: kinds.short, uint16: kinds.ushort, int32: kinds.int, uint32: kinds.uint,
  float32: kinds.float, float64: kinds.double });

export function readPly(buffer) {
  const start = new TextDecoder('latin1').decode(buffer.slice(0, 4096)), end = start.indexOf('end_header\n') + 11;
  const elements = [];
  for (const line of start.slice(0, end).split('\n')) {
    const words = line.split(' ');
    if (words[0] === 'element') elements.push({ name: words[1], count: Number(words[2]), properties: [] });
    if (words[0] === 'property') {
      elements.at(-1).properties.push(words[1] === 'list' ? { name: words[4], length: words[2], type: words[3] } : { name: words[2], type: words[1] });
    }
  }
  const data = new DataView(buffer, end);
  let at = 0;
  const read = (type) => {
    const [get, size] = kinds[type];
    at += size;
    return data[get](at - size, true);
  };
  const result = {};
  for (const { name, count, properties } of elements) {
    const columns = {};
    for (const p of properties) columns[p.name] = p.length ? new Array(count) : new kinds[p.type][2](count);
    for (let i = 0; i < count; ++i) {
      for (const p of properties) columns[p.name][i] = p.length ? Array.from({ length: read(p.length) }, () => read(p.type)) : read(p.type);
    }
    result[name] = columns;
  }
  return result;
}
