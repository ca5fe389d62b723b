// Colours as the system has them, light or dark.

const THEMES = ["", "light", "dark"];

function startTheme() {
  const button = document.getElementById("theme");
  const names = { "": "Auto", light: "Light", dark: "Dark" };
  let theme = "";
  const show = () => {
    if (theme) document.documentElement.dataset.theme = theme;
    else delete document.documentElement.dataset.theme;
    button.textContent = names[theme];
    const said = theme || "as the system has them";
    button.setAttribute("aria-label", `Colours: ${said}`);
    button.title = `Colours: ${said}`;
    document.dispatchEvent(new Event("themed"));
  };
  button.addEventListener("click", () => {
    theme = THEMES[(THEMES.indexOf(theme) + 1) % THEMES.length];
    show();
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
  show();
}
