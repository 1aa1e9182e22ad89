// Elements from plain calls: h("p", {class: "muted"}, "text", child). Text is always text, never markup.

const SVG = "http://www.w3.org/2000/svg";

function fill(node, props, children) {
  for (const [name, value] of Object.entries(props ?? {})) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith("on")) node.addEventListener(name.slice(2).toLowerCase(), value);
    else if (name === "style") Object.assign(node.style, value); // never an attribute: the page allows no inline style
    else if (name === "value" || name === "checked" || name === "selected" || name === "disabled") node[name] = value;
    else node.setAttribute(name, value === true ? "" : value);
  }
  for (const child of children.flat(Infinity)) {
    if (child !== undefined && child !== null && child !== false) node.append(child);
  }
  return node;
}

export const h = (tag, props, ...children) => fill(document.createElement(tag), props, children);

export const svg = (tag, props, ...children) => fill(document.createElementNS(SVG, tag), props, children);

// An SVG picture; screen readers read its title.
export function picture(title, width, height, ...children) {
  return svg("svg", {viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": title, class: "chart"}, ...children);
}

export function replace(node, ...children) {
  node.replaceChildren(...children.flat(Infinity).filter((child) => child !== undefined && child !== null && child !== false));
  return node;
}

// A function that draws `place` again when its data changed, and only then; the focus stays on the element that had it.
export function drawOnChange(place, draw) {
  let shown;
  return (data) => {
    const now = JSON.stringify(data);
    if (now === shown) return;
    shown = now;
    const held = place.contains(document.activeElement) ? document.activeElement : null;
    replace(place, draw(data));
    if (!held || place.contains(held)) return;
    const same = (other) => other.textContent === held.textContent
      && ["href", "id", "aria-label", "name"].every((name) => other.getAttribute(name) === held.getAttribute(name));
    [...place.querySelectorAll(held.tagName)].find(same)?.focus({preventScroll: true});
  };
}
