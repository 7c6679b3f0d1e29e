// What cells that hold no formula may hold: by the column, and by what stands beside them in the row.

import { key, named, pick } from "./suggest.js";

const CHOSEN = ["robot", "engine", "facememory", "language"]; // fields that take nothing but one of these

/** Suggestions for a cell of the Devices, Scene, test or Protocol sheets; null for another kind of cell. */
export function inCell(words, where, before, text) {
  const { kind } = where;
  if (kind === "setting") return pick(setting(words, where)?.choices ?? [], text, 0, true);
  if (kind === "actor") return pick(words.things, text, 0, true);
  if (kind === "gesture") return free(words.gestures ?? [], text);
  if (kind === "verb") return pick(verbs(words, where).map(([verb, values]) => ({ text: verb, help: values[0]?.text ?? "" })), text, 0, true);
  if (kind === "value") return free(values(words, where), text);
  if (kind === "amount" && where.table.kind === "scene") return free(times(words), text);
  if (kind === "fieldvalue") {
    const field = key(named(where, "fieldname"));
    return field === "run" ? after(words.values.run, before) : free(words.values?.[field] ?? [], text, CHOSEN.includes(field));
  }
  if (kind === "send" || kind === "expect") return sent(words, where, before);
  return null;
}

/** Help on what a setting's cell is for. */
export function cellHelp(words, where) {
  const found = where.kind === "setting" ? setting(words, where) : null;
  if (found) return [named(where, "device"), `${found.name}: ${found.help}`];
  if (where.kind === "setting") return untaken(words, where);
  if (where.kind === "angle") {
    const joint = words.joints?.[key(where.name)];
    return joint ? [joint.name, joint.help] : [where.name, "No joint of the robot: this column is not used."];
  }
  if (where.kind === "value") {
    const verb = named(where, "verb");
    const shown = values(words, where).map((v) => v.text).join("   or   ");
    return verb && shown ? [`${named(where, "actor")} ${verb}`, shown] : null;
  }
  return null;
}

/** What a device's cell says that the device does not take: which device of its kind would. */
function untaken(words, where) {
  const device = named(where, "device");
  const about = (name) => words.devices?.find((d) => key(d.text) === key(name))?.help ?? "";
  if (!words.takes?.[key(device)]) return null;
  const other = words.instead?.[key(device)]?.[key(where.name)]?.[0];
  const remedy = other ? `With a ${where.name}: the device “${other}”. ${about(other)}` : "Leave the cell blank.";
  return [`${device} takes no ${where.name}`, `${about(device)} ${remedy}`];
}

/** Values that may also be anything else: only a word that is being typed is completed, no number. */
function free(choices, text, whole = /^\p{L}+$/u.test(text)) {
  const found = pick(choices, text, 0, whole);
  return { ...found, sure: found.sure && whole };
}

function after(choices, before) {
  const from = before.lastIndexOf(",") + 1;
  const start = from + (before.slice(from).length - before.slice(from).trimStart().length);
  return pick(choices, before.slice(start), start, true);
}

function setting(words, where) {
  return words.takes?.[key(named(where, "device"))]?.[key(where.name)];
}

function verbs(words, where) {
  const thing = named(where, "actor");
  const acts = words.acts ?? {};
  if (!thing) return Object.values(acts).flat();
  const name = key(thing).replace(/\d+$/, "");
  return acts[Object.keys(acts).find((kind) => name.endsWith(kind)) ?? "person"];
}

/** When something may happen: also after the end of what an actuator does. */
function times(words) {
  return [...(words.scenetimes ?? []), ...(words.dones ?? []).map(({ text, help }) => ({ text: `${text} + 1`, help }))];
}

function values(words, where) {
  const verb = key(named(where, "verb"));
  return verbs(words, where).find(([name]) => key(name) === verb || key(name) === `${verb}s`)?.[1] ?? [];
}

/** What is sent into a stream, or expected of it: its fields, behind each semicolon. */
function sent(words, where, before) {
  const from = before.lastIndexOf(";") + 1;
  const start = from + (before.slice(from).length - before.slice(from).trimStart().length);
  const typed = before.slice(start);
  if (/[=<>≈"]/.test(typed)) return { items: [], from: start, sure: false };
  const stream = key(named(where, "tested").replace(/^.*!/, ""));
  const fields = (words.records?.[stream]?.fields ?? []).map((f) => ({ text: `${f.text}=`, help: f.help }));
  const others = where.kind === "expect" && !from ? words.expects : from ? [] : [{ text: "BLANK", help: "a blank" }];
  return { ...pick([...fields, ...others], typed, start, false), partial: true };
}
