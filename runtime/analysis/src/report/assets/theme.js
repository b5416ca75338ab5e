/* Theme: automatic, light, dark. Paper is white and narrow; what is folded is shown there. `draw` draws what has colours of its
   own, `resize` what has a width. A file opened from disk may have no storage. */
function steerTheme(draw, resize) {
  const theme = document.getElementById("theme"), root = document.documentElement, themes = ["automatic", "light", "dark"];
  const remembered = () => { try { return localStorage.getItem("bipedc-theme"); } catch { return null; } };
  function paint(name) {
    if (name === "automatic") delete root.dataset.theme; else root.dataset.theme = name;
    theme.textContent = `Theme: ${name}`;
    draw();
  }
  let now = themes.includes(remembered()) ? remembered() : "automatic";
  theme.hidden = false;
  theme.addEventListener("click", () => {
    now = themes[(themes.indexOf(now) + 1) % 3];
    try { localStorage.setItem("bipedc-theme", now); } catch { /* not remembered then */ }
    paint(now);
  });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());

  let opened = [];
  addEventListener("beforeprint", () => {
    opened = [...document.querySelectorAll("details:not([open])")];
    opened.forEach((d) => { d.open = true; });
    root.classList.add("printing");
    paint("light");
  });
  addEventListener("afterprint", () => {
    opened.forEach((d) => { d.open = false; });
    root.classList.remove("printing");
    paint(now);
  });

  let timer = 0, width = innerWidth;
  addEventListener("resize", () => {
    if (innerWidth === width) return;
    width = innerWidth;
    clearTimeout(timer);
    timer = setTimeout(resize, 100);
  });
  paint(now);
}
