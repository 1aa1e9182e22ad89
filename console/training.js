// The form that trains a database: the options of its kind, by the OpenAPI document, and whether the version is promoted.

import {h, replace} from "./dom.js";
import {call, get, put} from "./api.js";
import {act, problem} from "./parts.js";

const MAIN_OPTIONS = {landmarks: ["preset", "method", "viewpoint", "signature"], objects: ["segment", "appearance", "dimension", "stages"]};
// Options that may be none. For the others null means the database's value.
const MAY_BE_NONE = ["position_prior_px", "width_px", "height_px"];
const PROMOTE = {always: "always", if_not_worse: "if it is not worse than the one in use", never: "never: I shall do it myself"};

// The OpenAPI document names the options, their meaning and their bounds; fetched once a tab.
let contract = null;
async function optionsOf(kind) {
  contract ??= get("openapi.json").catch((error) => { contract = null; throw error; });
  const {components: {schemas}} = await contract;
  const resolve = (schema) => {
    const named = schema.$ref ? schemas[schema.$ref.split("/").at(-1)] : schema;
    const one = named.oneOf?.find((each) => each.type !== "null");
    return {...(one && named.oneOf.some((each) => each.type === "null") ? resolve(one) : named),
      ...(schema.description && {description: schema.description})};
  };
  const {properties} = schemas[kind === "landmarks" ? "LandmarkOptionsBody" : "ObjectOptionsBody"];
  return Object.entries(properties).map(([name, schema]) => ({name, ...resolve(schema)}));
}

const words = (name) => name.replace(/_(px|deg|mm)$/, " ($1)").replaceAll("_", " ");
const shownValue = (value) => value === null || value === undefined ? "none" : Array.isArray(value) ? value.join(", ") : String(value);

// A field of an option: empty means the database's value. `read` gives the value, or undefined.
function optionField({name, type, enum: choices, minimum, maximum, description}, kept) {
  const id = `option-${name}`;
  const types = [type].flat();
  const mayBeNone = MAY_BE_NONE.includes(name);
  const help = [description ?? "", mayBeNone ? "Type `none` for none." : ""].filter(Boolean).join(" ");
  const hint = h("p", {class: "muted hint", id: `${id}-hint`},
    help.split("`").map((text, index) => index % 2 ? h("code", {}, text) : text));
  let input;
  let read;
  if (choices || types.includes("boolean")) {
    input = h("select", {id}, h("option", {value: ""}, `as it is: ${shownValue(kept)}`),
      (choices ?? ["true", "false"]).map((value) => h("option", {value}, value)));
    read = () => choices ? input.value : input.value === "true";
  } else if (mayBeNone) {
    input = h("input", {id, pattern: "\\s*(none|[0-9]+([.][0-9]+)?)\\s*", title: "A number, or none", placeholder: shownValue(kept),
      spellcheck: "false", autocomplete: "off"});
    read = () => input.value.trim() === "none" ? null : Number(input.value);
  } else if (types.includes("integer") || types.includes("number")) {
    input = h("input", {id, type: "number", min: minimum, max: maximum, step: types.includes("integer") ? 1 : "any",
      placeholder: shownValue(kept)});
    read = () => Number(input.value);
  } else {
    input = h("input", {id, placeholder: shownValue(kept), spellcheck: "false"});
    read = () => {
      const words = input.value.split(/[,\s]+/).filter(Boolean);
      const parts = words.map((word) => Number.isNaN(Number(word)) ? word : Number(word));
      return parts.length === 1 ? parts[0] : parts;
    };
  }
  if (help) input.setAttribute("aria-describedby", hint.id);
  return {name, input, read: () => input.value === "" ? undefined : read(),
    node: h("div", {}, h("label", {for: id}, words(name)), input, hint)};
}

// `onQueued` is called when a job was queued.
export function training(page, onQueued) {
  const place = h("div");
  const main = h("div", {class: "main-options"});
  const rest = h("div", {class: "fields"});
  const promote = h("select", {id: "promote"}, Object.entries(PROMOTE).map(([value, text]) => h("option", {value}, text)));
  const keep = h("input", {type: "checkbox", id: "keep-options"});
  const form = h("form", {onSubmit: (event) => event.preventDefault()}, main,
    h("details", {}, h("summary", {}, "All options"),
      h("p", {class: "muted"}, "An empty field stays as it is. Another method, viewpoint or signature starts from its own defaults."), rest,
      h("p", {class: "row"}, keep, h("label", {for: "keep-options"}, "Keep these options for later trainings too"))),
    h("div", {class: "promotion"}, h("label", {for: "promote"}, "Let the new version answer"), promote),
    h("div", {class: "row"}, act("Train", train, {place, type: "submit", id: "train"})), place);
  let fields = [];

  async function draw() {
    const [options, {options: kept}] = await Promise.all([optionsOf(page.kind), get(page.path, {signal: page.signal})]);
    fields = options.map((option) => optionField(option, kept[option.name]));
    const isMain = ({name}) => MAIN_OPTIONS[page.kind].includes(name);
    replace(main, fields.filter(isMain).map((field) => field.node));
    replace(rest, fields.filter((field) => !isMain(field)).map((field) => field.node));
  }

  async function train() {
    const wrong = fields.find((field) => !field.input.checkValidity());
    if (wrong) form.querySelector("details").open = true;
    if (!form.reportValidity()) return;
    const options = Object.fromEntries(fields.map((field) => [field.name, field.read()]).filter(([, value]) => value !== undefined));
    await call("POST", `${page.path}/trainings`, {json: {options, promote: promote.value}});
    try {
      if (keep.checked) { await keepOptions(page, options); keep.checked = false; await draw(); }
    } finally {
      await onQueued();
    }
  }

  draw().catch((error) => { if (error.name !== "AbortError") replace(place, problem(error)); });
  return form;
}

// The call replaces all options of the database, so the others are sent along, unless the method or viewpoint changes, or a
// preset is where they start from.
async function keepOptions(page, options) {
  const {kind, options: kept} = await get(page.path);
  const another = ["method", "viewpoint", "signature"].some((name) => options[name] && options[name] !== kept[name]);
  const base = options.preset ? {} : another ? {method: kept.method, viewpoint: kept.viewpoint, signature: kept.signature} : kept;
  await put(page.path, {kind, options: {...base, ...options}});
}
