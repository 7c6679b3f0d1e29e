// The workbook's tests: what they came to is shown anew when it is told, and what is new about it is said.

export function tests(grid, listen) {
  listen.addEventListener("tested", (event) => {
    if (!("orphan" in document.body.dataset)) htmx.trigger("#panels", "recheck");
    const { news } = JSON.parse(event.detail.data);
    if (news) grid.say(news);
  });
  document.addEventListener("click", (event) => {
    if (event.target.closest("[data-do=test]")) grid.server.send("test", {});
  });
}
