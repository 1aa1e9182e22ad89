// Labelled inputs of forms, and the mark on those that an error names.

import {h} from "./dom.js";

// How the service names things, as a pattern of an input.
export const NAME = "[A-Za-z0-9][A-Za-z0-9_.\\-]{0,63}";

let count = 0;
const labelled = (label, input, hint) => {
  input.id ||= `field-${++count}`;
  const note = hint ? h("span", {class: "hint", id: `${input.id}-hint`}, hint) : null;
  if (note) input.setAttribute("aria-describedby", note.id);
  return h("div", {class: "field"}, h("label", {for: input.id}, label), input, note);
};

export const numberField = (label, name, value, {hint, ...props} = {}) =>
  labelled(label, h("input", {type: "number", name, step: "any", inputmode: "decimal", value: value ?? "", ...props}), hint);

export const textField = (label, name, value, {hint, ...props} = {}) =>
  labelled(label, h("input", {type: "text", name, value: value ?? "", autocomplete: "off", spellcheck: "false", ...props}), hint);

// `options` are [value, words].
export const choiceField = (label, name, options, value, {hint, ...props} = {}) =>
  labelled(label, h("select", {name, ...props},
    options.map(([each, words]) => h("option", {value: each, selected: each === value}, words))), hint);

export const checkField = (label, name, checked, hint) => {
  const input = h("input", {type: "checkbox", name, checked});
  input.id = `field-${++count}`;
  return h("div", {class: "field check"}, input, h("label", {for: input.id}, label), hint ? h("span", {class: "hint"}, hint) : null);
};

// The number in a field; undefined if it is empty.
export const numberIn = (form, name) => {
  const text = form.elements[name].value.trim();
  return text === "" ? undefined : Number(text);
};

// Marks the fields whose names are in the pointers of an error, and unmarks the others.
export function markFaults(form, error) {
  const wrong = new Set((error?.errors ?? []).flatMap(({pointer}) => pointer.split(/[/#]/)));
  for (const field of form.elements) {
    if (field.name && wrong.has(field.name)) field.setAttribute("aria-invalid", "true");
    else field.removeAttribute("aria-invalid");
  }
}

// Lets the browser save bytes.
export function download(blob, name) {
  const address = URL.createObjectURL(blob);
  h("a", {href: address, download: name}).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}
