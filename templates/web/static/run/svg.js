// Elements of pictures.

const SVG = "http://www.w3.org/2000/svg";

/** An element with its attributes; numbers are rounded to tenths. */
export function element(tag, attributes = {}) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) {
    made.setAttribute(name, typeof value === "number" ? Math.round(value * 10) / 10 : value);
  }
  return made;
}
