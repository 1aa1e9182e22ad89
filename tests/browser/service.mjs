// The real service as a process of its own, over a folder of its own, on a port that the system chooses.

import {execFile, spawn} from "node:child_process";
import {mkdtemp, rm} from "node:fs/promises";
import {tmpdir} from "node:os";
import {join} from "node:path";
import {createInterface} from "node:readline";
import {promisify} from "node:util";

const BINARY = process.env.LANDMARKD_BINARY;
const WAIT_MS = 20_000;

// The environment without settings of the service.
const environment = () => Object.fromEntries(Object.entries(process.env).filter(([name]) => !name.startsWith("LANDMARKD_")));

export class Service {
  // With `key`, the service asks for one from its start.
  static async start({key = false} = {}) {
    if (!BINARY) throw new Error("LANDMARKD_BINARY names no binary: run.sh sets it");
    const service = new Service();
    service.folder = await mkdtemp(join(tmpdir(), "landmarkd-browser-"));
    if (key) {
      const made = await promisify(execFile)(BINARY, ["keys", "create", "--name", "tester", "--scope", "admin", "--data-dir", service.folder], {env: environment()});
      service.key = /lmk_\w+/.exec(made.stdout)[0];
    }
    service.child = spawn(BINARY, ["serve", "--data-dir", service.folder, "--bind", "127.0.0.1:0", "--threads", "2", "--log-format", "json"], {env: environment(), stdio: ["ignore", "ignore", "pipe"]});
    service.ended = new Promise((resolve) => service.child.once("exit", (code, signal) => resolve(code ?? signal)));
    process.once("exit", () => service.child.kill("SIGKILL"));
    service.url = `http://${await service.#address()}/`;
    return service;
  }

  // What it prints once it listens. Its log is read to its end: a full pipe would stop it.
  #address() {
    const log = [];
    return new Promise((resolve, reject) => {
      const fail = () => reject(new Error(`the service doesn't listen:\n${log.join("\n")}`));
      const late = setTimeout(fail, WAIT_MS);
      this.ended.then(fail);
      createInterface(this.child.stderr).on("line", (line) => {
        log.push(line);
        const {address} = /^\{/.test(line) ? JSON.parse(line) : {};
        if (!address) return;
        clearTimeout(late);
        resolve(address);
      });
    });
  }

  // Ask it to end, as a supervisor does; its folder goes with it.
  async stop() {
    this.child.kill("SIGTERM");
    const status = await this.ended;
    await rm(this.folder, {recursive: true, force: true});
    if (status !== 0) throw new Error(`the service ended with ${status}`);
  }

  // A call beside the browser: its JSON, or an error with the answer's text.
  async call(method, path, {json, body} = {}) {
    const headers = {...this.key && {Authorization: `Bearer ${this.key}`}, ...json !== undefined && {"Content-Type": "application/json"}};
    const answer = await fetch(this.url + path, {method, headers, body: json === undefined ? body : JSON.stringify(json)});
    const text = await answer.text();
    if (!answer.ok) throw new Error(`${method} ${path}: ${text}`);
    return text ? JSON.parse(text) : null;
  }

  // A database with exemplars, as {label: [[name of the file, bytes]]}; trained if `options` are given.
  async database(name, kind, exemplars, options) {
    await this.call("PUT", `v1/databases/${name}`, {json: {kind}});
    const form = new FormData();
    const files = Object.entries(exemplars).flatMap(([label, list]) => list.map(([file, bytes]) => ({label, file, bytes})));
    const manifest = files.map(({label, file}, index) => ({file: `${index}`, label, pose_deg: file.includes("__") ? Number(/__([\d.]+)\.png$/.exec(file)[1]) : undefined}));
    form.append("manifest", JSON.stringify(manifest));
    files.forEach(({bytes, file}, index) => form.append(`${index}`, new Blob([bytes], {type: "image/png"}), file));
    const {created} = await this.call("POST", `v1/databases/${name}/exemplars:batch`, {body: form});
    if (created !== files.length) throw new Error(`${created} of ${files.length} exemplars were kept`);
    if (options) await this.train(name, options);
  }

  // Gives the exemplars of a database poses on that map: a metre apart by label, 20 cm and 15 degrees within one. Gives them.
  async place(name, map) {
    const {items} = await this.call("GET", `v1/databases/${name}/exemplars?limit=1000`);
    const labels = [...new Set(items.map(({label}) => label))].sort();
    const placed = [];
    for (const {id, label} of items) {
      const before = placed.filter((exemplar) => exemplar.label === label).length;
      const pose = {map, x_m: labels.indexOf(label), y_m: 0.2 * before, yaw_deg: 90 + 15 * before};
      placed.push(await this.call("PATCH", `v1/databases/${name}/exemplars/${id}`, {json: {pose}}));
    }
    return placed;
  }

  async train(name, options = {}) {
    let job = await this.call("POST", `v1/databases/${name}/trainings`, {json: {options}});
    while (["queued", "running"].includes(job.state)) {
      await new Promise((wake) => setTimeout(wake, 50));
      job = await this.call("GET", `v1/jobs/${job.id}`);
    }
    if (job.state !== "succeeded") throw new Error(`the training ${job.state}: ${JSON.stringify(job.problem)}`);
    return job.version;
  }
}
