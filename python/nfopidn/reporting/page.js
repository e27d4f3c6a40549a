"use strict";
(() => {
  const report = JSON.parse(document.getElementById("report-data").textContent);
  const playTime = 16; // of a whole run [s]
  const frameTime = 40; // [ms]
  const printWidth = 680; // of a figure on A4 [px]
  const markStroke = { color: "#1d1f22", width: 1 };
  // Without a mouse a drag scrolls the page and the figures have no tools.
  const touched = window.matchMedia("(hover: none)").matches;
  const config = {
    responsive: true,
    displaylogo: false,
    displayModeBar: touched ? false : "hover",
    modeBarButtons: [["toImage", "zoom2d", "pan2d", "resetScale2d"]],
  };

  // "@name" stands for a column of the run.
  const resolved = (trace, columns) => {
    const found = { ...trace };
    for (const key of ["x", "y", "text"]) {
      if (typeof trace[key] === "string" && trace[key][0] === "@") {
        found[key] = columns[trace[key].slice(1)];
      }
    }
    return found;
  };

  const draw = (id, figure, columns) => {
    const place = document.getElementById(id);
    const data = figure.data.map((trace) => resolved(trace, columns));
    const layout = { ...figure.layout, height: figure.height, dragmode: touched ? false : "zoom" };
    return Plotly.newPlot(place, data, layout, config);
  };

  const number = (value) =>
    value === null ? "–" : Number(value.toPrecision(4)).toString().replace("-", "\u2212");

  // The robot seen from above: its body, and its wheels with a mark that points ahead.
  const circle = Array.from({ length: 41 }, (_, i) => [Math.cos((i * Math.PI) / 20), Math.sin((i * Math.PI) / 20)]);
  const wheel = (side) => [[-0.45, -0.14], [0.45, -0.14], [0.45, 0.14], [-0.45, 0.14], [-0.45, -0.14]]
    .map(([forward, left]) => [forward, left + side]);
  const body = [circle];
  const parts = [wheel(-0.95), wheel(0.95), [[0.88, 0], [-0.2, 0.34], [-0.2, -0.34], [0.88, 0]]];

  // Rings of points (forward, left) in radii, as x and y of one trace.
  const placed = (rings, x, y, theta, radius) => {
    const cos = radius * Math.cos(theta);
    const sin = radius * Math.sin(theta);
    const across = [];
    const up = [];
    for (const ring of rings) {
      for (const [forward, left] of ring) {
        across.push(x + forward * cos - left * sin);
        up.push(y + forward * sin + left * cos);
      }
      across.push(null);
      up.push(null);
    }
    return [across, up];
  };

  const player = (scenario, index) => {
    const find = (name) => document.getElementById(`${name}-${index}`);
    const [slider, button, now, path] = ["slider", "play", "now", "path"].map(find);
    const columns = scenario.columns;
    const last = columns.t.length - 1;
    const marked = Object.entries(scenario.figures)
      .filter(([, figure]) => figure.marks_time)
      .map(([name]) => find(name));
    const traces = scenario.figures.path.data.length;
    const moved = [traces - 3, traces - 2, traces - 1]; // reference, body, parts
    let playing = null; // timer

    const shown = [
      ["t", "t", "s"], ["x", "x", "m"], ["y", "y", "m"], ["θ", "theta", "rad"],
      ["v", "v", "m/s"], ["ω", "omega", "rad/s"],
      ["e_x", "e_x", "m"], ["e_y", "e_y", "m"], ["e_θ", "e_theta", "rad"],
      ["τ left", "tau_left", "N m"], ["τ right", "tau_right", "N m"],
    ];
    const values = shown.map(([label, , unit]) => {
      const cell = document.createElement("span");
      const name = document.createElement("em");
      const value = document.createElement("b");
      const [symbol, index] = label.split("_");
      name.textContent = symbol;
      if (index) name.append(Object.assign(document.createElement("sub"), { textContent: index }));
      cell.append(name, " ", value, ` ${unit}`);
      now.append(cell);
      return value;
    });

    const show = () => {
      const k = Number(slider.value);
      const at = (name) => columns[name][k];
      shown.forEach(([, name], i) => { values[i].textContent = number(at(name)); });
      slider.setAttribute("aria-valuetext", `${at("t")} s`);
      const pose = [at("x"), at("y"), at("theta"), scenario.robot_radius];
      const lines = [[[at("x_ref")], [at("y_ref")]], placed(body, ...pose), placed(parts, ...pose)];
      Plotly.restyle(path, { x: lines.map(([x]) => x), y: lines.map(([, y]) => y) }, moved);
      for (const place of marked) {
        const across = { type: "line", xref: "x", x0: at("t"), x1: at("t"), line: markStroke };
        Plotly.relayout(place, { shapes: [{ ...across, yref: "paper", y0: 0, y1: 1 }] });
      }
    };
    const stop = () => {
      clearInterval(playing);
      playing = null;
      button.textContent = "Play";
    };
    const play = () => {
      const from = Number(slider.value) >= last ? 0 : Number(slider.value);
      const began = performance.now();
      playing = setInterval(() => {
        const k = from + ((performance.now() - began) / 1000 / playTime) * last;
        slider.value = Math.min(last, Math.floor(k));
        show();
        if (k >= last) stop();
      }, frameTime);
      button.textContent = "Pause";
    };
    slider.addEventListener("input", () => { stop(); show(); });
    button.addEventListener("click", () => (playing === null ? play() : stop()));
    // The sample that is nearest to a time [s].
    const seek = (time) => {
      let k = 0;
      while (k < last && columns.t[k + 1] <= time) ++k;
      if (k < last && columns.t[k + 1] - time < time - columns.t[k]) ++k;
      slider.value = k;
      show();
    };
    slider.max = last;
    return seek;
  };

  // report.html#t=42 opens at 42 s.
  const timeAsked = () => {
    const asked = /^#t=([0-9.]+)$/.exec(window.location.hash);
    return asked ? Number(asked[1]) : null;
  };

  const start = async () => {
    for (const [name, figure] of Object.entries(report.figures)) await draw(name, figure, {});
    const seeks = [];
    for (const [i, scenario] of report.scenarios.entries()) {
      const index = i + 1;
      for (const [name, figure] of Object.entries(scenario.figures)) {
        await draw(`${name}-${index}`, figure, scenario.columns);
      }
      if (scenario.columns.t.length > 0) seeks.push(player(scenario, index));
    }
    const seekAll = () => seeks.forEach((seek) => seek(timeAsked() ?? 0));
    seekAll();
    window.addEventListener("hashchange", () => { if (timeAsked() !== null) seekAll(); });
    document.body.dataset.drawn = "yes";
  };

  const plots = () => document.querySelectorAll(".js-plotly-plot");
  window.addEventListener("beforeprint", () => {
    plots().forEach((place) => Plotly.relayout(place, { width: printWidth }));
  });
  window.addEventListener("afterprint", () => {
    plots().forEach((place) => Plotly.relayout(place, { autosize: true, width: null }));
  });
  start();
})();
