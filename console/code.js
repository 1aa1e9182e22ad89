// The same request for a shell, Python and Rust, to copy.

import {h} from "./dom.js";
import {act, toast} from "./parts.js";

const shell = (text) => `'${text.replaceAll("'", "'\\''")}'`;
const quoted = (text) => JSON.stringify(text); // Python and Rust read it the same
const python = (value) => typeof value === "boolean" ? (value ? "True" : "False")
  : typeof value === "string" ? quoted(value) : String(value);

function curl({url, file, type, hasKey}) {
  const lines = [`curl --data-binary ${shell(`@${file}`)} -H 'Content-Type: ${type}'`];
  if (hasKey) lines.push(`-H "Authorization: Bearer $LANDMARKD_KEY"`);
  return [...lines, shell(url)].join(" \\\n    ");
}

const words = (members) => Object.entries(members).map(([name, value]) => `${name}=${python(value)}`);

function pythonClient({service, database, target, alias, file, query, hasKey}) {
  const {dx_m, dy_m = 0, dyaw_deg, ...named} = query;
  const hasMoved = dx_m !== undefined;
  const track = [quoted(database), ...alias ? words({alias}) : []].join(", ");
  const asks = target === "recognitions" ? `client.recognise(${quoted(database)}, ` : `client.track(${track}).frame(`;
  const sent = [quoted(file), ...words(named), ...hasMoved ? [`odometry=Odometry(${words({dx_m, dy_m, dyaw_deg}).join(", ")})`] : []];
  return [
    ...(hasKey ? ["import os", ""] : []),
    `from landmarkd import Client${hasMoved ? ", Odometry" : ""}`,
    "",
    `client = Client(${quoted(service)}${hasKey ? `, key=os.environ["LANDMARKD_KEY"]` : ""})`,
    `answer = ${asks}${sent.join(", ")})`,
    "print(answer)",
  ].join("\n");
}

function rust({url, file, type, hasKey}) {
  return [
    `// Cargo.toml: reqwest = { version = "0.12", features = ["blocking", "json"] }, serde_json = "1"`,
    "fn main() -> Result<(), Box<dyn std::error::Error>> {",
    "    let answer: serde_json::Value = reqwest::blocking::Client::new()",
    `        .post(${quoted(url)})`,
    `        .header("Content-Type", ${quoted(type)})`,
    ...(hasKey ? [`        .bearer_auth(std::env::var("LANDMARKD_KEY")?)`] : []),
    `        .body(std::fs::read(${quoted(file)})?)`,
    "        .send()?",
    "        .error_for_status()?",
    "        .json()?;",
    `    println!("{}", answer["decision"]);`,
    "    Ok(())",
    "}",
  ].join("\n");
}

// `target` is what is asked of the database: its recognitions, or the frames of a track of that `alias`. `query` holds the query
// parameters by name.
export function requests({database, target, alias, query, file, type, hasKey}) {
  const service = new URL(".", location.href).href.replace(/\/$/, "");
  const parameters = new URLSearchParams(query).toString();
  const url = `${service}/v1/databases/${database}/${target}${parameters && `?${parameters}`}`;
  const asked = {service, database, target, alias, query, url, file: file.replace(/\p{Cc}/gu, ""), type, hasKey};
  const forms = [["curl", curl(asked)], ["Python", pythonClient(asked)], ["Rust", rust(asked)]];
  return tabs("The same request", forms.map(([name, text]) => [name, h("div", {class: "copied"},
    h("pre", {tabindex: "0", "aria-label": `The request for ${name}`}, h("code", {}, text)),
    act("Copy", async () => {
      await navigator.clipboard.writeText(text);
      toast(`Copied for ${name}`);
    }, {kind: "quiet small", "aria-label": `Copy the request for ${name}`}))]));
}

// Panels of which one is shown; the arrow keys go from tab to tab.
function tabs(label, panels) {
  const id = (name, what) => `${what}-${name.toLowerCase()}`;
  const buttons = panels.map(([name]) => h("button", {type: "button", role: "tab", id: id(name, "tab"), "aria-controls": id(name, "panel"),
    class: "quiet small", onClick: () => choose(name)}, name));
  const shown = panels.map(([name, content]) => h("div", {role: "tabpanel", id: id(name, "panel"), "aria-labelledby": id(name, "tab")},
    content));
  function choose(chosen) {
    panels.forEach(([name], place) => {
      buttons[place].setAttribute("aria-selected", name === chosen);
      buttons[place].tabIndex = name === chosen ? 0 : -1;
      shown[place].hidden = name !== chosen;
    });
  }
  const list = h("div", {role: "tablist", "aria-label": label, class: "row tabs"}, buttons);
  list.addEventListener("keydown", (event) => {
    const step = {ArrowRight: 1, ArrowLeft: -1}[event.key];
    if (!step) return;
    const place = (buttons.indexOf(document.activeElement) + step + buttons.length) % buttons.length;
    choose(panels[place][0]);
    buttons[place].focus();
  });
  choose(panels[0][0]);
  return h("div", {}, list, shown);
}
