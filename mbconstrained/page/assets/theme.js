// Light or dark: the setting of the system until the button is pressed, then the last choice on any page of this site.
const theme = {
  button: document.getElementById("theme"),
  system: window.matchMedia("(prefers-color-scheme: dark)"),

  get dark() {
    const { theme: chosen } = document.documentElement.dataset;
    return chosen ? chosen === "dark" : theme.system.matches;
  },

  show() {
    theme.button.textContent = theme.dark ? "Switch to light" : "Switch to dark";
    window.dispatchEvent(new Event("themechange"));
  },

  choose(name) {
    document.documentElement.dataset.theme = name;
    theme.show();
  },

  toggle() {
    theme.choose(theme.dark ? "light" : "dark");
    withStorage((storage) => storage.setItem("mbconstrained theme", document.documentElement.dataset.theme));
  },
};

// Browsers may forbid storage for local files.
function withStorage(use) {
  try {
    return use(window.localStorage);
  } catch (error) {
    return null;
  }
}

const chosenTheme = withStorage((storage) => storage.getItem("mbconstrained theme"));
if (chosenTheme === "light" || chosenTheme === "dark") document.documentElement.dataset.theme = chosenTheme;
theme.show();
theme.button.addEventListener("click", theme.toggle);
theme.system.addEventListener("change", theme.show);
