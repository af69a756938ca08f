"""The table and the plot of peers.py, from its record and nothing else."""

BAR, GAP, LEFT, WIDTH = 22, 10, 190, 420


def _rate(record, name):
    seconds = record["results"][name].get("seconds", {}).get("predict")
    return 1 / seconds if seconds else None


def _cell(value, form):
    return "" if value is None else format(value, form)


def table(record):
    """Markdown."""
    own = _rate(record, "egosieve") if "egosieve" in record["results"] else None
    lines = [
        f"Exact posterior, mean and variance of f: n = {record['points']}, D = {record['dimension']}, "
        f"{record['queries']} queries a call; medians of {record['rounds']} rounds in one run, two cores, "
        f"{record['machine']['processor']}, load {record['machine']['load']:.1f} at the end.",
        "",
        f"| library | precision | queries/s | egosieve is faster by | {record['update']} replaced, s | "
        f"{record['update']} appended, s | peak MiB (of it imports) | error of mean | error of variance |",
        "|---|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    for name, result in record["results"].items():
        if "error" in result:
            lines.append(f"| {name} | absent: {result['error'].replace('|', '/')} | | | | | | | |")
            continue
        rate, seconds = _rate(record, name), result["seconds"]
        lines.append(
            f"| {name} {result['version']} | {result['precision']} | {_cell(rate, ',.0f')} "
            f"| {_cell(own / rate if own and rate else None, '.2f')} "
            f"| {_cell(seconds.get('replace'), '.3f')} | {_cell(seconds.get('append'), '.3f')} "
            f"| {result['peak_mib']:,.0f} ({result['after_import_mib']:,.0f}) "
            f"| {result['mean_error']:.1e} | {result['variance_error']:.1e} |"
        )
    lines += [
        "",
        "Replaced, appended: 64 new points (the 64 oldest gone), then mean and variance at 256 queries; libraries without "
        "updates fit anew, GPyTorch fast_pred_var appends by fantasy models. Errors: the largest of 256 queries against "
        "the posterior in float64 of the same covariance (arcsine for egosieve arcsine and GPy MLP).",
    ]
    return "\n".join(lines) + "\n"


def joint_table(record):
    """Markdown of --joint."""
    lines = [
        f"Joint posterior of {record['queries']} queries, n = {record['points']}, D = {record['dimension']}; medians of "
        f"{record['rounds']} rounds in one run, two cores, {record['machine']['processor']}, load "
        f"{record['machine']['load']:.1f} at the end.",
        "",
        "| library | precision | mean and covariance, s | egosieve is faster by | 1,000 samples, s | egosieve is faster by | "
        "peak MiB (of it imports) | error of covariance |",
        "|---|---|---:|---:|---:|---:|---:|---:|",
    ]
    own = record["results"].get("egosieve", {}).get("seconds", {})
    for name, result in record["results"].items():
        if "error" in result:
            lines.append(f"| {name} | absent: {result['error'].replace('|', '/')} | | | | | | |")
            continue
        cells = []
        for task in ("joint", "samples"):
            seconds = result["seconds"].get(task)
            ratio = seconds / own[task] if seconds and own.get(task) else None
            cells.append(f"{_cell(seconds, '.2f')} | {_cell(ratio, '.2f')}")
        lines.append(
            f"| {name} {result['version']} | {'float64' if name == 'egosieve' else result['precision']} "
            f"| {' | '.join(cells)} | {result['peak_mib']:,.0f} ({result['after_import_mib']:,.0f}) "
            f"| {_cell(result.get('covariance_error'), '.1e')} |"
        )
    lines += [
        "",
        "Samples of f at the same queries, the covariance among what is timed. Error: the largest of the first 256 queries' "
        "covariances against float64 by LAPACK.",
    ]
    return "\n".join(lines) + "\n"


def bars(record):
    """SVG: queries a second."""
    rates = [(name, _rate(record, name)) for name in record["results"]]
    rates = [(name, rate) for name, rate in rates if rate]
    top = max((rate for _, rate in rates), default=1)
    height = 40 + len(rates) * (BAR + GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{LEFT + WIDTH + 90}" height="{height}" '
        'font-family="sans-serif" font-size="13">',
        '<rect width="100%" height="100%" fill="white"/>',
        f'<text x="{LEFT}" y="20">queries a second, mean and variance, n = {record["points"]}</text>',
    ]
    for i, (name, rate) in enumerate(rates):
        y = 34 + i * (BAR + GAP)
        colour = "#1f6f8b" if name.startswith("egosieve") else "#b8b8b8"
        length = max(WIDTH * rate / top, 1)
        parts.append(f'<text x="{LEFT - 8}" y="{y + 16}" text-anchor="end">{name}</text>')
        parts.append(f'<rect x="{LEFT}" y="{y}" width="{length:.1f}" height="{BAR}" fill="{colour}"/>')
        parts.append(f'<text x="{LEFT + length + 6:.1f}" y="{y + 16}">{rate:,.0f}</text>')
    return "\n".join(parts + ["</svg>"]) + "\n"
