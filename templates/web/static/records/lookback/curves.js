// The plots of the whole run, with a line where one is.

import { request } from "../../api.js";
import { plotRecord } from "../../run/plots.js";

const FIRST = 6; // curves

/** Draw the plots; what is returned moves their line. */
export function curves(section, seconds, go) {
  let boxes = [];
  let t = 0;
  const show = (now) => {
    t = now;
    for (const { over, mine } of boxes) mine.style.left = `${(t / (seconds || 1)) * over.clientWidth}px`;
  };
  draw(section, seconds, go).then((found) => {
    boxes = found;
    show(t);
    new ResizeObserver(() => show(t)).observe(section);
  }).catch((error) => console.warn(error));
  return { show };
}

const shown = (section) => new Promise((done) => {
  new IntersectionObserver((entries, observer) => {
    if (!entries.at(-1).isIntersecting) return;
    observer.disconnect();
    done();
  }).observe(section);
});

async function draw(section, seconds, go) {
  const { json: series } = await request(section.dataset.series);
  const waits = section.querySelector(".quiet");
  waits.hidden = series?.length > 0;
  if (!waits.hidden) {
    waits.textContent = waits.dataset.none;
    return [];
  }
  await shown(section); // a hidden place has no width
  plotRecord(section.querySelector("[data-plots]"), series.slice(0, FIRST), [0, seconds]);
  return [...section.querySelectorAll(".u-over")].map((over) => {
    const mine = document.createElement("div");
    mine.className = "at-time";
    over.append(mine);
    over.addEventListener("click", (event) => go(((event.clientX - over.getBoundingClientRect().left) / over.clientWidth) * seconds));
    return { over, mine };
  });
}
