// SPDX-License-Identifier: Apache-2.0
// The one connection of the page: methods of geond over a WebSocket, and files over HTTP, both with the token if there is one.

const token = () => sessionStorage.getItem('token');
export const authorization = () => (token() ? { Authorization: 'Bearer ' + token() } : {});

// Connects, and again whenever the connection is lost. `onOpen` runs once one may ask; `onEvent` gets each event.
export function connect({ onOpen, onEvent, onLost }) {
  const waiting = new Map();
  let socket, nextId = 1;

  const call = (method, params = {}) => new Promise((resolve, reject) => {
    if (socket?.readyState !== WebSocket.OPEN) return reject({ message: 'geond does not answer' });
    const id = nextId++;
    waiting.set(id, { resolve, reject });
    socket.send(JSON.stringify({ jsonrpc: '2.0', id, method, params }));
  });

  function open() {
    socket = new WebSocket(`${location.protocol === 'https:' ? 'wss' : 'ws'}://${location.host}/ws`);
    socket.onopen = async () => {
      try {
        const role = token() ? (await call('auth.login', { token: token() })).role : 'admin';
        await call('events.subscribe');
        await onOpen(role);
      } catch (error) {
        if (error.data?.name !== 'forbidden') throw error;
        sessionStorage.setItem('token', prompt('Token of this station') ?? '');
        socket.close();
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
      for (const { reject } of waiting.values()) reject({ message: 'The connection to geond was lost' });
      waiting.clear();
      onLost();
      setTimeout(open, 1000);
    };
  }
  open();
  return call;
}

export async function file(path) {
  const response = await fetch(path, { headers: authorization() });
  if (!response.ok) throw { message: `${path} cannot be had (${response.status})` };
  return response;
}

// Hands a file that needs the token to the browser's downloads.
export async function download(path, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(await (await file(path)).blob());
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}

// Sends an archive of a scan to be taken in.
export async function upload(archive) {
  const response = await fetch('/scans', { method: 'POST', headers: { ...authorization(), 'Content-Type': 'application/zip' }, body: archive });
  const text = await response.text();
  let answer;
  try { answer = JSON.parse(text); } catch { throw { message: text.trim() }; }
  if (!response.ok) throw answer.error;
  return answer;
}
