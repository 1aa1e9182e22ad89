// What the optics of the form would measure, before the rig is bought: the expected error by distance, and what to change.

import {h, replace} from "./dom.js";
import {post} from "./api.js";
import {act, number} from "./parts.js";
import {lineChart} from "./charts.js";
import {markFaults, numberField, numberIn} from "./fields.js";

// `optics` gives the optics of the page's form when it is asked for.
export function predictionCard(optics, signal) {
  const form = h("form", {onSubmit: (event) => event.preventDefault()}, h("div", {class: "fields"},
    numberField("From, mm", "range_from", undefined, {min: 0, hint: "Empty: the near focus."}),
    numberField("To, mm", "range_to", undefined, {min: 0, hint: "Empty: the far focus."}),
    numberField("Contrast of the texture", "contrast", 40,
      {min: 0, hint: "Standard deviation in gray levels of 255: 40 is gravel, 10 is faint."}),
    numberField("Noise of a pixel", "noise_sigma", 1, {min: 0, hint: "Standard deviation in gray levels of 255."})));
  const fault = h("div", {});
  const result = h("div", {id: "prediction"});
  async function run() {
    const [from, to] = [numberIn(form, "range_from"), numberIn(form, "range_to")];
    const sent = {optics: optics(), contrast: numberIn(form, "contrast"), noise_sigma: numberIn(form, "noise_sigma"),
      ...from !== undefined && to !== undefined ? {range_mm: [from, to]} : {}};
    replace(result);
    try {
      replace(result, ...predicted(await post("v1/optics:predict", {json: sent, signal})));
      markFaults(form, null);
    } catch (error) {
      markFaults(form, {errors: (error?.errors ?? []).map(({pointer, ...rest}) =>
        ({...rest, pointer: pointer.replace("range_mm", "range_from/range_to")}))});
      throw error;
    }
  }
  return h("details", {class: "card", id: "predict"}, h("summary", {}, "What would these optics measure?"), form,
    h("div", {class: "row"}, act("Predict", run, {place: fault, kind: "quiet"})), fault, result);
}

function predicted({working_range_mm: range, largest_blur_px: blur, distances, advice}) {
  const known = distances.filter(({sigma_mm: sigma}) => sigma !== null);
  return [
    h("p", {class: "answer"}, range
      ? [h("strong", {}, `${number(range[0], 1)} to ${number(range[1], 1)} mm`), ` can be measured; largest blur ${number(blur, 1)} px.`]
      : h("strong", {}, "Nothing can be measured.")),
    known.length ? lineChart({title: "Expected error by distance", x: {label: "distance, mm"}, y: {label: "± mm", from: 0},
      lines: [{name: "expected error", points: known.map(({distance_mm: distance, sigma_mm: sigma}) => [distance, sigma])}]}) : null,
    h("div", {class: "note"}, h("ul", {}, advice.map((each) => h("li", {}, each))))];
}
