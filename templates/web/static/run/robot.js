// Facts about the robot beside its picture: which way it looks, what it says, what is around it.

import { make, put } from "./make.js";

const degrees = (angle) => `${((angle * 180) / Math.PI).toFixed(1)}°`;

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
    fact("Says", seen.saying ? `“${seen.saying}”` : "nothing");
    fact("Eyes", `#${seen.eyes.map((part) => Math.round(part * 255).toString(16).padStart(2, "0")).join("")}`);
    const names = Object.keys(seen.things);
    fact("Around it", names.length ? names.join(", ") : "nobody, nothing");
  });

  function fact(name, text) {
    if (!facts.has(name)) {
      const value = make("dd");
      root.append(make("dt", { textContent: name }), value);
      facts.set(name, value);
    }
    put(facts.get(name), text);
  }
}
