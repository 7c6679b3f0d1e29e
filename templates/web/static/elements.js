// Small helpers to make elements; texts of people and workbooks only ever become text.

export function make(name, properties = {}, ...children) {
  const element = Object.assign(document.createElement(name), properties);
  element.append(...children);
  return element;
}

/** Our own line icons, from the sheet of icons that the page uses already. */
export function icon(name) {
  const source = document.querySelector("use").getAttribute("href").replace(/#.*/, "");
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const use = document.createElementNS("http://www.w3.org/2000/svg", "use");
  use.setAttribute("href", `${source}#i-${name}`);
  svg.append(use);
  return svg;
}

/** Change a text only when it is another one: what stays the same costs nothing. */
export function put(element, text) {
  if (element.textContent !== text) element.textContent = text;
}
