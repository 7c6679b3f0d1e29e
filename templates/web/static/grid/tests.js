// The workbook's tests: what they came to is shown anew when it is told, and what is new about it is said. A lesson in
// their list leads to its rows, a word beside it to its help.

export function tests(grid, listen) {
  listen.addEventListener("tested", (event) => {
    if (!("orphan" in document.body.dataset)) htmx.trigger("#panels", "recheck");
    const { news } = JSON.parse(event.detail.data);
    if (news) grid.say(news);
  });
  document.addEventListener("click", (event) => {
    if (event.target.closest("[data-do=test]")) grid.server.send("test", {});
    const term = event.target.closest("#panels [data-topic]");
    const lesson = event.target.closest("#panels [data-lesson]");
    if (event.ctrlKey || event.metaKey || !(term || lesson)) return; // a link opened in a tab of its own
    event.preventDefault();
    if (term) document.dispatchEvent(new CustomEvent("rrp:help", { detail: [term.dataset.topic] }));
    else open(lesson.dataset.lesson);
  });

  /** The lesson to the top of the table, the cursor into its first row that is no comment. */
  function open(id) {
    const { table, scroll, selection } = grid;
    const heading = table.row(id);
    if (!heading) return;
    const rows = table.rows.slice(table.at(heading) + 1);
    const next = rows.findIndex((row) => /^#+\s*lesson\s/i.test(table.value(row.querySelector("td[data-v]"))));
    const mine = next < 0 ? rows : rows.slice(0, next);
    const row = mine.find((one) => !one.classList.contains("comment")) ?? heading;
    scroll.scrollIntoView({ block: "nearest" });
    selection.go(row, Math.max(table.headers.findIndex((header) => header.dataset.kind === "inputs"), 0));
    scroll.scrollTop += heading.getBoundingClientRect().top - scroll.getBoundingClientRect().top - table.grid.tHead.offsetHeight;
  }
}
