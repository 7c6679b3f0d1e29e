// The tabs below the sheet: add, rename, duplicate, move, delete; and what others do to them.

import { refusal, request } from "../api.js";
import { items, press } from "../commands.js";
import { button, make } from "../elements.js";
import { listed, t, tn } from "../texts.js";
import { open } from "./dialog.js";
import { menuOf, popup } from "./menus.js";
import { lost } from "./people.js";

const LATER = "told-later"; // what the next page says first

export function sheetTabs(grid, listen) {
  const { server } = grid;
  const tabs = { rename, remove, send };
  let menu = null;
  const strip = () => document.getElementById("tabs");
  const tabOf = (name) => [...strip().querySelectorAll("a[data-sheet]")].find((a) => a.dataset.sheet === name);
  const address = (name) => `${server.url}/sheet/${encodeURIComponent(name)}`;

  const said = sessionStorage.getItem(LATER);
  sessionStorage.removeItem(LATER);
  if (said) grid.say(said);
  reveal(tabOf(server.sheet));

  document.addEventListener("click", (event) => {
    const pressed = event.target.closest("#tabs [data-tab]");
    if (pressed?.dataset.tab === "add") popup(document.getElementById("kinds"), pressed, pressed);
    if (pressed?.dataset.tab === "menu") show(tabOf(server.sheet), pressed);
    const kind = event.target.closest("#kinds [data-kind]");
    if (kind) add(kind.dataset);
    const wanted = event.target.closest("[data-add-sheet]")?.dataset.addSheet;
    if (wanted) add(strip().querySelector(`#kinds [data-kind="${wanted}"]`).dataset);
    if (event.target.closest("#tabs a[aria-current]")) event.preventDefault(); // one is there already
  });
  document.addEventListener("dblclick", (event) => {
    const tab = event.target.closest("#tabs a[aria-current]");
    if (tab && can()) rename(tab.dataset.sheet);
  });
  document.addEventListener("contextmenu", (event) => {
    const tab = event.target.closest("#tabs a[data-sheet]");
    if (!tab || !can()) return;
    event.preventDefault();
    show(tab, tab);
  });
  document.addEventListener("keydown", (event) => {
    const tab = event.target.closest?.("#tabs a[data-sheet]");
    if (!tab || !can()) return;
    press("tab", event, { sheet: tab.dataset.sheet, tabs });
  });
  listen.addEventListener("sheets", (event) => changed(JSON.parse(event.detail.data), false));
  document.addEventListener("rrp:sheets", ({ detail }) => changed(detail, true));

  function can() {
    return Boolean(strip().querySelector("[data-tab=add]"));
  }

  function show(tab, at) {
    const { sheet, kind } = tab.dataset;
    menu?.remove();
    menu = menuOf(t("Sheet {name}", { name: sheet }), items("tab", { sheet, kind, tabs }));
    document.querySelector("main").append(menu);
    popup(menu, at, at);
  }

  async function send(action, body, dialog) {
    const answer = await server.send(`sheets/${action}`, body);
    if (answer.sheets) {
      dialog?.close();
      const more = (answer.rows ?? []).slice(1).map((row) => row.sheet).filter((name) => name);
      changed({ ...answer.sheets, also: [...new Set(more)] }, true);
    } else if (dialog) {
      dialog.querySelector("[role=alert]").textContent = answer.message;
      dialog.querySelector("input")?.focus();
    }
    return answer;
  }

  function asking(title, fields, does, ask) {
    const form = make("form");
    const inputs = fields.map(([label, value, help]) => {
      const line = make("label", `${label} `);
      line.className = "field";
      const input = make("input");
      input.value = value;
      input.autocomplete = "off";
      line.append(input);
      form.append(line);
      if (help) form.append(Object.assign(make("p", help), { className: "quiet" }));
      return input;
    });
    const wrong = make("p");
    wrong.className = "is-wrong";
    wrong.setAttribute("role", "alert");
    const go = make("button", does);
    go.className = "button first";
    form.append(wrong, go);
    const dialog = open(title, [form]);
    form.append(button(t("Cancel"), () => dialog.close()));
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      ask(dialog, ...inputs.map((input) => input.value));
    });
    inputs[0].select();
    inputs[0].focus();
  }

  function add({ kind, name }) {
    if (!["behaviour", "test", "table"].includes(kind)) return send("add", { kind, title: name });
    const fields = [[t("Name"), name]];
    if (kind === "table") fields.push([t("Columns"), t("Name, Value"), t("Separated by commas. A formula takes them as Table[Name].")]);
    const title = { behaviour: t("Add a behaviour"), test: t("Add a test"), table: t("Add a table") }[kind];
    return asking(title, fields, t("Add"), (dialog, typed, columns = "") => send("add", { kind, title: typed.trim() || name, columns }, dialog));
  }

  function rename(sheet) {
    asking(t("Rename “{name}”", { name: sheet }), [[t("Name"), sheet, t("Everything that names this sheet is updated too: tests, formulas, the Protocol.")]], t("Rename"),
      (dialog, title) => (title === sheet ? dialog.close() : send("rename", { of: sheet, title }, dialog)));
  }

  async function remove(sheet) {
    const { ok, status, json } = await request(`${server.url}/sheets/about/${encodeURIComponent(sheet)}`);
    const about = ok ? json : { message: status ? t("This sheet no longer exists.") : refusal(status) };
    if (about.message) return grid.say(about.message, "error");
    const has = about.rows === null ? t("Everything in it is deleted too. Press Ctrl+Z to undo.")
      : about.rows ? tn("It has {n} row. Press Ctrl+Z to undo.", "It has {n} rows. Press Ctrl+Z to undo.", { n: about.rows })
        : t("It has no rows. Press Ctrl+Z to undo.");
    const parts = [make("p", has)];
    if (about.naming.length) {
      const list = make("ul");
      list.className = "naming";
      list.append(...about.naming.map((text) => make("li", text)));
      if (about.more) list.append(make("li", t("… and {n} more", { n: about.more })));
      parts.push(make("p", t("These cells use it. They will not work when it is deleted:")), list);
    }
    const wrong = make("p");
    wrong.className = "is-wrong";
    wrong.setAttribute("role", "alert");
    const dialog = open(t("Delete “{name}”?", { name: sheet }), [...parts, wrong]);
    dialog.append(button(t("Delete"), () => send("delete", { of: sheet }, dialog)), button(t("Cancel"), () => dialog.close()));
    return dialog.querySelector("button")?.focus();
  }

  /** A sheet came, went, has another name or place; `mine`: by what was done on this page. */
  async function changed(told, mine) {
    const here = server.sheet;
    const words = worded(told, mine);
    if (told.what === "renamed" && told.was === here) follow(told.name, told.was);
    if (told.what === "added" && mine && !told.undone) return leave(told.name, words);
    if (told.what === "added" && told.name === here) return leave(here, words); // it is back
    if (told.what === "deleted" && told.name === here) {
      const next = [...strip().querySelectorAll("a[data-sheet]")].map((a) => a.dataset.sheet).filter((name) => name !== here);
      if (mine) return leave(next[0] ?? "", words);
      orphaned(words, next[0]);
      return next[0] && refresh(next[0]);
    } else grid.say(words);
    return refresh();
  }

  function worded({ what, name, was, by, also = [], undone = false }, mine) {
    const others = also.filter((sheet) => sheet !== name);
    const runs = what === "added" && others.length && !undone;
    const places = { by, name, was };
    if (!mine) {
      return {
        added: t("{by} has added “{name}”.", places), deleted: t("{by} has deleted “{name}”.", places),
        renamed: t("{by} has renamed “{was}” to “{name}”.", places), moved: t("{by} has moved “{name}”.", places),
      }[what];
    }
    const does = {
      added: undone ? t("“{name}” is restored.", places) : t("“{name}” is added.", places), deleted: t("“{name}” is deleted.", places),
      renamed: t("“{was}” is now called “{name}”.", places), moved: t("“{name}” is moved.", places),
    }[what];
    const follows = runs ? t("This sheet is now in the field Run of {sheets}, so it runs too.", { sheets: listed(others) })
      : others.length ? tn("{sheets} was updated too.", "{sheets} were updated too.", { n: others.length, sheets: listed(others, " and ") }) : "";
    return [does, follows, undone ? "" : t("Press Ctrl+Z to undo.")].filter(Boolean).join(" ");
  }

  async function leave(name, words) {
    sessionStorage.setItem(LATER, words);
    await server.chain;
    location.assign(name ? address(name) : server.url);
  }

  /** The sheet of this page has another name: the page goes on as it is. */
  function follow(name, was) {
    server.sheet = name;
    grid.table.grid.dataset.sheet = name;
    grid.table.grid.setAttribute("aria-label", name);
    document.querySelector("section.sheet")?.setAttribute("aria-label", t("Sheet {name}", { name }));
    if (document.title.startsWith(was)) document.title = name + document.title.slice(was.length);
    grid.here = ""; // the others see the cursor on the sheet of the new name
    grid.stand();
    history.replaceState(null, "", location.pathname.includes("/sheet/") ? address(name) : location.href);
  }

  /** The sheet of this page is gone: what is being typed is shown, so that it can be taken along. */
  function orphaned(words, next) {
    document.body.dataset.orphan = "";
    grid.table.grid.ariaReadOnly = "true";
    const typed = grid.editor.isOpen ? grid.editor.field.value : "";
    if (grid.editor.isOpen) grid.editor.close(false, null);
    if (typed) lost(grid, words, [{ text: typed }]);
    const line = document.getElementById("notice");
    line.textContent = [words, t("This page still shows its last contents."), ""].join(" ");
    if (next) {
      const link = make("a", t("Go to {place}", { place: next }));
      link.href = address(next);
      line.append(link);
    }
  }

  async function refresh(sheet = server.sheet) {
    const url = strip().dataset.url.replace(/\/tabs\/[^?]*/, `/tabs/${encodeURIComponent(sheet)}`);
    const { ok, text } = await request(url);
    if (!ok) return;
    const holder = document.createElement("template");
    holder.innerHTML = text; // made by our own server, all texts escaped
    const fresh = holder.content.querySelector("#tabs");
    if ("orphan" in document.body.dataset) { // none of them is shown
      fresh.querySelector("[aria-current]")?.removeAttribute("aria-current");
      fresh.querySelector("[data-tab=menu]")?.remove();
    }
    strip().replaceWith(fresh);
  }
}

/** Bring a tab into sight within its row of tabs: on a narrow screen the row is below the fold, and the page must not jump there. */
function reveal(tab) {
  if (!tab) return;
  const row = tab.parentElement;
  const [mine, frame] = [tab.getBoundingClientRect(), row.getBoundingClientRect()];
  if (mine.left < frame.left || mine.right > frame.right) row.scrollLeft += mine.left - frame.left - 16;
}
