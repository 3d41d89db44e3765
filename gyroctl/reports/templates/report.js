"use strict";
(() => {
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((part) => (part.open = true)));
  const place = document.querySelector(".closer");
  if (!place || !("DecompressionStream" in window)) return;
  place.hidden = false;
  const text = (id) => document.getElementById(id).textContent;
  const unpacked = (packed) => {
    const bytes = Uint8Array.from(atob(packed), (letter) => letter.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip")));
  };
  const made = (kind, words, parts = {}) => Object.assign(document.createElement(kind), { textContent: words }, parts);
  const button = document.getElementById("closer");

  button.addEventListener("click", async () => {
    button.disabled = true;
    const head = JSON.parse(text("series-head"));
    const steps = new DataView(await unpacked(text("series-lines")).arrayBuffer());
    const library = await unpacked(text("library")).text();
    document.head.append(made("script", library));
    const count = head.time.length;
    const line = (k) => {
      const [low, high] = head.ranges[k];
      const values = new Array(count);
      for (let i = 0; i < count; i++) {
        const step = steps.getUint16(2 * (k * count + i), true);
        values[i] = step > head.levels ? null : low + ((high - low) * step) / head.levels;
      }
      return values;
    };

    const rows = head.panels.length + 1;
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const axis = (row) => (row ? String(row + 1) : "");
    const traces = [{ x: head.time, y: line(0), line: { color: "#7A828C", width: 1.2 }, yaxis: "y", xaxis: "x", name: "waves" }];
    head.panels.forEach(([signal], row) =>
      head.laws.forEach((law, k) => {
        const shape = signal === "cc" || signal === "cg" ? "hv" : "linear";
        traces.push({
          x: head.time, y: line(1 + row * head.laws.length + k), xaxis: "x", yaxis: "y" + axis(row + 1), name: "law " + k,
          line: { color: head.colours[k], width: 1.3, shape }, visible: head.first.includes(law), meta: k,
        });
      }),
    );
    for (const trace of traces) Object.assign(trace, { type: "scatter", mode: "lines", hoverinfo: "x+y" });
    const height = 1 / rows;
    const layout = () => {
      const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
      const look = { gridcolor: colour("--grid"), linecolor: colour("--axis"), zeroline: false, tickfont: { size: 11 } };
      const found = {
        height: 110 + 120 * rows, showlegend: false, dragmode: "zoom", margin: { l: 56, r: 14, t: 24, b: 40 },
        paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
        font: { family: "Liberation Sans, Arial, Helvetica, sans-serif", size: 12, color: colour("--ink") },
        xaxis: { ...look, anchor: "y" + axis(rows - 1), title: { text: "Time [s]" }, range: head.view },
        annotations: [["", "Wave elevation [m]"], ...head.panels].map(([, title], row) => ({
          text: title, x: 0, xref: "paper", xanchor: "left", y: 1 - row * height, yref: "paper", yanchor: "bottom", showarrow: false,
        })),
      };
      for (let row = 0; row < rows; row++) {
        const top = 1 - row * height;
        found["yaxis" + axis(row)] = { ...look, domain: [top - 0.72 * height, top], nticks: 4, anchor: "x" };
      }
      return found;
    };
    const plot = document.getElementById("drawn-closer");
    const draw = () => Plotly.newPlot(plot, traces, layout(), { responsive: true, displayModeBar: false, plotlyServerURL: "" });
    await draw();
    dark.addEventListener("change", draw);

    const choice = made("fieldset", "", { className: "choice" });
    choice.append(made("legend", "Laws"));
    head.laws.forEach((law, k) => {
      const box = made("input", "", { type: "checkbox", checked: head.first.includes(law) });
      const label = made("label", "");
      const key = made("span", "", { className: "key solid" });
      key.style.setProperty("--c", head.colours[k]);
      label.append(box, key, law);
      box.addEventListener("change", () => {
        const concerned = traces.flatMap((trace, at) => (trace.meta === k ? [at] : []));
        for (const at of concerned) traces[at].visible = box.checked;
        Plotly.restyle(plot, { visible: box.checked }, concerned);
      });
      choice.append(label);
    });
    const first = head.time[0], last = head.time[count - 1];
    const centre = (head.view[0] + head.view[1]) / 2;
    const views = made("p", "");
    for (const [words, range] of [
      ["20 s", [Math.max(first, centre - 10), Math.min(last, centre + 10)]],
      ["120 s", head.view],
      ["whole run", [first, last]],
    ]) {
      const view = made("button", words, { type: "button" });
      view.addEventListener("click", () => Plotly.relayout(plot, { "xaxis.range": [...range] }));
      views.append(view, " ");
    }
    document.getElementById("chosen").append(choice, views);
    button.parentElement.remove();
  });
})();
