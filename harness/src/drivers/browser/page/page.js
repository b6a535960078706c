// Fetches jobs and posts their results until the server is gone. Then the page closes, and the browser with it.
//
// A message in either direction: the length of a JSON text in bytes as a little-endian u32, the text, spaces up to a multiple
// of 16 bytes, the payload.
"use strict";

const apis = { webgpu, webgl2 };

function pack(head, payload = new Uint8Array(0)) {
  let text = new TextEncoder().encode(JSON.stringify(head));
  const padded = new Uint8Array(Math.ceil((4 + text.length) / 16) * 16).fill(32);
  new DataView(padded.buffer).setUint32(0, padded.length - 4, true);
  padded.set(text, 4);
  return new Blob([padded, payload]);
}

function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, length)));
  return { head, payload: new Uint8Array(buffer, 4 + length) };
}

// The driver of each interface, or why there is no driver.
async function introduction() {
  const found = {};
  for (const [name, api] of Object.entries(apis)) {
    try {
      found[name] = { driver: await api.open() };
    } catch (error) {
      found[name] = { error: error.message };
    }
  }
  return pack(found);
}

async function run({ head, payload }) {
  try {
    const api = apis[head.api];
    switch (head.job) {
      case "compile":
        await api.compile(head, tables(head.tables, payload));
        return pack({});
      case "draw":
        return pack({}, await api.draw(head));
      case "free":
        api.free(head.id);
        return pack({});
      default:
        throw new Error(`the page does not know the job ${head.job}`);
    }
  } catch (error) {
    return pack({ error: error.message });
  }
}

// The tables of a job. Their bytes follow each other in the payload.
function tables(list, payload) {
  let at = 0;
  return list.map((table) => {
    const bytes = payload.subarray(at, at + table.bytes);
    at += table.bytes;
    return { ...table, data: bytes };
  });
}

(async () => {
  new Worker("alive.js");
  let reply = await introduction();
  for (;;) {
    const response = await fetch("next", { method: "POST", body: reply }).catch(() => null);
    if (!response?.ok) {
      window.close();
      return;
    }
    reply = await run(unpack(await response.arrayBuffer()));
  }
})();
