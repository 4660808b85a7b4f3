// SPDX-License-Identifier: Apache-2.0
// The page of geond: what the station does, and what was found. Everything shown comes over one WebSocket.
import { connect, download, upload } from './connection.js';
import { highlight, layers, partColor, show, onPick } from './view.js';

const $ = (id) => document.getElementById(id);
function element(tag, content = '', className = '') {
  const made = document.createElement(tag);
  made.append(...[content].flat());
  if (className) made.className = className;
  return made;
}
const words = (name) => name.replaceAll('_', ' ');
const fixed = (value, digits) => (Math.abs(value) < 0.5 * 10 ** -digits ? 0 : value).toFixed(digits);
const mm = (value, digits = 1) => (value == null ? 'not fitted' : fixed(value, digits) + ' mm');

const STEPS = ['acquire', 'calibrate', 'register', 'integrate', 'tessellate', 'charge', 'segment', 'fit', 'describe', 'store'];
let role = 'admin', shown = null, chosen = null, older = null;
const may = (needed) => ['read', 'scan', 'admin'].indexOf(role) >= ['read', 'scan', 'admin'].indexOf(needed);

function say(error) {
  if (error) console.warn(error);
  $('message').textContent = error ? error.message + (error.data?.remedy ? '. ' + error.data.remedy + '.' : '') : '';
}

// ---- the station

function showStatus(status) {
  const faults = status.devices.filter((device) => device.fault);
  const stopped = status.latched || (status.emergency_stop ? 'emergency stop pressed' : '');
  $('state').textContent = stopped ? 'stopped: ' + stopped : faults.length ? faults[0].name + ' fault' : status.state;
  $('state').className = 'badge' + (stopped || faults.length ? ' wrong' : status.state === 'idle' ? '' : ' busy');
  $('kind').textContent = `${status.station} station, version ${status.version}`;
  $('scan').disabled = !may('scan') || status.state !== 'idle' || Boolean(status.latched);
  $('cancel').disabled = !may('scan') || !status.scan;
  $('reset').disabled = !may('scan') || status.state !== 'idle';
  $('stop').disabled = !may('scan');
  $('progress').hidden = !status.scan;
  if (status.scan) showProgress(status.scan);
  $('devices').replaceChildren(
    ...status.devices.map((device) => element('div',
      [element('span', `${device.name}: ${device.fault || device.state}`), element('span', `${device.model} ${device.serial}`, 'quiet')],
      'device' + (device.fault ? ' fault' : ''))),
    element('p', `Laser ${status.laser ? 'ON' : 'off'}, motor ${status.motor ? 'ON' : 'off'}` +
      (status.table_angle_deg == null ? '' : `, table at ${status.table_angle_deg.toFixed(1)}°`) +
      (status.door_open ? ', door open' : '') + (status.emergency_stop ? ', emergency stop pressed' : '') + '.', 'quiet'));
}

function showProgress({ step, done, total }) {
  const at = STEPS.indexOf(step);
  $('progress').hidden = false;
  $('progress').dataset.step = step;
  $('steps').replaceChildren(...STEPS.map((name, i) =>
    element('li', name + (i === at && total > 1 ? ` ${done}/${total}` : ''), i < at ? 'past' : i === at ? 'now' : '')));
  $('bar').style.width = 100 * (Math.max(0, at) + (total > 0 ? done / total : 0)) / STEPS.length + '%';
  $('steps').querySelector('.now')?.scrollIntoView({ block: 'nearest', inline: 'center' });
}

// ---- the scans

function scanRow(scan) {
  const row = element('tr', '', scan.state + (scan.scan === shown ? ' shown' : ''));
  row.dataset.scan = scan.scan;
  const tool = (name, title, method) => {
    const button = element('button', name, 'small');
    button.title = title;
    button.onclick = (event) => { event.stopPropagation(); say(null); method().then(refresh).catch(say); };
    return button;
  };
  const tools = element('td', '', 'tools');
  if (may('scan') && ['interrupted', 'failed', 'cancelled'].includes(scan.state)) {
    tools.append(tool('resume', 'Go on from the views that are safe', () => call('scan.resume', { scan: scan.scan })));
  }
  if (may('scan') && scan.state !== 'running') {
    tools.append(tool(scan.pinned ? 'unpin' : 'pin', 'A pinned scan is never removed for its age',
      () => call('scan.pin', { scan: scan.scan, pinned: !scan.pinned })));
  }
  if (may('admin') && !scan.pinned && scan.state !== 'running') {
    tools.append(tool('delete', 'Remove it for good', async () => {
      if (confirm(`Remove scan ${scan.scan} for good?`)) await call('scan.delete', { scan: scan.scan });
    }));
  }
  const what = scan.state === 'done' ? scan.types.map(words).join(', ') : scan.state;
  row.append(element('td', String(scan.scan), 'number'),
    element('td', [element('div', what), element('div', [scan.label, new Date(scan.ended).toLocaleString(), scan.error].filter(Boolean).join(' · '), 'quiet')]),
    tools);
  if (scan.state === 'done') row.onclick = () => showObject(scan.scan).catch(say);
  return row;
}

async function showScans() {
  const { scans, next } = await call('scan.list', { limit: 20 });
  older = next;
  $('more').hidden = older === null;
  $('scans').tBodies[0].replaceChildren(...scans.map(scanRow));
}

$('more').onclick = async () => {
  const { scans, next } = await call('scan.list', { limit: 50, before: older });
  older = next;
  $('more').hidden = older === null;
  $('scans').tBodies[0].append(...scans.map(scanRow));
};

// ---- the object

function partCard(part, i) {
  const card = element('div', '', 'part');
  card.id = 'part-' + part.id;
  card.style.borderLeftColor = partColor(i);
  const size = part.size_mm.map((s) => (2 * s).toFixed(1)).join(' × ');
  card.append(element('div', [element('b', words(part.type)), ` ${size} mm`]));
  const more = element('div');
  more.hidden = true;
  const facts = [['residual', mm(part.residual_mm, 2)], ['confidence', part.confidence?.toFixed(2) ?? 'unknown'],
    ['centre', part.pose.position_mm.map((p) => fixed(p, 1)).join(', ') + ' mm'],
    ['turn', ['w', 'x', 'y', 'z'].map((k) => fixed(part.pose.quaternion[k], 3)).join(', ')],
    ['taper', part.taper.map((t) => fixed(t, 2)).join(', ')], ['bend', part.bend_per_mm.toFixed(4) + ' /mm'], ['points', part.points]];
  more.append(element('dl', facts.flatMap(([name, value]) => [element('dt', name), element('dd', String(value))])));
  const greatest = Math.max(...part.all_models.map((model) => model.residual_mm ?? 0), 1e-9);
  const table = element('table', '', 'residuals');
  for (const model of part.all_models) {
    const row = table.insertRow(), bar = element('i');
    bar.style.width = 100 * (model.residual_mm ?? 0) / greatest + '%';
    row.append(element('td', words(model.type)), element('td', mm(model.residual_mm, 3), 'number'), element('td', bar));
    row.lastChild.style.width = '35%';
  }
  more.append(element('div', 'How well each shape fits (residual)', 'quiet'), table);
  card.append(more);
  card.onclick = () => choose(chosen === part.id ? null : part.id);
  return card;
}

function choose(id) {
  chosen = id;
  for (const card of document.querySelectorAll('.part')) {
    const is = card.id === 'part-' + id;
    card.classList.toggle('chosen', is);
    card.lastChild.hidden = !is;
    if (is) card.scrollIntoView({ block: 'nearest', behavior: 'smooth' });
  }
  highlight(id);
}
onPick(choose);

async function showObject(scan) {
  const object = await call('object.describe', scan ? { scan } : {});
  const { grasps } = await call('object.grasps', { scan: object.scan }).catch(() => ({ grasps: [] }));
  shown = object.scan;
  chosen = null;
  $('hint').textContent = '';
  $('object-title').textContent = `Scan ${object.scan}: ${object.n_parts} part${object.n_parts === 1 ? '' : 's'}`;
  $('parts').replaceChildren(...object.parts.map(partCard));
  $('relations').replaceChildren(...object.relations.map((r) => element('div', r.sentence ?? '')), ...(object.notes ?? []).map((note) => element('div', note)));
  const archive = element('button', 'export', 'small');
  archive.onclick = () => download(`/scans/${object.scan}.zip`, `scan_${object.scan}.zip`).catch(say);
  $('object-tools').replaceChildren(archive);
  for (const row of $('scans').rows) row.classList.toggle('shown', row.dataset.scan === String(shown));
  await show(object, grasps, `/scans/${object.scan}/`);
  document.body.dataset.shown = String(object.scan);
}

// ---- what happens

let refreshing = null;
function refresh() {
  // Events come in bursts; one look at the station answers them all.
  refreshing ??= new Promise((resolve) => setTimeout(resolve, 50)).then(async () => {
    refreshing = null;
    showStatus(await call('station.status'));
    await showScans();
  });
  return refreshing;
}

function onEvent(event) {
  if (event.event === 'progress') return showProgress(event);
  if (event.event === 'view') return;
  if (event.event === 'scan' && event.state === 'done') showObject(event.scan).catch(say);
  if (event.event === 'scan' && event.error) say(event.error);
  refresh().catch(say);
}

const call = connect({
  onEvent,
  onOpen: async (granted) => {
    role = granted;
    document.body.dataset.role = role;
    say(null);
    try {
      await refresh();
      await showObject();
    } catch (error) {
      if (error.data?.name !== 'not_found') say(error);
    }
    document.body.dataset.ready = 'yes';
  },
  onLost: () => {
    $('state').textContent = 'not connected';
    $('state').className = 'badge wrong';
  },
});

for (const [id, method] of [['scan', 'scan.start'], ['cancel', 'scan.cancel'], ['stop', 'station.stop'], ['reset', 'station.reset']]) {
  $(id).onclick = () => { say(null); call(method).then(refresh).catch(say); };
}
for (const box of document.querySelectorAll('#layers input')) {
  box.onchange = () => layers(Object.fromEntries([...document.querySelectorAll('#layers input')].map((b) => [b.id.slice(6), b.checked])));
}
$('import').onchange = async () => {
  const [archive] = $('import').files;
  say(null);
  try { if (archive) await upload(archive); } catch (error) { say(error); }
  $('import').value = '';
};
for (const [id, method, text] of [['log', 'log.tail', (answer) => answer.lines.join('\n')], ['calibration', 'calibration.show', (answer) => JSON.stringify(answer, null, 2)]]) {
  $(id).ontoggle = () => {
    if (!$(id).open) return;
    const place = $(id).querySelector('pre');
    call(method).then((answer) => { place.textContent = text(answer); }).catch((error) => { place.textContent = error.message; });
  };
}
