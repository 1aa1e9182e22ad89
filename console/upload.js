// The upload of exemplars: dropped, chosen or taken with the camera, labelled, and sent in batches.

import {h, replace} from "./dom.js";
import {post} from "./api.js";
import {act, count, pictures, problem, toast} from "./parts.js";
import {NAME} from "./fields.js";

// One batch: small enough that progress moves, and that little is sent again when the connection breaks.
const BATCH_FILES = 16;
const BATCH_BYTES = 8 << 20;

const poseOfName = (name) => {
  const found = /__(\d+(?:\.\d+)?)\.[^.]+$/.exec(name);
  return found ? Number(found[1]) : undefined;
};
const tidy = (folder) => folder.replace(/[^A-Za-z0-9_.-]+/g, "-").replace(/^[^A-Za-z0-9]+/, "").slice(0, 64);

// Pictures are staged by folder first, so that labels can be corrected, and then sent in small batches.
export function upload(page) {
  const staged = new Map(); // folder -> {label input, files}
  let isSending = false;
  const table = h("div", {id: "staged"});
  const report = h("div", {id: "upload-report", role: "status"});
  const pose = h("input", {id: "first-pose", type: "number", min: "0", max: "359.999", step: "any"});
  const step = h("input", {id: "pose-step", type: "number", step: "any", value: "5"});
  const turntable = page.kind === "objects" && h("details", {},
    h("summary", {}, "Poses"),
    h("p", {class: "muted"}, "A name that ends in ", h("code", {}, "__<degrees>"),
      " before its extension says the pose. For other pictures, in the order of their names, in degrees:"),
    h("div", {class: "fields"}, h("div", {}, h("label", {for: "first-pose"}, "First pose (°)"), pose),
      h("div", {}, h("label", {for: "pose-step"}, "Turn between two (°)"), step)));

  function gather(files) {
    for (const {file, path} of files) {
      const folder = path.split("/").at(-2) ?? "";
      if (!staged.has(folder)) {
        const id = `staged-label-${staged.size}-${Date.now()}`;
        const known = folder ? tidy(folder) : [...staged.values()].at(-1)?.input.value;
        staged.set(folder, {files: [], id,
          input: h("input", {id, value: known ?? "", pattern: NAME, required: true, maxlength: "64", placeholder: "label",
            spellcheck: "false"})});
      }
      staged.get(folder).files.push({file, path});
    }
    draw();
    if (!staged.has("") || staged.get("").input.value) return;
    // While the camera's dialog is open, nothing behind it can be focused.
    const camera = document.querySelector("dialog[open]");
    const ask = () => staged.get("")?.input.focus();
    camera ? camera.addEventListener("close", ask, {once: true}) : ask();
  }

  function draw() {
    if (!staged.size) return replace(table);
    const files = [...staged.values()].reduce((sum, group) => sum + group.files.length, 0);
    const place = h("div");
    const form = h("form", {onSubmit: (event) => event.preventDefault()},
      [...staged].map(([folder, group]) => h("div", {class: "row staged"},
        h("label", {for: group.id}, folder ? `Label of folder ${folder}` : "Label"), group.input,
        h("span", {class: "muted"}, count(group.files.length, "picture")),
        h("button", {type: "button", class: "quiet small", "aria-label": `Leave out ${folder || "these pictures"}`,
          onClick() { staged.delete(folder); draw(); }}, "Leave out"))),
      turntable,
      h("div", {class: "row"}, act(`Upload ${count(files, "picture")}`, async () => { if (form.reportValidity()) await send(); },
        {place, type: "submit", id: "upload", disabled: isSending})), place);
    replace(table, form);
  }

  async function send() {
    // Pictures that are dropped meanwhile are staged again.
    const groups = [...staged];
    staged.clear();
    isSending = true;
    draw();
    const waiting = groups.flatMap(([, {files, input}]) => {
      let turned = 0;
      return [...files].sort((a, b) => a.path.localeCompare(b.path, "en", {numeric: true})).map(({file, path}) => {
        let pose_deg = poseOfName(file.name);
        if (pose_deg === undefined && page.kind === "objects" && pose.value !== "") {
          pose_deg = (((Number(pose.value) + Number(step.value) * turned++) % 360) + 360) % 360;
        }
        return {file, path, label: input.value, pose_deg};
      });
    });
    const total = waiting.length;
    const sums = {created: 0, duplicates: 0, rejected: 0};
    const refused = [];
    const stop = new AbortController();
    const bar = h("progress", {max: total, value: 0, "aria-label": "Pictures sent"});
    const status = h("span", {});
    const leave = () => stop.abort();
    page.signal.addEventListener("abort", leave);
    const halt = h("button", {type: "button", class: "quiet small", onClick: leave}, "Stop");
    const list = h("ul", {});
    replace(report, h("div", {class: "row spread"}, status, halt), bar, list);
    let failure = null;
    let sent = 0;
    while (sent < total && !failure) {
      const batch = nextBatch(waiting, sent);
      try {
        const answer = await sendBatch(page, batch, stop.signal);
        for (const key of Object.keys(sums)) sums[key] += answer[key];
        for (const item of answer.items.filter((item) => item.status === "rejected")) {
          const {path, label} = batch[Number(item.file)];
          refused.push(path);
          list.append(h("li", {}, h("code", {}, path), ` (${label}): `, whyOf(item.problem)));
        }
        sent += batch.length;
      } catch (error) {
        failure = error;
      }
      bar.value = sent;
      replace(status, `${sent} of ${total} sent: ${sums.created} kept, ${sums.duplicates} were there, ${sums.rejected} refused.`);
    }
    page.signal.removeEventListener("abort", leave);
    halt.remove();
    bar.remove();
    // What wasn't sent stays staged.
    const done = new Set(waiting.slice(0, sent).map(({file}) => file));
    for (const [folder, group] of groups) {
      group.files = group.files.filter(({file}) => !done.has(file));
      if (!group.files.length) continue;
      if (staged.has(folder)) staged.get(folder).files.unshift(...group.files);
      else staged.set(folder, group);
    }
    isSending = false;
    draw();
    if (failure && failure.name !== "AbortError") report.append(problem(failure));
    if (!page.signal.aborted) await page.refresh();
    if (!failure && !refused.length) toast(`${count(sums.created, "exemplar")} added.`);
  }

  return h("div", {},
    pictures({label: "Drop pictures here, or folders of them: a folder's name is their label.", multiple: true, folders: true,
      onPictures: gather}),
    table, report);
}

function nextBatch(files, from) {
  let bytes = 0;
  let to = from;
  while (to < files.length && to - from < BATCH_FILES && (to === from || bytes + files[to].file.size <= BATCH_BYTES)) {
    bytes += files[to++].file.size;
  }
  return files.slice(from, to);
}

// Parts are named by their number: a file's name may hold what a form can't.
function sendBatch(page, files, signal) {
  const form = new FormData();
  form.append("manifest", JSON.stringify(files.map(({label, pose_deg}, index) => ({file: `${index}`, label, pose_deg}))));
  files.forEach(({file}, index) => form.append(`${index}`, file, `${index}`));
  return post(`${page.path}/exemplars:batch`, {body: form, signal});
}

const whyOf = (fault) => fault.errors?.length ? fault.errors.map((error) => error.detail).join("; ") : fault.detail ?? fault.title;
