// Small helpers to make elements; texts of people and workbooks only ever become text.

const SVG = "http://www.w3.org/2000/svg"; // the namespace

/** An element with its properties, or with nothing but a text. */
export function make(name, properties = {}, ...children) {
  const element = document.createElement(name);
  if (typeof properties === "string") element.textContent = properties;
  else Object.assign(element, properties);
  element.append(...children);
  return element;
}

export function button(text, action, className = "button") {
  const element = make("button", { type: "button", className, textContent: text });
  element.addEventListener("click", action);
  return element;
}

/** Our own line icons, from the sheet of icons that the page uses already. */
export function icon(name) {
  const source = document.querySelector("use").getAttribute("href").replace(/#.*/, "");
  const svg = element("svg", { class: "icon", "aria-hidden": "true" });
  svg.append(element("use", { href: `${source}#i-${name}` }));
  return svg;
}

/** Change a text only when it is another one: what stays the same costs nothing. */
export function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** An element of a drawing with its attributes; numbers are rounded to tenths. */
export function element(tag, attributes = {}) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) {
    made.setAttribute(name, typeof value === "number" ? Math.round(value * 10) / 10 : value);
  }
  return made;
}
