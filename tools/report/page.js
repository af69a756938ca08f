"use strict";
(function () {
  // Paul Tol's "bright" and "muted" colours: told apart by colour-blind eyes too.
  var COLOURS = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#882255", "#999933", "#44aa99", "#ddcc77", "#332288", "#bbbbbb"];
  var charts = JSON.parse(document.getElementById("charts").textContent);
  var graphs = [];

  // A click shows a picture large; arrow keys step through them, escape closes it.
  var figures = Array.prototype.slice.call(document.querySelectorAll(".pictures figure"));
  var shown = -1;
  function show(i) {
    if (shown >= 0) figures[shown].classList.remove("large");
    shown = i >= 0 && i < figures.length ? i : -1;
    if (shown >= 0) figures[shown].classList.add("large");
  }
  figures.forEach(function (figure, i) {
    figure.querySelector("img").addEventListener("click", function () { show(shown === i ? -1 : i); });
  });
  document.addEventListener("keydown", function (event) {
    var focused = figures.indexOf(document.activeElement && document.activeElement.parentNode);
    if (event.key === "Enter" && focused >= 0 && shown < 0) show(focused);
    else if (shown < 0) return;
    else if (event.key === "ArrowRight") show(Math.min(shown + 1, figures.length - 1));
    else if (event.key === "ArrowLeft") show(Math.max(shown - 1, 0));
    else if (event.key === "Escape") show(-1);
  });
  var zooming = false;

  // Zooming one chart along the frames zooms all.
  function zoomAll(source, isInitial) {
    if (zooming || isInitial) return;
    zooming = true;
    var range = source.xAxisRange();
    graphs.forEach(function (graph) {
      if (graph !== source) graph.updateOptions({ dateWindow: source.isZoomed("x") ? range : null });
    });
    zooming = false;
  }

  function number(value) {
    if (value === null || value === undefined || isNaN(value)) return "–";
    var size = Math.abs(value);
    return size >= 1000 ? value.toFixed(0) : size >= 10 ? value.toFixed(1) : size >= 0.01 || size === 0 ? value.toFixed(3).replace(/\.?0+$/, "") : value.toExponential(1);
  }

  function drawKey(key, chart, colours, x, row) {
    key.textContent = "";
    var lead = document.createElement("span");
    lead.textContent = x === null ? "" : "frame " + x;
    if (x !== null) key.appendChild(lead);
    chart.series.forEach(function (name, i) {
      var item = document.createElement("span"), swatch = document.createElement("i"), value = document.createElement("b");
      swatch.style.background = colours[i];
      item.appendChild(swatch);
      item.appendChild(document.createTextNode(name + (row ? " " : "")));
      if (row) { value.textContent = number(row[i]); item.appendChild(value); }
      key.appendChild(item);
    });
  }

  // [0, a little more than what 98 % of the points reach]; one slow frame must not flatten the rest.
  function rangeFromZero(chart) {
    var tops = chart.stacked
      ? chart.x.map(function (_, i) { return chart.values.reduce(function (sum, row) { return sum + (row[i] || 0); }, 0); })
      : [].concat.apply([], chart.values).filter(function (value) { return value !== null; });
    tops.sort(function (a, b) { return a - b; });
    var usual = tops[Math.floor(0.98 * (tops.length - 1))], top = tops[tops.length - 1];
    var limit = top <= 2 * usual ? top : 1.25 * usual;
    return [0, limit > 0 ? 1.08 * limit : 1];
  }

  charts.forEach(function (chart) {
    var rows = chart.x.map(function (x, i) {
      return [x].concat(chart.values.map(function (series) { return series[i]; }));
    });
    var plot = document.getElementById("plot-" + chart.id), key = document.getElementById("key-" + chart.id);
    var colours = chart.series.map(function (_, i) { return COLOURS[i % COLOURS.length]; });
    drawKey(key, chart, colours, null, null);
    graphs.push(new Dygraph(plot, rows, {
      labels: ["frame"].concat(chart.series),
      colors: colours,
      stackedGraph: chart.stacked,
      fillGraph: chart.stacked || (chart.from_zero && chart.series.length === 1),
      fillAlpha: chart.stacked ? 0.75 : 0.12,
      strokeWidth: chart.stacked ? 0.6 : 1.4,
      drawPoints: chart.x.length <= 60 && !chart.stacked,
      pointSize: 2,
      connectSeparatedPoints: true,
      valueRange: chart.from_zero ? rangeFromZero(chart) : null,
      ylabel: chart.unit,
      xRangePad: 6,
      gridLineColor: "#e8ecf0",
      axisLineColor: "#9aa5b1",
      legend: "never",
      axes: { x: { pixelsPerLabel: 70, axisLabelFormatter: function (x) { return x % 1 === 0 ? String(x) : ""; } }, y: { axisLabelWidth: 54, pixelsPerLabel: 34, axisLabelFormatter: function (y) { return String(+y.toPrecision(6)); } } },
      highlightCallback: function (event, x, points, row) { drawKey(key, chart, colours, x, rows[row].slice(1)); },
      unhighlightCallback: function () { drawKey(key, chart, colours, null, null); },
      drawCallback: zoomAll
    }));
  });
})();
