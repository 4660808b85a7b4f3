// SPDX-License-Identifier: Apache-2.0
// The page of geond: what the station does, and what was found. One WebSocket; everything shown comes from it.
import { show as drawObject, highlight as drawChoice, layers } from './view.js';

const $ = (id) => document.getElementById(id);
const text = (tag, content, className) => {
  const element = document.createElement(tag);
  element.textContent = content;
  if (className) element.className = className;
  return element;
};
export const partColor = (i) =>
  ['#4285cc', '#ed8c33', '#5cad5c', '#d15257', '#9470c2', '#996b57', '#e685c2', '#bdbd47', '#42bdcc', '#858f99'][i % 10];

const token = () => sessionStorage.getItem('token');
export const authorization = () => (token() ? { Authorization: 'Bearer ' + token() } : {});
let socket, nextId = 1, shownScan = null;
const waiting = new Map();

function call(method, params = {}) {
  return new Promise((resolve, reject) => {
    const id = nextId++;
    waiting.set(id, { resolve, reject });
    socket.send(JSON.stringify({ jsonrpc: '2.0', id, method, params }));
  });
}
const say = (error) => { $('message').textContent = error ? error.message + (error.data?.remedy ? '. ' + error.data.remedy : '') : ''; };

function showStatus(status) {
  const wrong = status.latched || status.emergency_stop || status.devices.some((d) => d.fault);
  $('state').textContent = status.latched ? 'stopped: ' + status.latched : status.state;
  $('state').classList.toggle('wrong', Boolean(wrong));
  $('scan').disabled = status.state !== 'idle' || Boolean(status.latched);
  $('cancel').disabled = !status.scan;
  $('progress').hidden = !status.scan;
  if (!status.scan) $('step').textContent = '';
  $('devices').replaceChildren(...status.devices.map((d) =>
    text('div', `${d.name}: ${d.state}${d.fault ? ': ' + d.fault : ''} (${d.model} ${d.serial})`, d.fault ? 'fault' : '')),
    text('div', `laser ${status.laser ? 'ON' : 'off'}, motor ${status.motor ? 'ON' : 'off'}` +
      `${status.door_open ? ', door open' : ''}${status.emergency_stop ? ', emergency stop pressed' : ''}`));
}

async function showScans() {
  const { scans } = await call('scan.list', { limit: 50 });
  $('scans').tBodies[0].replaceChildren(...scans.map((scan) => {
    const row = document.createElement('tr');
    row.append(text('td', scan.scan), text('td', scan.label), text('td', scan.state), text('td', scan.types.join(', ') || scan.error));
    if (scan.state === 'done') row.onclick = () => showObject(scan.scan);
    return row;
  }));
}

function partElement(part, i) {
  const element = document.createElement('div');
  element.className = 'part';
  element.id = 'part-' + part.id;
  element.style.borderColor = partColor(i);
  const size = part.size_mm.map((s) => (2 * s).toFixed(1)).join(' x ');
  element.append(text('div', `${part.id} ${part.type.replaceAll('_', ' ')}: ${size} mm, residual ${part.residual_mm.toFixed(2)} mm`));
  const table = document.createElement('table');
  table.hidden = true;
  for (const model of part.all_models) {
    const row = table.insertRow();
    row.append(text('td', model.type.replaceAll('_', ' ')), text('td', model.residual_mm.toFixed(3) + ' mm'));
  }
  element.append(table);
  element.onclick = () => choose(part.id);
  return element;
}

export function choose(id) {
  for (const element of document.querySelectorAll('.part')) {
    const chosen = element.id === 'part-' + id;
    element.classList.toggle('chosen', chosen);
    element.querySelector('table').hidden = !chosen;
  }
  drawChoice(id);
}

async function showObject(scan) {
  const object = await call('object.describe', scan ? { scan } : {});
  const { grasps } = await call('object.grasps', { scan: object.scan });
  shownScan = object.scan;
  $('object-title').textContent = `Scan ${object.scan}: ${object.n_parts} part${object.n_parts === 1 ? '' : 's'}`;
  $('parts').replaceChildren(...object.parts.map(partElement));
  $('relations').replaceChildren(...object.relations.map((r) => text('div', r.sentence ?? `${r.a} and ${r.b}`)));
  await drawObject(object, grasps, `/scans/${object.scan}/`);
  document.body.dataset.shown = String(object.scan);
}

async function refresh() {
  showStatus(await call('station.status'));
  await showScans();
}

function onEvent(event) {
  if (event.event === 'progress') {
    $('progress').hidden = false;
    if (event.total > 0) { $('progress').max = event.total; $('progress').value = event.done; } else $('progress').removeAttribute('value');
    $('step').textContent = event.step + (event.total > 0 ? ` ${event.done}/${event.total}` : '');
    return;
  }
  if (event.event === 'scan' && event.state === 'done') showObject(event.scan).catch(say);
  if (event.event === 'scan' && event.error) say(event.error);
  refresh().catch(say);
}

function connect() {
  socket = new WebSocket(`ws://${location.host}/ws`);
  socket.onopen = async () => {
    try {
      if (token()) await call('auth.login', { token: token() });
      await call('events.subscribe');
      await refresh();
      await showObject();
    } catch (error) {
      if (error.data?.name === 'forbidden') {
        sessionStorage.setItem('token', prompt('Token of this station') ?? '');
        socket.close();
      } else if (error.data?.name !== 'not_found') say(error);
    }
  };
  socket.onmessage = ({ data }) => {
    const message = JSON.parse(data);
    if (message.method === 'event') return onEvent(message.params);
    const pending = waiting.get(message.id);
    if (!pending) return;
    waiting.delete(message.id);
    if (message.error) pending.reject(message.error); else pending.resolve(message.result);
  };
  socket.onclose = () => {
    $('state').textContent = 'not connected';
    $('state').classList.add('wrong');
    for (const { reject } of waiting.values()) reject({ message: 'The connection to geond was lost' });
    waiting.clear();
    setTimeout(connect, 1000);
  };
}

for (const [id, method] of [['scan', 'scan.start'], ['cancel', 'scan.cancel'], ['stop', 'station.stop'], ['reset', 'station.reset']]) {
  $(id).onclick = () => { say(null); call(method).then(refresh).catch(say); };
}
for (const box of document.querySelectorAll('#layers input')) {
  box.onchange = () => layers(Object.fromEntries([...document.querySelectorAll('#layers input')].map((b) => [b.id.slice(6), b.checked])));
}
connect();
