// Elements that several pages share: problems, toasts, picture inputs, jobs in progress.

import {h, replace} from "./dom.js";
import {call, follow, pause, remove} from "./api.js";
import {showable} from "./portable_map.js";

// An error with its advice, and the request id that the log has.
export function problem(error) {
  return h("div", {class: "problem", role: "alert"},
    h("strong", {}, error.title ?? "Something went wrong"),
    h("p", {}, error.message),
    error.errors?.length ? h("ul", {}, error.errors.map((fault) => h("li", {}, h("code", {}, fault.pointer), " ", fault.detail))) : null,
    error.title && error.code
      ? h("p", {class: "muted"}, h("a", {href: `problems/${error.code}`, target: "_blank"}, h("code", {}, error.code)),
        error.requestId ? [" · request ", h("code", {}, error.requestId)] : null) : null);
}

// A message that disappears after some seconds.
export function toast(text) {
  const note = h("p", {class: "toast"}, text);
  document.getElementById("toasts").append(note);
  setTimeout(() => note.remove(), 6000);
}

// A button that runs `work`, once at a time; an error is shown at `place`, or as a toast.
export function act(label, work, {kind = "", place, ...props} = {}) {
  const button = h("button", {type: "button", class: kind, ...props}, label);
  button.addEventListener("click", async () => {
    button.disabled = true;
    try {
      if (place) replace(place);
      await work();
    } catch (error) {
      if (error.name !== "AbortError") place ? replace(place, problem(error)) : toast(error.message);
    } finally {
      button.disabled = false;
    }
  });
  return button;
}

// Asks for confirmation; with `word`, that word has to be typed first.
export function confirm(title, text, doIt, word) {
  return new Promise((resolve) => {
    const typed = word && h("input", {id: "confirm-word", autocomplete: "off", spellcheck: "false", autofocus: true});
    const yes = h("button", {value: "yes", class: "danger", disabled: Boolean(word)}, doIt);
    typed?.addEventListener("input", () => { yes.disabled = typed.value !== word; });
    const dialog = h("dialog", {"aria-labelledby": "confirm-title"},
      h("form", {method: "dialog"}, h("h2", {id: "confirm-title"}, title), h("p", {}, text),
        typed && [h("label", {for: "confirm-word"}, `Type ${word} to go on`), typed],
        h("div", {class: "row end"}, h("button", {type: "button", class: "quiet", onClick: () => dialog.close("")}, "Keep it"), yes)));
    dialog.addEventListener("close", () => { resolve(dialog.returnValue === "yes"); dialog.remove(); });
    document.body.append(dialog);
    dialog.showModal();
  });
}

// Every file of what was dropped, with its path; folders are walked.
async function dropped(items) {
  const files = [];
  async function walk(entry, path) {
    if (entry.isFile) {
      const file = await new Promise((ok, no) => entry.file(ok, no));
      files.push({file, path: path + entry.name});
    } else {
      const reader = entry.createReader();
      for (;;) {
        const some = await new Promise((ok, no) => reader.readEntries(ok, no));
        if (!some.length) break;
        for (const each of some) await walk(each, `${path}${entry.name}/`);
      }
    }
  }
  for (const entry of [...items].map((item) => item.webkitGetAsEntry?.()).filter(Boolean)) await walk(entry, "");
  return files;
}

const isPicture = ({file}) => /^image\//.test(file.type) || /\.(png|jpe?g|pgm|ppm)$/i.test(file.name);

// An input for pictures: drop, choose, or take one with the device's camera. Calls `onPictures` with [{file, path}]; `path`
// has the folders of a dropped or chosen folder.
export function pictures({label, multiple = false, folders = false, camera = true, onPictures}) {
  const take = (list) => {
    const found = list.filter(isPicture);
    if (found.length) onPictures(multiple ? found : found.slice(0, 1));
    else toast("There is no picture (PNG, JPEG, PGM, PPM) in that.");
  };
  const input = (props) => h("input", {type: "file", class: "visually-hidden", accept: "image/png,image/jpeg,.pgm,.ppm", tabindex: "-1",
    "aria-hidden": "true", onChange(event) {
      take([...event.target.files].map((file) => ({file, path: file.webkitRelativePath || file.name})));
      event.target.value = "";
    }, ...props});
  const files = input({multiple});
  const folder = folders ? input({webkitdirectory: true}) : null;
  const zone = h("div", {class: "drop"},
    h("p", {}, label),
    h("div", {class: "row"},
      h("button", {type: "button", onClick: () => files.click()}, multiple ? "Choose pictures" : "Choose a picture"),
      folder && h("button", {type: "button", class: "quiet", onClick: () => folder.click()}, "Choose a folder"),
      camera && h("button", {type: "button", class: "quiet", onClick: () => shoot((file) => take([{file, path: file.name}]), multiple)},
        "Use the camera")),
    files, folder);
  zone.addEventListener("dragover", (event) => { event.preventDefault(); zone.classList.add("over"); });
  zone.addEventListener("dragleave", () => zone.classList.remove("over"));
  zone.addEventListener("drop", async (event) => {
    event.preventDefault();
    zone.classList.remove("over");
    take(await dropped(event.dataTransfer.items));
  });
  return zone;
}

// Shows the device's camera in a dialog until a picture was taken, or with `several` until it is closed.
async function shoot(onPicture, several) {
  let stream;
  try {
    if (!navigator.mediaDevices) throw new Error("insecure");
    stream = await navigator.mediaDevices.getUserMedia({video: {facingMode: "environment", width: {ideal: 1280}}});
  } catch {
    toast(window.isSecureContext ? "The camera can't be used: the browser or the device said no."
      : "Browsers let pages use the camera over HTTPS or from localhost only: serve with --tls-cert and --tls-key.");
    return;
  }
  const video = h("video", {autoplay: true, playsinline: true, muted: true});
  video.srcObject = stream;
  let taken = 0;
  const count = h("span", {class: "muted", role: "status"});
  const dialog = h("dialog", {class: "wide", "aria-label": "Camera"}, video,
    h("div", {class: "row end"}, count,
      h("button", {type: "button", class: "quiet", onClick: () => dialog.close()}, "Done"),
      h("button", {type: "button", onClick() {
        const canvas = h("canvas", {width: video.videoWidth, height: video.videoHeight});
        canvas.getContext("2d").drawImage(video, 0, 0);
        canvas.toBlob((blob) => {
          taken += 1;
          replace(count, `${taken} taken`);
          onPicture(new File([blob], `camera-${Date.now()}.jpg`, {type: "image/jpeg"}));
          if (!several) dialog.close();
        }, "image/jpeg", 0.92);
      }}, "Take a picture")));
  dialog.addEventListener("close", () => { stream.getTracks().forEach((track) => track.stop()); dialog.remove(); });
  document.body.append(dialog);
  dialog.showModal();
}

// The progress of a job, kept up to date by its events; calls `onEnd` with the job when it ended.
function jobProgress(job, signal, onEnd) {
  const text = h("span");
  const bar = h("progress", {"aria-label": `Progress of the ${job.kind}`});
  const cancel = act("Cancel", () => remove(`v1/jobs/${job.id}`),
    {kind: "quiet small", "aria-label": `Cancel the ${job.kind} of ${job.database ?? job.calibration}`});
  const fault = h("div");
  const place = h("div", {class: "job"}, h("div", {class: "row spread"}, text, cancel), bar, fault);
  function draw(body) {
    const {stage, done, total} = body.progress ?? {};
    const going = ["queued", "running"].includes(body.state);
    replace(text, h("strong", {}, body.kind), ` of ${body.database ?? body.calibration} `, state(body.state),
      stage && going ? h("span", {class: "muted"}, ` ${stage} ${done} of ${total}`) : null);
    bar.max = total || 1;
    bar.value = total ? done : 0;
    cancel.hidden = bar.hidden = !going;
    replace(fault, body.problem ? problem({title: body.problem.title, message: body.problem.detail ?? body.problem.title,
      code: body.problem.code}) : null);
  }
  draw(job);
  whileVisible((visible) => follow(`v1/jobs/${job.id}/events`, draw, visible), signal).then((ended) => ended && onEnd?.(ended))
    .catch((error) => {
      if (error.name !== "AbortError") replace(place, problem(error));
    });
  return place;
}

// Runs `work` while the page is visible, again whenever it becomes visible; the signal that `work` takes is aborted when it is hidden.
export async function whileVisible(work, signal) {
  while (!signal.aborted) {
    if (document.hidden) {
      await new Promise((wake) => {
        document.addEventListener("visibilitychange", wake, {once: true});
        signal.addEventListener("abort", wake, {once: true});
      });
      continue;
    }
    const hidden = new AbortController();
    const left = AbortSignal.any([signal, hidden.signal]);
    document.addEventListener("visibilitychange", () => hidden.abort(), {signal: left});
    try {
      const done = await work(left);
      if (!left.aborted) return done;
    } catch (error) {
      if (!hidden.signal.aborted) throw error;
    } finally {
      hidden.abort();
    }
  }
}

const FOLLOWED = 2;
// The jobs that are queued or running. Two are kept up to date by their events while the page is visible, the rest each time
// the list is fetched: a browser opens six connections to a service, for all its tabs.
export function liveJobs(place, signal, onEnd) {
  const shown = new Map();
  return (jobs) => {
    const active = jobs.filter((job) => ["queued", "running"].includes(job.state)).reverse();
    for (const [id, {node}] of shown) {
      if (active.some((job) => job.id === id)) continue;
      node.remove();
      shown.delete(id);
    }
    active.forEach((job, index) => {
      const had = shown.get(job.id);
      if (had?.followed) return;
      const followed = index < FOLLOWED;
      const node = followed ? jobProgress(job, signal, onEnd)
        : h("div", {class: "job row spread"}, h("span", {}, h("strong", {}, job.kind), ` of ${job.database ?? job.calibration} `,
          state(job.state)), act("Cancel", () => remove(`v1/jobs/${job.id}`), {kind: "quiet small"}));
      had ? had.node.replaceWith(node) : place.append(node);
      shown.set(job.id, {node, followed});
    });
  };
}

// The outcome of a job that ended: its version, the comparison with the one in use, or the error.
export function outcome(job) {
  const {comparison: compared, problem: fault, version} = job;
  return [
    version && job.database ? h("a", {href: `#/versions/${encodeURIComponent(job.database)}/${version}`}, `version ${version}`) : null,
    compared && verdict(compared),
    fault && h("span", {}, fault.detail ?? fault.title)].filter(Boolean).flatMap((part, index) => index ? [" ", part] : [part]);
}

// Whether a version was promoted, and why.
export function verdict({against_version: against, trials, candidate_right: candidate, current_right: current, p_value: chance, promoted}) {
  if (against === null) return h("span", {}, "promoted: there was no version to compare with.");
  return h("span", {}, h("strong", {}, promoted ? "promoted" : "not promoted"),
    `: ${candidate} of ${trials} right, version ${against} in use ${current} of ${trials} `
    + `(p = ${number(chance, 3)}; below 0.05 counts as worse).`);
}

// Polls: runs `refresh` every few seconds while the page is visible, until it is left or the key is refused.
export async function poll(refresh, signal, onFault, seconds = 5) {
  while (!signal.aborted) {
    await pause(seconds, signal);
    if (signal.aborted || document.hidden) continue;
    try {
      await refresh();
      onFault?.(null);
    } catch (error) {
      if (error.name === "AbortError") return;
      onFault?.(error);
      if ([401, 403, 404].includes(error.status)) return;
    }
  }
}

// Lazy loading: a picture is fetched when it comes near the viewport.
const near = new IntersectionObserver((entries) => {
  for (const {isIntersecting, target} of entries) {
    if (!isIntersecting) continue;
    near.unobserve(target);
    target.dispatchEvent(new Event("near"));
  }
}, {rootMargin: "300px"});

export function remotePicture(path, alt, signal, props) {
  const image = h("img", {alt, title: alt, ...props});
  image.addEventListener("near", async () => {
    try {
      const sent = await call("GET", path, {signal}).catch(async (error) => {
        if (![429, 503].includes(error.status)) throw error;
        await pause(error.retryAfter || 1, signal);
        return call("GET", path, {signal});
      });
      const url = URL.createObjectURL(await showable(await sent.blob()));
      const done = () => URL.revokeObjectURL(url);
      image.addEventListener("load", done);
      image.addEventListener("error", done);
      image.src = url;
    } catch {
      image.alt = `${alt} (can't be fetched)`;
    }
  });
  near.observe(image);
  return image;
}

// The word of a state, coloured by it.
export const state = (word) => h("span", {class: `state ${word}`}, word);

// A local time, with the exact one on hover.
export const time = (rfc3339) => rfc3339 ? h("time", {datetime: rfc3339, title: rfc3339}, new Date(rfc3339).toLocaleString()) : "never";

export const number = (value, digits = 2) => value === null || value === undefined ? "–"
  : Number(value).toLocaleString("en", {maximumFractionDigits: digits});

// "1 picture", "2 pictures".
export const count = (many, word) => `${many.toLocaleString("en")} ${word}${many === 1 ? "" : "s"}`;
