"use strict";
(function () {
  // Paul Tol's "bright" and "muted" colours: told apart by colour-blind eyes too.
  var COLOURS = ["#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377", "#882255", "#999933", "#44aa99", "#ddcc77", "#332288", "#bbbbbb"];

  // Series by the places of their values in a frame's line (frames.jsonl). below: a series for each value there.
  // zero: the vertical axis starts at 0 and includes 98 % of the points.
  var CHARTS = [
    { of: "scores", title: "Area under the ROC curve", unit: "AUC", series: { AUC: "/auc" },
      caption: "Against the truth, frame by frame; frames whose truth has one class have none." },
    { title: "Dynamic share", unit: "%", zero: true, scale: 100, series: { "dynamic share": "/dynamic_share" },
      caption: "Percentage of the grid's pixels whose probability of moving is 1/2 or more." },
    { title: "Model size", unit: "points", zero: true, series: { "model size": "/model_size" },
      caption: "Training points of the Gaussian process after each frame." },
    { title: "Time by stage", unit: "ms", zero: true, stacked: true, below: "/milliseconds/",
      caption: "Milliseconds per frame, one stage on top of the other. The axis is cut where 98 % of the frames lie." },
    { title: "Matches and labels", unit: "features", zero: true,
      series: { matches: "/matches", inliers: "/inliers", "static labels": "/labelled_static", "dynamic labels": "/labelled_dynamic" },
      caption: "Matched features, inliers of the camera's motion, and the labels made from them." },
    { title: "Evidence", unit: "%", zero: true, stacked: true, scale: 100, below: "/decided_by/",
      caption: "Percentage of the dynamic labels by the evidence that weighed most: distance to the epipolar line or homography, depth behind the camera, road." },
    { title: "New points", unit: "points", zero: true,
      series: { candidates: "/points/candidates", "dropped: density": "/points/dropped_by_density", "dropped: novelty": "/points/dropped_by_novelty", added: "/points/added" },
      caption: "A frame's labelled features, those that the filters dropped, and those that the model took." },
    { title: "Points that left the model", unit: "points", zero: true,
      series: { consistency: "/points/dropped_by_consistency", density: "/points/dropped_by_model_density", age: "/points/dropped_by_age", budget: "/points/dropped_by_budget" },
      caption: "Points per frame, by the filter that dropped them." },
    { title: "Log marginal likelihood", unit: "nats / point", series: { "log likelihood": "/log_likelihood_per_point" },
      caption: "Of the training subset, in nats per point, in the frames that trained." },
    { title: "Hyperparameters", unit: "log", below: "/theta/", names: thetaNames,
      caption: "Natural logarithms: the covariance's scale of each input, its amplitude, the noise." },
    { title: "Calibration", unit: "", series: { a: "/a", b: "/b" }, caption: "a and b of p = Φ((a mean + b) / sqrt(1 + a² variance))." },
    { title: "Frames by outcome", unit: "%", zero: true, stacked: true, scale: 100, below: "/outcome/",
      caption: "Percentage of the frames that were learnt from, that have a map and were not learnt from, and that could not be read." }
  ];

  // D + 3 values for the arcsine over the six inputs, D + 2 for the squared exponential.
  function thetaNames(size) {
    var scales = size === 9 ? ["w bias", "w u", "w v", "w M", "w R", "w G", "w B"] : size === 8 ? ["l u", "l v", "l M", "l R", "l G", "l B"] : [];
    for (var i = scales.length; i + 2 < size; ++i) scales.push("scale " + i);
    return scales.concat(["sigma f", "sigma n"]);
  }

  var report = JSON.parse(document.getElementById("report").textContent);
  var graphs = [], figures = [], shown = -1, zooming = false;

  function add(parent, tag, text, kind) {
    var element = document.createElement(tag);
    if (text !== undefined && text !== null) element.textContent = text;
    if (kind) element.className = kind;
    parent.appendChild(element);
    return element;
  }

  // A row per mover; amber columns are unreliable frames.
  function drawTimeline(parent, timeline) {
    var box = add(parent, "div", "", "timeline"), size = timeline.last - timeline.first + 1;
    function bar(row, range, colour, title) {
      var element = add(row, "i");
      element.style.left = 100 * (range[0] - timeline.first) / size + "%";
      element.style.width = 100 * (range[1] - range[0] + 1) / size + "%";
      element.style.background = colour;
      element.title = title;
      element.className = title ? "stay" : "";
    }
    timeline.rows.forEach(function (mover) {
      add(box, "span", mover.number);
      var row = add(box, "div");
      timeline.doubtful.forEach(function (range) { bar(row, range, "#f0c060", ""); });
      mover.stays.forEach(function (range) { bar(row, range, mover.colour, mover.number + ": frames " + range[0] + " to " + range[1]); });
    });
    add(box, "span");
    add(add(box, "p", "frame " + timeline.first), "span", timeline.last);
    add(parent, "p", timeline.note, "note");
  }

  // A click shows a picture large; arrow keys step through them, escape closes it.
  function show(i) {
    if (shown >= 0) figures[shown].classList.remove("large");
    shown = i >= 0 && i < figures.length ? i : -1;
    if (shown >= 0) figures[shown].classList.add("large");
  }

  function drawPicture(parent, picture, i) {
    var figure = add(parent, "figure", "", picture.unreliable ? "unreliable" : ""), image = add(figure, "img");
    image.src = picture.source;
    image.alt = "overlay of " + picture.caption;
    image.tabIndex = 0;
    image.addEventListener("click", function () { show(shown === i ? -1 : i); });
    add(figure, "figcaption", picture.caption);
    figures.push(figure);
  }

  // A page that was moved without the video, or a browser that cannot decode it, has the link alone.
  function drawVideo(parent, source) {
    var video = add(parent, "video");
    video.controls = true;
    video.preload = "metadata";
    video.addEventListener("error", function () { video.remove(); });
    video.src = source;
    add(add(parent, "p"), "a", source).href = source;
  }

  document.addEventListener("keydown", function (event) {
    var focused = figures.indexOf(document.activeElement && document.activeElement.parentNode);
    if (event.key === "Enter" && focused >= 0 && shown < 0) show(focused);
    else if (shown < 0) return;
    else if (event.key === "ArrowRight") show(Math.min(shown + 1, figures.length - 1));
    else if (event.key === "ArrowLeft") show(Math.max(shown - 1, 0));
    else if (event.key === "Escape") show(-1);
  });

  function drawTable(parent, table) {
    var body = add(add(parent, "div", "", "scroll"), "table");
    [table.head].concat(table.rows).forEach(function (cells, i) {
      var row = add(body, "tr");
      cells.forEach(function (cell, k) { add(row, i ? "td" : "th", cell, table.numbers.indexOf(k) >= 0 ? "number" : ""); });
    });
  }

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

  function drawKey(key, names, x, row) {
    key.textContent = "";
    if (x !== null) add(key, "span", "frame " + x);
    names.forEach(function (name, i) {
      var item = add(key, "span");
      add(item, "i").style.background = COLOURS[i % COLOURS.length];
      item.appendChild(document.createTextNode(name + (row ? " " : "")));
      if (row) add(item, "b", number(row[i]));
    });
  }

  // [0, a little more than what 98 % of the points reach]; one slow frame must not flatten the rest.
  function rangeFromZero(rows, stacked) {
    var tops = [].concat.apply([], rows.map(function (row) {
      return stacked ? [row.slice(1).reduce(function (sum, value) { return sum + (value || 0); }, 0)]
        : row.slice(1).filter(function (value) { return value !== null; });
    }));
    tops.sort(function (a, b) { return a - b; });
    var usual = tops[Math.floor(0.98 * (tops.length - 1))], top = tops[tops.length - 1];
    var limit = top <= 2 * usual ? top : 1.25 * usual;
    return [0, limit > 0 ? 1.08 * limit : 1];
  }

  function drawChart(parent, chart, data) {
    var series = chart.series || {}, names = Object.keys(series);
    if (chart.below) {
      var places = Object.keys(data.columns).filter(function (place) { return place.indexOf(chart.below) === 0; });
      names = places.map(function (place) { return place.slice(chart.below.length).replace(/~1/g, "/").replace(/~0/g, "~"); });
      if (chart.names) names = chart.names(names.length);
      names.forEach(function (name, i) { series[name] = places[i]; });
    }
    if (!names.some(function (name) { return data.columns[series[name]]; })) return;
    var rows = data.index.map(function (x, i) {
      return [x].concat(names.map(function (name) {
        var value = (data.columns[series[name]] || [])[i];
        return value === null || value === undefined ? null : value * (chart.scale || 1);
      }));
    });
    var card = add(parent, "div", "", "card");
    add(card, "h3", chart.title);
    add(card, "p", chart.caption + (data.step > 1 ? " Each point is the mean of " + data.step + " frames." : ""));
    var plot = add(card, "div", "", "plot"), key = add(card, "div", "", "key");
    drawKey(key, names, null, null);
    graphs.push(new Dygraph(plot, rows, {
      labels: ["frame"].concat(names),
      colors: names.map(function (_, i) { return COLOURS[i % COLOURS.length]; }),
      stackedGraph: !!chart.stacked,
      fillGraph: chart.stacked || (chart.zero && names.length === 1),
      fillAlpha: chart.stacked ? 0.75 : 0.12,
      strokeWidth: chart.stacked ? 0.6 : 1.4,
      drawPoints: rows.length <= 60 && !chart.stacked,
      pointSize: 2,
      connectSeparatedPoints: true,
      valueRange: chart.zero ? rangeFromZero(rows, chart.stacked) : null,
      ylabel: chart.unit,
      xRangePad: 6,
      gridLineColor: "#e8ecf0",
      axisLineColor: "#9aa5b1",
      legend: "never",
      axes: { x: { pixelsPerLabel: 70, axisLabelFormatter: function (x) { return x % 1 === 0 ? String(x) : ""; } }, y: { axisLabelWidth: 54, pixelsPerLabel: 34, axisLabelFormatter: function (y) { return String(+y.toPrecision(6)); } } },
      highlightCallback: function (event, x, points, row) { drawKey(key, names, x, rows[row].slice(1)); },
      unhighlightCallback: function () { drawKey(key, names, null, null); },
      drawCallback: zoomAll
    }));
  }

  document.title = "Egosieve: " + report.title;
  var main = document.querySelector("main"), header = add(main, "header");
  add(add(header, "h1", report.title + " "), "span", report.ended === "running" ? "not finished" : report.ended, "pill " + report.ended);
  report.verdict.forEach(function (line) {
    var row = add(header, "p", "", "verdict " + line[2]);
    add(row, "b", line[0]);
    add(row, "span", line[1]);
  });
  report.about.forEach(function (line) { add(header, "p", line[0], line[1]); });
  var tiles = add(main, "section", "", "tiles");
  report.tiles.forEach(function (tile) {
    var box = add(tiles, "div", "", "tile");
    add(box, "b", tile[0]);
    add(box, "span", tile[1]);
  });
  report.sections.forEach(function (section) {
    if (section.title) add(main, "h2", section.title);
    if (section.timeline) drawTimeline(main, section.timeline);
    if (section.video) drawVideo(main, section.video);
    (section.notes || []).forEach(function (note) { add(main, "p", note, "note"); });
    if (section.pictures) {
      var pictures = add(main, "section", "", section.portrait ? "pictures portrait" : "pictures");
      section.pictures.forEach(function (picture, i) { drawPicture(pictures, picture, i); });
    }
    if (section.charts) {
      var charts = add(main, "section", "", "charts");
      CHARTS.forEach(function (chart) {
        var data = section.charts[chart.of || "frames"];
        if (data) drawChart(charts, chart, data);
      });
    }
    if (section.table) {
      var parent = section.summary ? add(main, "details") : main;
      if (section.summary) add(parent, "summary", section.summary);
      drawTable(parent, section.table);
    }
  });
})();
