"""The tables and the plot of peers.py, from its record and nothing else."""

import math

TITLES = {
    "predict": ("Mean and variance of {queries:,} queries", "queries/s"),
    "mean": ("Mean alone of {queries:,} queries", "queries/s"),
    "joint": ("Mean and joint covariance of {joint_queries:,} queries", "s"),
    "fit": ("Fit at given hyperparameters until the first prediction", "s"),
    "samples": ("1,000 samples of f at {joint_queries:,} queries, the covariance among what is timed", "s"),
    "replace": ("64 points replaced, then mean and variance at 256 queries; libraries without updates fit anew", "s"),
    "append": ("64 points appended, likewise; GPyTorch fast_pred_var by fantasy models", "s"),
}
COLOURS = {
    "scikit-learn": "#d08a2e",
    "GPyTorch exact": "#c0392b",
    "GPyTorch fast_pred_var": "#e39a92",
    "GPy": "#5b8c3a",
    "OpenTURNS": "#7a5ea8",
}
OWN = "egosieve"
ROW, LEFT, WIDTH, TOP = 24, 230, 520, 54


def _seconds(case, name, task):
    return case["results"].get(name, {}).get("seconds", {}).get(task)


def _peers(cases):
    names = dict.fromkeys(name for case in cases for name in case["results"])
    return [name for name in names if name != OWN]


def _ratio(case, name, task):
    """How many times as long as egosieve."""
    own, other = _seconds(case, OWN, task), _seconds(case, name, task)
    return other / own if own and other else None


def _times(ratio):
    return "" if ratio is None else f"{ratio:.1f}" if ratio < 100 else f"{ratio:,.0f}"


def _rows(cases):
    """The covariances first, then dimensions and points."""
    plain = [case for case in cases if (case["points"], case["dimension"]) == (1000, 6)]
    rest = [case for case in cases if case not in plain]
    return plain + sorted(rest, key=lambda case: (case["dimension"] != 6, case["dimension"], case["points"]))


def _task_table(task, cases, record):
    title, unit = TITLES[task]
    peers = [name for name in _peers(cases) if any(_seconds(case, name, task) for case in cases)]
    lines = [
        f"## {title.format(**record)}",
        "",
        f"| covariance | n | D | egosieve, {unit} | {' | '.join(peers)} |",
        "|---|---:|---:|---:|" + "---:|" * len(peers),
    ]
    for case in cases:
        own = _seconds(case, OWN, task)
        if own is None:
            continue
        value = f"{1 / own:,.0f}" if unit == "queries/s" else f"{own:.3g}"
        cells = " | ".join(_times(_ratio(case, name, task)) for name in peers)
        lines.append(f"| {case['covariance']} | {case['points']} | {case['dimension']} | {value} | {cells} |")
    return [*lines, ""]


def _table(cases, align, cell):
    """A row for each case that has a cell, a column for each library."""
    names = [OWN, *_peers(cases)]
    lines = [f"| covariance | n | D | {' | '.join(names)} |", "|---|---:|---:|" + align * len(names)]
    for case in cases:
        cells = [cell(case["results"].get(name, {})) for name in names]
        if any(cells):
            lines.append(f"| {case['covariance']} | {case['points']} | {case['dimension']} | {' | '.join(cells)} |")
    return [*lines, ""]


def _errors(result):
    return f"{result['mean_error']:.0e}, {result['variance_error']:.0e}" if "mean_error" in result else ""


def _memory(result):
    return f"{result['peak_mib']:,.0f}" if result.get("peak_mib") is not None else ""


def _error_table(cases):
    note = "Of 256 queries, against the same covariance's posterior in float64."
    return ["## Largest errors of mean and of variance", "", note, "", *_table(cases, "---|", _errors)]


def _memory_table(cases):
    return ["## Memory", "", "Peak of the process in MiB.", "", *_table(cases, "---:|", _memory)]


def tables(record):
    """Markdown."""
    cases = _rows(record["cases"])
    loads = [case["machine"]["load"] for case in cases]
    versions = {
        f"{name} {result['version']} ({result['precision']})": None
        for case in cases
        for name, result in case["results"].items()
        if "version" in result
    }
    lines = [
        f"Exact posteriors of f, medians of {record['rounds']} rounds in one run, two cores, "
        f"{cases[0]['machine']['processor']}, load {min(loads):.1f} to {max(loads):.1f}. Under a library's name: how many "
        "times as long as egosieve it takes; empty: it does not have that. Joint covariances, samples and fits are float64 "
        "in egosieve, all else is as listed.",
        "",
        ", ".join(versions) + ".",
        "",
    ]
    lines += [f"{name} is absent: {why}" for name, why in record["absent"].items()]
    for task in TITLES:
        if any(_seconds(case, OWN, task) for case in cases):
            lines += _task_table(task, cases, record)
    return "\n".join(lines + _error_table(cases) + _memory_table(cases)).rstrip() + "\n"


def figure(record):
    """SVG: how many times as long as egosieve each peer takes for mean and variance."""
    cases = _rows(record["cases"])
    peers = [name for name in _peers(cases) if any(_ratio(case, name, "predict") for case in cases)]
    ratios = [_ratio(case, name, "predict") for case in cases for name in peers]
    low = min([0, *(math.floor(math.log10(ratio)) for ratio in ratios if ratio)])
    high = max([1, *(math.ceil(math.log10(ratio)) for ratio in ratios if ratio)])
    bottom = TOP + ROW * len(cases)

    def place(ratio):
        return LEFT + WIDTH * (math.log10(ratio) - low) / (high - low)

    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{LEFT + WIDTH + 40}" height="{bottom + 40}" '
        'font-family="sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text x="{LEFT}" y="18">time for mean and variance, in that of egosieve</text>',
    ]
    for i, name in enumerate(peers):
        parts.append(f'<circle cx="{150 * i + 16}" cy="36" r="5" fill="{COLOURS[name]}"/>')
        parts.append(f'<text x="{150 * i + 26}" y="40" font-size="11">{name}</text>')
    for power in range(low, high + 1):
        x = place(10.0**power)
        parts.append(f'<line x1="{x:.1f}" y1="{TOP}" x2="{x:.1f}" y2="{bottom}" stroke="#ccc"/>')
        parts.append(f'<text x="{x:.1f}" y="{bottom + 18}" text-anchor="middle">{10.0**power:g}</text>')
    for i, case in enumerate(cases):
        y = TOP + ROW * i + ROW / 2
        name = f"{case['covariance']}, n = {case['points']}, D = {case['dimension']}"
        parts.append(f'<text x="{LEFT - 8}" y="{y + 4}" text-anchor="end" font-size="11">{name}</text>')
        for peer in peers:
            ratio = _ratio(case, peer, "predict")
            if ratio:
                parts.append(f'<circle cx="{place(ratio):.1f}" cy="{y}" r="5" fill="{COLOURS[peer]}"/>')
    return "\n".join(parts + ["</svg>"]) + "\n"
