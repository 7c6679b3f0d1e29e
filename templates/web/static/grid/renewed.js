// The server was started anew with another version of the program: the page loads again, when nothing is being typed.

const AGAIN = 500; // milliseconds until it is looked again whether somebody types

export function renewed(grid, listen) {
  listen.addEventListener("program", ({ detail }) => {
    const { program } = listen.dataset;
    if (program && JSON.parse(detail.data).version !== program) wait();
  });

  function wait(told = false) {
    const typing = grid.editor.isOpen || document.body.hasAttribute("data-saving") || document.querySelector("dialog[open]")
      || document.activeElement?.matches("input:not([type=checkbox]), textarea");
    if (!typing) return location.reload();
    if (!told) grid.say("The program was renewed. This page loads again when you have finished typing.");
    setTimeout(() => wait(true), AGAIN);
    return undefined;
  }
}
