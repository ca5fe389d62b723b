// Texts to the clipboard, or into a file.

async function copied(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const area = html("textarea", { readonly: true });
    area.value = text;
    document.body.append(area);
    area.select();
    const done = document.execCommand("copy");
    area.remove();
    return done;
  }
}

function saved(text, name, type) {
  const link = html("a", { download: name });
  link.href = URL.createObjectURL(new Blob([text], { type }));
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

function startCopying() {
  for (const block of document.querySelectorAll(".code")) {
    const text = () => block.querySelector("code").textContent;
    const copy = block.querySelector(".copy");
    copy.addEventListener("click", async () => {
      copy.textContent = (await copied(text())) ? "Copied" : "Not allowed: select it";
      setTimeout(() => (copy.textContent = "Copy"), 1500);
    });
    const save = block.querySelector(".save");
    if (save) save.addEventListener("click", () => saved(text(), save.dataset.name, "text/plain"));
  }
}
