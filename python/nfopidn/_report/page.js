"use strict";
(() => {
  const report = JSON.parse(document.getElementById("report-data").textContent);
  const playTime = 16; // of a whole run [s]
  const printWidth = 680; // of a figure on A4 [px]
  const markStroke = { color: "#1d1f22", width: 1 };
  const config = {
    responsive: true,
    displaylogo: false,
    modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"],
  };
  const touched = window.matchMedia("(pointer: coarse)").matches;

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

  // The robot seen from above: body, wheels, and a line to its front.
  const outline = (x, y, theta, radius) => {
    const cos = Math.cos(theta);
    const sin = Math.sin(theta);
    const across = [];
    const up = [];
    const put = (forward, left) => {
      across.push(x + radius * (forward * cos - left * sin));
      up.push(y + radius * (forward * sin + left * cos));
    };
    const gap = () => {
      across.push(null);
      up.push(null);
    };
    for (let i = 0; i <= 40; ++i) put(Math.cos((i * Math.PI) / 20), Math.sin((i * Math.PI) / 20));
    gap();
    for (const side of [-0.95, 0.95]) {
      for (const [forward, left] of [[-0.45, -0.14], [0.45, -0.14], [0.45, 0.14], [-0.45, 0.14], [-0.45, -0.14]]) {
        put(forward, side + left);
      }
      gap();
    }
    for (const [forward, left] of [[0.95, 0], [0.35, 0.32], [0.35, -0.32], [0.95, 0]]) put(forward, left);
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
    const robotTrace = scenario.figures.path.data.length - 1;
    let playing = null;
    let waiting = false;

    const shown = [
      ["t", "t", "s"], ["x", "x", "m"], ["y", "y", "m"], ["θ", "theta", "rad"],
      ["v", "v", "m/s"], ["ω", "omega", "rad/s"],
      ["e\u2093", "e_x", "m"], ["e\u1d67", "e_y", "m"], ["e\u03b8", "e_theta", "rad"],
      ["τ left", "tau_left", "N m"], ["τ right", "tau_right", "N m"],
    ];
    const values = shown.map(([label, , unit]) => {
      const cell = document.createElement("span");
      const name = document.createElement("em");
      const value = document.createElement("b");
      name.textContent = `${label} `;
      cell.append(name, value, ` ${unit}`);
      now.append(cell);
      return value;
    });

    const show = () => {
      waiting = false;
      const k = Number(slider.value);
      const at = (name) => columns[name][k];
      shown.forEach(([, name], i) => { values[i].textContent = number(at(name)); });
      slider.setAttribute("aria-valuetext", `${at("t")} s`);
      const [x, y] = outline(at("x"), at("y"), at("theta"), scenario.robot_radius);
      Plotly.restyle(path, { x: [[at("x_ref")], x], y: [[at("y_ref")], y] }, [robotTrace - 1, robotTrace]);
      for (const place of marked) {
        const mark = { type: "line", xref: "x", yref: "paper", x0: at("t"), x1: at("t"), y0: 0, y1: 1, line: markStroke };
        Plotly.relayout(place, { shapes: [mark] });
      }
    };
    const request = () => {
      if (!waiting) {
        waiting = true;
        requestAnimationFrame(show);
      }
    };
    const stop = () => {
      playing = null;
      button.textContent = "Play";
    };
    const frame = (time) => {
      if (playing === null) return;
      playing.start ??= time;
      const k = playing.from + ((time - playing.start) / 1000 / playTime) * last;
      slider.value = Math.min(last, Math.floor(k));
      show();
      if (k >= last) stop();
      else requestAnimationFrame(frame);
    };
    slider.addEventListener("input", () => { stop(); request(); });
    button.addEventListener("click", () => {
      if (playing !== null) return stop();
      playing = { from: Number(slider.value) >= last ? 0 : Number(slider.value), start: null };
      button.textContent = "Pause";
      requestAnimationFrame(frame);
    });
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
