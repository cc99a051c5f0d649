// Light or dark: as the system has it until the button is pressed, then as it was left, on every page of this place.
const theme = {
  button: document.getElementById("theme"),
  system: window.matchMedia("(prefers-color-scheme: dark)"),

  get dark() {
    const { theme: chosen } = document.documentElement.dataset;
    return chosen ? chosen === "dark" : theme.system.matches;
  },

  show() {
    theme.button.setAttribute("aria-pressed", theme.dark);
    window.dispatchEvent(new Event("themechange"));
  },

  choose(name) {
    document.documentElement.dataset.theme = name;
    theme.show();
  },

  toggle() {
    theme.choose(theme.dark ? "light" : "dark");
    remembered((storage) => storage.setItem("mbconstrained theme", document.documentElement.dataset.theme));
  },
};

// Browsers may forbid pages from a disk to remember anything.
function remembered(use) {
  try {
    return use(window.localStorage);
  } catch (error) {
    return null;
  }
}

const chosenTheme = remembered((storage) => storage.getItem("mbconstrained theme"));
if (chosenTheme === "light" || chosenTheme === "dark") document.documentElement.dataset.theme = chosenTheme;
theme.show();
theme.button.addEventListener("click", theme.toggle);
theme.system.addEventListener("change", theme.show);
