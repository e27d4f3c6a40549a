"use strict";
(() => {
  const playTime = 16; // of a whole run [s]
  const frameTime = 40; // [ms]
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
      across.push(NaN);
      up.push(NaN);
    }
    return [across, up];
  };

  const player = (scenario, index, drawn) => {
    const find = (name) => document.getElementById(`${name}-${index}`);
    const [slider, button, now] = ["slider", "play", "now"].map(find);
    const columns = scenario.columns;
    const last = columns.t.length - 1;
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
      shown.forEach(([, name], i) => { values[i].textContent = Figures.number(at(name)); });
      slider.setAttribute("aria-valuetext", `${at("t")} s`);
      const pose = [at("x"), at("y"), at("theta"), scenario.robot_radius];
      const lines = [[[at("x_ref")], [at("y_ref")]], placed(body, ...pose), placed(parts, ...pose)];
      drawn.path.moving.forEach((source, i) => {
        const [x, y] = lines[i];
        source.data = { x, y };
      });
      Object.values(drawn).forEach(({ markTime }) => markTime(at("t")));
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
    await Figures.load("bokeh");
    const report = JSON.parse(await Figures.unpack("report-data"));
    const overview = {};
    for (const [name, figure] of Object.entries(report.figures)) {
      overview[name] = await Figures.draw(name, figure, {});
    }
    const drawn = [];
    const seeks = [];
    for (const [i, scenario] of report.scenarios.entries()) {
      const figures = {};
      for (const [name, figure] of Object.entries(scenario.figures)) {
        figures[name] = await Figures.draw(`${name}-${i + 1}`, figure, scenario.columns);
      }
      drawn.push(figures);
      if (scenario.columns.t.length > 0) seeks.push(player(scenario, i + 1, figures));
    }
    const seekAll = () => seeks.forEach((seek) => seek(timeAsked() ?? 0));
    seekAll();
    window.addEventListener("hashchange", () => { if (timeAsked() !== null) seekAll(); });
    document.body.dataset.drawn = "yes";
    return { overview, drawn };
  };

  window.report = start(); // for whoever looks at the page's figures from the console
  window.report.catch((error) => {
    const note = document.getElementById("no-figures");
    note.hidden = false;
    console.error(error);
  });
})();
