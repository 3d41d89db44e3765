"use strict";
(() => {
  const read = (id) => JSON.parse(document.getElementById(id).textContent);
  const templates = { light: read("template-light"), dark: read("template-dark") };
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const template = () => templates[dark.matches ? "dark" : "light"];
  const config = {
    responsive: true,
    displaylogo: false,
    showSendToCloud: false,
    plotlyServerURL: "",
    modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"],
    toImageButtonOptions: { format: "png", scale: 2 },
  };
  const places = [...document.querySelectorAll(".figure")];
  for (const place of places) {
    const figure = read("data-" + place.dataset.figure);
    const shared = figure.layout.meta?.time;
    if (shared) for (const trace of figure.data) trace.x = shared;
    Plotly.newPlot(place, figure.data, { ...figure.layout, template: template() }, config);
  }
  dark.addEventListener("change", () => places.forEach((place) => Plotly.relayout(place, { template: template() })));
})();
