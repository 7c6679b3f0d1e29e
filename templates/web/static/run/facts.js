// Facts about the robot beside its picture: which way it looks, what is around it.

import { make, put } from "../elements.js";

const degrees = (angle) => `${((angle * 180) / Math.PI).toFixed(1)}°`;

const hues = [[15, "red"], [45, "orange"], [70, "yellow"], [165, "green"], [200, "turquoise"], [255, "blue"], [290, "violet"], [340, "magenta"], [361, "red"]];

/** A word for a colour of three parts from 0 to 1. */
function colour([red, green, blue]) {
  const most = Math.max(red, green, blue);
  const span = most - Math.min(red, green, blue);
  if (most < 0.08) return "off";
  const dim = most < 0.5 ? "dim " : "";
  if (span < 0.15 * most) return `${dim}white`;
  const turn = most === red ? ((green - blue) / span + 6) % 6 : most === green ? (blue - red) / span + 2 : (red - green) / span + 4;
  return dim + hues.find(([limit]) => turn * 60 < limit)[1];
}

export function robot(root) {
  const facts = new Map();

  document.addEventListener("rrp:run", ({ detail }) => {
    if (detail.phase === "none") {
      facts.clear();
      root.replaceChildren();
    }
  });
  document.addEventListener("rrp:live", ({ detail }) => {
    const seen = detail.robot;
    if (!seen) return;
    const { HeadYaw: yaw, HeadPitch: pitch } = seen.joints;
    if (yaw !== undefined) fact("Head yaw", degrees(yaw));
    if (pitch !== undefined) fact("Head pitch", degrees(pitch));
    fact("Eyes", colour(seen.eyes));
    dot(facts.get("Eyes"), seen.eyes);
    const names = Object.keys(seen.things);
    fact("Around it", names.length ? names.join(", ") : "nobody, nothing");
  });

  /** The colour itself beside its word. */
  function dot(place, parts) {
    const css = `rgb(${parts.map((part) => Math.round(part * 255)).join(" ")})`;
    place.classList.add("eye-colour");
    if (place.style.getPropertyValue("--shines") !== css) place.style.setProperty("--shines", css);
  }

  function fact(name, text) {
    if (!facts.has(name)) {
      const value = make("dd");
      root.append(make("dt", { textContent: name }), value);
      facts.set(name, value);
    }
    put(facts.get(name), text);
  }
}
