"use strict";
// Draws the figures that nfopidn.reporting.strokes describes, with BokehJS. Colours are names of
// variables of the style sheet, so that a figure follows the theme.
const Figures = (() => {
  const textSize = "12px";
  const letter = 6.2; // width of one in a legend [px]
  const glyphRoom = 34; // of a name's mark, and between names [px]
  const touched = window.matchMedia("(hover: none)").matches;

  // The text of an element that holds it packed. Browsers unpack gzip since 2023 at the latest.
  const unpack = async (id) => {
    const packed = atob(document.getElementById(id).textContent);
    const bytes = Uint8Array.from(packed, (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(stream).text();
  };

  const load = async (id) => {
    const script = document.createElement("script");
    script.textContent = await unpack(id);
    document.head.append(script);
    Bokeh.logger.set_level("warn");
  };

  const number = (value) =>
    value === null || !Number.isFinite(value)
      ? "–"
      : Number(value.toPrecision(4)).toString().replace("-", "\u2212");

  // --- colours ---------------------------------------------------------------------------------

  const painted = []; // [model, {property: variable}]
  const variable = (name) =>
    getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
  const values = (names) =>
    Object.fromEntries(Object.entries(names).map(([key, name]) => [key, variable(name)]));
  const make = (kind, settings, colours = {}) => {
    const model = new Bokeh.Models[kind]({ ...settings, ...values(colours) });
    if (Object.keys(colours).length > 0) painted.push([model, colours]);
    return model;
  };
  const repaint = () => painted.forEach(([model, colours]) => model.setv(values(colours)));
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", repaint);

  // Gaps are null in the page's data.
  const columnSource = (columns) =>
    make("ColumnDataSource", {
      data: Object.fromEntries(Object.entries(columns).map(([name, list]) => [name, list.map((value) => value ?? NaN)])),
    });

  // --- axes ------------------------------------------------------------------------------------

  const ticker = (axis) => {
    if (axis.ticks) return make("FixedTicker", { ticks: axis.ticks });
    if (axis.log) return make("LogTicker", { mantissas: [1, 2, 5] });
    return make("BasicTicker", { desired_num_ticks: 6 });
  };

  const addAxis = (plot, axis, place, labelled) => {
    const dimension = place === "left" ? 1 : 0;
    const marks = ticker(axis);
    const settings = {
      ticker: marks,
      formatter: make("BasicTickFormatter", { use_scientific: false }),
      axis_label: labelled ? axis.title : null,
      axis_label_text_font_size: textSize,
      axis_label_text_font_style: "normal",
      major_label_text_font_size: "11px",
      minor_tick_line_color: null,
      major_tick_in: 0,
      visible: labelled,
    };
    if (axis.labels) {
      settings.major_label_overrides = new Map(axis.ticks.map((tick, i) => [tick, axis.labels[i]]));
    }
    plot.add_layout(
      make(axis.log ? "LogAxis" : "LinearAxis", settings, {
        axis_label_text_color: "ink",
        major_label_text_color: "ink",
        axis_line_color: "soft",
        major_tick_line_color: "soft",
      }),
      place,
    );
    plot.add_layout(make("Grid", { dimension, ticker: marks }, { grid_line_color: "rule" }));
  };

  const range = (axis) => {
    if (!axis.range) return make("DataRange1d", {});
    const [start, end] = axis.range;
    return make("Range1d", { start, end, reset_start: start, reset_end: end });
  };

  // One metre is as long upward as it is across; the range that has room to spare grows.
  const equalise = (plot, across, up) => {
    const fit = () => {
      const [width, height] = [plot.inner_width, plot.inner_height];
      if (!(width > 0) || !(height > 0)) return;
      const scale = Math.max((across[1] - across[0]) / width, (up[1] - up[0]) / height);
      for (const [model, [low, high], pixels] of [[plot.x_range, across, width], [plot.y_range, up, height]]) {
        const half = 0.5 * scale * pixels;
        const [start, end] = [0.5 * (low + high) - half, 0.5 * (low + high) + half];
        model.setv({ start, end, reset_start: start, reset_end: end });
      }
    };
    plot.properties.inner_width.change.connect(fit);
    plot.properties.inner_height.change.connect(fit);
  };

  // --- what is shown at a point ------------------------------------------------------------------

  // Rows are [label, column, unit].
  const tip = (rows) => (source, { index, indices }) => {
    const k = index ?? indices[0];
    const table = document.createElement("table");
    table.style.cssText = "border-spacing: 6px 0; font-variant-numeric: tabular-nums";
    for (const [label, column, unit] of rows) {
      const row = table.insertRow();
      row.insertCell().textContent = label;
      const cell = row.insertCell();
      const value = source.data[column][k];
      cell.textContent = typeof value === "string" ? value : `${number(value)} ${unit}`;
      cell.style.textAlign = "right";
    }
    return table;
  };

  const hoverTool = (renderer, mode, rows) =>
    make("HoverTool", {
      renderers: [renderer],
      mode,
      tooltips: tip(rows),
      line_policy: "nearest",
      point_policy: mode === "mouse" ? "snap_to_data" : "follow_mouse",
      show_arrow: false,
      visible: false, // in the row of tools
    });

  const unit = (title) => (/\[([^\]]+)\]/.exec(title)?.[1] ?? "").replace(/^-$/, "");

  // The lines of a panel against one x: an unseen line of their source answers for all of them.
  const hoverAcross = (plot, figure, panel, sources) => {
    const lines = figure.traces.filter(({ panel: at, y }) => at === panel && typeof y === "string");
    if (lines.length === 0) return;
    const [first] = lines;
    const [x, y] = [first.x.slice(1), first.y.slice(1)];
    const glyph = make("Line", { x: { field: x }, y: { field: y }, line_alpha: 0, line_width: 1 });
    const rows = [[figure.x.title.replace(/ \[.*/, ""), x, unit(figure.x.title)]];
    for (const line of lines) rows.push([line.name, line.y.slice(1), unit(figure.panels[panel].title)]);
    plot.add_tools(hoverTool(plot.add_glyph(glyph, sources.shared), "vline", rows));
  };

  // --- traces ------------------------------------------------------------------------------------

  const glyphs = {
    line: (trace, at) => {
      const stroke = { line_width: trace.width, line_dash: trace.dash ?? [], line_join: "round" };
      const steps = trace.steps ? { mode: "after" } : {};
      return make(trace.steps ? "Step" : "Line", { ...at, ...stroke, ...steps }, { line_color: `line-${trace.colour}` });
    },
    markers: (trace, at) =>
      make(
        "Scatter",
        { ...at, marker: { value: trace.symbol ?? "circle" }, size: trace.size ?? 9, line_width: trace.width ?? 1.4 },
        trace.fill
          ? { line_color: `line-${trace.colour}`, fill_color: `line-${trace.fill}` }
          : { line_color: `line-${trace.colour}` },
      ),
    area: (trace, at) =>
      make("Patch", { ...at, line_width: trace.width }, { line_color: `line-${trace.colour}`, fill_color: `line-${trace.fill}` }),
    words: (trace, at) =>
      make(
        "Text",
        {
          ...at,
          text: { field: "text" },
          text_align: "right",
          text_baseline: "middle",
          text_font_size: "11px",
          x_offset: -9,
        },
        { text_color: `line-${trace.colour}` },
      ),
  };

  const drawTrace = (plot, trace, sources) => {
    const shared = typeof trace.x === "string";
    const source = shared
      ? sources.shared
      : columnSource({ x: trace.x, y: trace.y, ...trace.columns });
    const field = (value, name) => ({ field: shared ? value.slice(1) : name });
    const glyph = glyphs[trace.kind](trace, { x: field(trace.x, "x"), y: field(trace.y, "y") });
    const renderer = plot.add_glyph(glyph, source);
    renderer.name = trace.name;
    if (trace.hover) plot.add_tools(hoverTool(renderer, "mouse", trace.hover));
    return renderer;
  };

  // A map's cells, each in the colour of its value; without a value, none.
  const drawMap = (plot, map) => {
    const data = { x: [], y: [], z: [], shown: [] };
    map.z.forEach((row, j) => row.forEach((z, i) => {
      if (z === null) return;
      data.x.push(map.x[i]);
      data.y.push(map.y[j]);
      data.z.push(z);
      data.shown.push(Math.max(z, map.low));
    }));
    const mapper = make("LogColorMapper", { palette: map.palette, low: map.low, high: map.high });
    const colour = { field: "shown", transform: mapper };
    const [width, height] = [map.x[1] - map.x[0], map.y[1] - map.y[0]];
    const cell = { x: { field: "x" }, y: { field: "y" }, width, height, fill_color: colour, line_color: colour, line_width: 1.5 };
    const renderer = plot.add_glyph(make("Rect", cell), columnSource(data));
    plot.add_tools(hoverTool(renderer, "mouse", map.hover));
    const scale = {
      color_mapper: mapper,
      ticker: make("LogTicker", { mantissas: [1] }),
      formatter: make("BasicTickFormatter", { use_scientific: false }),
      width: 12,
      title: map.name,
      title_text_font_size: "11px",
      title_text_font_style: "normal",
      bar_line_color: null,
    };
    const inks = { title_text_color: "ink", major_label_text_color: "ink", background_fill_color: "paper" };
    plot.add_layout(make("ColorBar", scale, inks), "right");
    return renderer;
  };

  // --- figures -----------------------------------------------------------------------------------

  // A name stands above the first panel that has it, and toggles its lines in all of them.
  const addLegends = (plots, figure, renderers, place) => {
    const found = new Map();
    figure.traces.forEach((trace, i) => {
      if (trace.legend === false || trace.kind === "map") return;
      if (trace.x.length === 0 && !trace.moves) return;
      if (!found.has(trace.name)) found.set(trace.name, { panel: trace.panel, lines: [] });
      found.get(trace.name).lines.push(renderers[i]);
    });
    if (found.size < 2) return;
    plots.forEach((plot, panel) => {
      const own = [...found].filter(([, entry]) => entry.panel === panel);
      if (own.length > 0) addLegend(plot, own, place);
    });
  };

  const addLegend = (plot, names, place) => {
    const items = names.map(([name, { lines }]) => make("LegendItem", { label: { value: name }, renderers: lines }));
    const legend = make(
      "Legend",
      {
        items,
        orientation: "horizontal",
        location: "top_left",
        click_policy: "hide",
        label_text_font_size: textSize,
        label_standoff: 4,
        spacing: 10,
        padding: 0,
        margin: 4,
        border_line_color: null,
        inactive_fill_alpha: 0.75,
      },
      { label_text_color: "ink", background_fill_color: "paper", inactive_fill_color: "paper" },
    );
    // As many columns as there is room for, each as wide as the longest name.
    const column = glyphRoom + letter * Math.max(...names.map(([name]) => name.length));
    const arrange = (width) => {
      legend.ncols = Math.max(1, Math.min(names.length, Math.floor(width / column)));
    };
    arrange(place.clientWidth - plot.min_border_left);
    plot.properties.inner_width.change.connect(() => arrange(plot.inner_width));
    plot.add_layout(legend, "above");
  };

  const tools = () => [
    make("BoxZoomTool", {}), make("PanTool", {}), make("WheelZoomTool", {}),
    make("ResetTool", {}), make("SaveTool", {}),
  ];

  // Without a mouse a drag scrolls the page and the figures have no tools.
  const newPlot = (figure, panel, height, xRange) => {
    const plot = make(
      "Plot",
      {
        x_range: xRange,
        y_range: range(figure.panels[panel]),
        x_scale: make(figure.x.log ? "LogScale" : "LinearScale", {}),
        y_scale: make(figure.panels[panel].log ? "LogScale" : "LinearScale", {}),
        height,
        sizing_mode: "stretch_width",
        outline_line_color: null,
        min_border_left: figure.margin ?? 64,
        min_border_right: 12,
        toolbar_location: touched ? null : "right",
        toolbar: make("Toolbar", { logo: null, autohide: true, tools: touched ? [] : tools() }),
      },
      { background_fill_color: "paper", border_fill_color: "paper" },
    );
    const box = plot.toolbar.tools[0];
    if (box) {
      box.match_aspect = Boolean(figure.equal);
      plot.toolbar.active_drag = box;
      plot.toolbar.active_scroll = null;
    }
    return plot;
  };

  // Draw a figure at the element of an id; columns are those of the scenario's run. Returns the
  // sources of the traces that move, and a function that marks a time.
  const draw = async (id, figure, columns) => {
    const place = document.getElementById(id);
    const sources = { shared: columnSource(figure.columns ?? columns) };
    const count = figure.panels.length;
    const xRange = range(figure.x);
    const plots = figure.panels.map((axis, panel) => {
      const last = panel === count - 1;
      const plot = newPlot(figure, panel, Math.round(figure.height / count) + (last ? 15 : -15) * (count - 1), xRange);
      addAxis(plot, axis, "left", true);
      addAxis(plot, figure.x, "below", last);
      return plot;
    });
    const renderers = figure.traces.map((trace) =>
      (trace.kind === "map" ? drawMap : drawTrace)(plots[trace.panel], trace, sources));
    if (figure.hover === "x") plots.forEach((plot, panel) => hoverAcross(plot, figure, panel, sources));
    addLegends(plots, figure, renderers, place);
    if (figure.equal) equalise(plots[0], figure.x.range, figure.panels[0].range);
    const marks = figure.marks_time
      ? plots.map((plot) => {
        const mark = make("Span", { location: 0, dimension: "height", line_width: 1 }, { line_color: "ink" });
        plot.add_layout(mark);
        return mark;
      })
      : [];
    const page = new Bokeh.Document();
    page.add_root(count === 1 ? plots[0] : make("Column", { children: plots, sizing_mode: "stretch_width", spacing: 0 }));
    await Bokeh.embed.add_document_standalone(page, place);
    return {
      plots,
      renderers,
      marks,
      moving: renderers.filter((_, i) => figure.traces[i].moves).map(({ data_source }) => data_source),
      markTime: (time) => marks.forEach((mark) => { mark.location = time; }),
    };
  };

  return { load, unpack, draw, number };
})();
