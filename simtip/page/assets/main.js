// Everything of the page that answers; when it does, the page is ready.

async function start() {
  startTheme();
  startCopying();
  startViewers();
  document.addEventListener("scroll", () => tip.hide(), { passive: true });
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
