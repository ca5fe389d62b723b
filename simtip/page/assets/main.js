// Everything of the page that answers; when it does, the page is ready.

async function start() {
  startTheme();
  startCopying();
  startViewers();
  // Not on every scroll: going to a cell by a key may scroll, too.
  for (const moved of ["wheel", "touchmove"])
    document.addEventListener(moved, () => tip.hide(), { passive: true });
  document.addEventListener("pointerdown", (event) => {
    if (!event.target.closest(".chart")) tip.hide();
  });
  try {
    await startExplorer();
  } catch (error) {
    for (const host of document.querySelectorAll(".explorer"))
      host.replaceChildren(html("p", { class: "said wrong" }, `Cannot be shown: ${error.message}`));
    throw error;
  }
  document.documentElement.dataset.ready = "yes";
}

start();
