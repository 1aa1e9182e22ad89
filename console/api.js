// Calls of the service. Paths are given without the leading slash, so that the console also works below a prefix.

const KEY = "landmarkd-key";

// An error answer of the service (RFC 9457).
export class Problem extends Error {
  constructor(body, retryAfter = 0) {
    super(body.detail ?? body.title);
    const {status, code, title, errors = [], request_id: requestId} = body;
    Object.assign(this, {status, code, title, errors, requestId, retryAfter});
  }
}

// Waits for `seconds`, or until `signal` is aborted.
export const pause = (seconds, signal) => new Promise((wake) => {
  const done = () => { clearTimeout(timer); signal?.removeEventListener("abort", done); wake(); };
  const timer = setTimeout(done, 1000 * seconds);
  signal?.addEventListener("abort", done);
});

let ask = async () => null;
// Sets the function that asks the person for a key when the service requires one; app.js calls it once.
export const onKeyAsked = (asked) => { ask = asked; };
export const key = () => sessionStorage.getItem(KEY);
export const setKey = (value) => value ? sessionStorage.setItem(KEY, value) : sessionStorage.removeItem(KEY);

let asking = null;
async function newKey(refused) {
  asking ??= ask(refused).finally(() => { asking = null; });
  const given = await asking;
  if (given) setKey(given);
  return given;
}

// Makes one call; resolves to the Response, throws a Problem. Sends `json` or `body`; `accept` is the media type of the answer.
export async function call(method, path, {json, body, type, accept, headers = {}, signal} = {}) {
  const sent = {...headers};
  if (json !== undefined) { body = JSON.stringify(json); type = "application/json"; }
  if (type) sent["Content-Type"] = type;
  if (accept) sent.Accept = accept;
  for (;;) {
    const used = key();
    if (used) sent.Authorization = `Bearer ${used}`;
    let answer;
    try {
      answer = await fetch(path, {method, headers: sent, body, signal, cache: "no-store"});
    } catch (error) {
      if (error.name === "AbortError") throw error;
      throw new Problem({status: 0, title: "The service can't be reached",
        detail: "The service didn't answer: is it still running? Try again in a moment."});
    }
    if (answer.ok) return answer;
    const problem = await answer.json().catch(() => ({status: answer.status, title: `HTTP ${answer.status} ${answer.statusText}`}));
    if (answer.status === 401 && (key() !== used || await newKey(problem))) continue;
    throw new Problem(problem, Number(answer.headers.get("Retry-After")) || 0);
  }
}

export const get = async (path, options) => (await call("GET", path, options)).json();
export const post = async (path, options) => (await call("POST", path, options)).json();
export const put = async (path, json) => (await call("PUT", path, {json})).json();
export const remove = async (path) => { await call("DELETE", path); };

// Fetches a picture and gives an object URL for an <img>; the caller revokes it.
export const blobUrl = async (path, options) => URL.createObjectURL(await (await call("GET", path, options)).blob());

// All items of a list, at most `most`.
export async function all(path, {most = 10000, signal} = {}) {
  const items = [];
  let cursor = null;
  do {
    const url = path + (path.includes("?") ? "&" : "?") + "limit=500" + (cursor ? `&cursor=${encodeURIComponent(cursor)}` : "");
    const page = await get(url, {signal});
    items.push(...page.items);
    cursor = page.next_cursor;
  } while (cursor && items.length < most);
  return items;
}

// Reads a stream of server-sent events to its end, with the key in a header, which an EventSource cannot send. Reconnects with
// Last-Event-ID when the connection breaks, and after Retry-After when the service sends one. `seen.id` is the last event's: who
// keeps it goes on from there.
export async function follow(path, onEvent, signal, seen = {id: null}) {
  for (let failures = 0; !signal?.aborted;) {
    let retryAfter = 0;
    try {
      const answer = await call("GET", path, {accept: "text/event-stream", headers: seen.id ? {"Last-Event-ID": seen.id} : {}, signal});
      const reader = answer.body.pipeThrough(new TextDecoderStream()).getReader();
      let text = "";
      for (;;) {
        const {done, value} = await reader.read();
        if (done) break;
        text += value;
        const events = text.split(/\r?\n\r?\n/);
        text = events.pop();
        for (const event of events) {
          let data = "";
          for (const line of event.split(/\r?\n/)) {
            if (line.startsWith("id:")) seen.id = line.slice(3).trim();
            else if (line.startsWith("data:")) data += line.slice(5).trim();
          }
          if (!data) continue;
          failures = 0;
          const body = JSON.parse(data);
          onEvent(body);
          if (["succeeded", "failed", "cancelled"].includes(body.state)) return body;
        }
      }
    } catch (error) {
      if (error.name === "AbortError"
        || (error instanceof Problem && error.status >= 400 && error.status < 500 && ![408, 429].includes(error.status))) throw error;
      ({retryAfter = 0} = error);
    }
    failures += 1;
    await pause(Math.max(retryAfter, Math.min(failures, 10)), signal);
  }
}
