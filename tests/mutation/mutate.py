#!/usr/bin/python3
"""Flips operators in sources chosen by a seed and says which of them the nearest tests notice.

    tests/mutation/mutate.py --seed=1 --count=50 --results=tests/mutation/results.md

    tests/mutation/mutate.py --only=gp/model/point_set.cc:38 --results=again.md

Works in a clone of HEAD (`--tree`), never in the working tree. A place is a binary operator of a
.cc or .cl file below the folders of `--layers` (but for vision/synthetic), outside comments, strings
and preprocessor lines. Each mutant replaces one operator by its opposite (`FLIPS`) and runs up to
`--tests` small or medium tests of its package, or where none of these reaches the file those that
reach it over the fewest dependencies.
A mutant counts as noticed if a test fails or runs out of time, as survived if all pass; one that
does not compile is replaced by the next place. The tests must pass without a mutant: those that
do not are named and left out.
"""

import argparse
import os
import random
import re
import subprocess
import sys

FLIPS = {'+': '-', '-': '+', '*': '/', '/': '*', '<': '>=', '>=': '<', '>': '<=', '<=': '>',
         '==': '!=', '!=': '==', '&&': '||', '||': '&&', '+=': '-=', '-=': '+='}
# Paints the pictures of other tests; most of its operators shape a texture.
UNTESTED = 'vision/synthetic/'
# clang-format puts spaces around binary operators, and none around template brackets, pointers
# and references.
OPERATOR = re.compile(r'(?<=\S) (\+=|-=|<=|>=|==|!=|&&|\|\||[-+*/<>]) (?=\S)')
HIDDEN = re.compile(r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\'', re.DOTALL)


def blanked(text):
    """`text` with comments, literals and preprocessor lines as spaces, offsets unchanged."""
    blank = lambda match: re.sub(r'[^\n]', ' ', match.group())
    text = HIDDEN.sub(blank, text)
    return re.sub(r'^[ \t]*(?:#|static_assert|template)(?:[^\n]*\\\n)*[^\n]*', blank, text, flags=re.MULTILINE)


def places(tree, layer):
    """(path, offset, operator) of every operator of a layer, in order."""
    found = []
    names = subprocess.run(['git', 'ls-files', layer], cwd=tree, check=True, capture_output=True, text=True).stdout.split()
    for name in names:
        if name.endswith(('.cc', '.cl')) and not name.startswith(UNTESTED):
            with open(os.path.join(tree, name)) as source:
                text = blanked(source.read())
            found += [(name, match.start(1), match.group(1)) for match in OPERATOR.finditer(text)]
    return found


def bazel(tree, *arguments):
    return subprocess.run(['nice', '-n', '10', 'bazel', *arguments], cwd=tree, capture_output=True, text=True)


def host_source(tree, name):
    """`name`, or for a kernel's text the first host file that runs it: all kernels are one library."""
    if name.endswith('.cl'):
        base = os.path.basename(name)
        while True:
            files = subprocess.run(['git', 'grep', '-l', f'"{base}"', 'kernels/ops/*.cc', 'kernels/cl/*.cl'], cwd=tree,
                                   capture_output=True, text=True).stdout.split()
            host = [file for file in files if file.endswith('.cc')]
            if host or not files:
                return host[0] if host else 'kernels/ops/opencl_dense_posterior.cc'
            base = os.path.basename(files[0])
    return name


def nearest_tests(tree, name, count):
    """Up to `count` tests that reach the file over the fewest dependencies."""
    package, _, base = host_source(tree, name).rpartition('/')
    target = f'//{package}:{base}'
    stem = base.rpartition('.')[0]
    chosen = []
    for depth in (2, 3, 4, 5, 6):
        query = f'attr(size, "small|medium", kind("cc_test", rdeps(//tests/..., {target}, {depth})))'
        tests = [test for test in bazel(tree, 'query', query).stdout.split() if test not in chosen and '/fuzz' not in test]
        # The test of the same name first, then those of the same package.
        chosen += sorted(tests, key=lambda test: (test.rpartition(':')[2] != stem + '_test', f'//tests/{package}:' not in test, test))
        if len(chosen) >= count:
            break
    own = [test for test in chosen if f'//tests/{package}:' in test]
    return (own or chosen)[:count]


def run_tests(tree, tests):
    """None if all pass, 'build' if one does not build, else the names of those that failed."""
    result = bazel(tree, 'test', '--test_output=errors', '--notest_keep_going', '--test_timeout=120',
                   '--flaky_test_attempts=1', '--ui_event_filters=-info', *tests)
    if result.returncode == 0:
        return None
    failed = re.findall(r'^(//\S+) +(?:FAILED|TIMEOUT)(?! TO BUILD)', result.stdout + result.stderr, re.MULTILINE)
    if failed:
        return failed
    return 'build'


def line_of(text, offset):
    return text.count('\n', 0, offset) + 1


def line_at(tree, place):
    with open(os.path.join(tree, place[0])) as source:
        return line_of(source.read(), place[1])


class Report:
    def __init__(self, path, flags, commit):
        self.path, self.flags, self.commit, self.rows = path, flags, commit, []

    def add(self, name, line, source, operator, outcome, tests):
        self.rows.append((name, line, source, operator, outcome, tests))
        noticed = sum(row[4] == 'noticed' for row in self.rows)
        with open(self.path, 'w') as out:
            print(f'# Mutants\n\n`tests/mutation/mutate.py {self.flags}` at {self.commit}: '
                  f'{len(self.rows)} mutants, {noticed} noticed.\n', file=out)
            print('| place | source | flip | outcome | tests |\n|---|---|---|---|---|', file=out)
            for name, line, source, operator, outcome, tests in self.rows:
                cell = source.strip().replace('|', '\\|')
                flip = f'{operator} to {FLIPS[operator]}'.replace('|', '\\|')
                print(f'| {name}:{line} | `{cell}` | `{flip}` | {outcome} | {" ".join(tests)} |', file=out)


def mutate(tree, place, count, broken, report):
    """Whether the mutant counts."""
    name, offset, operator = place
    tests = [test for test in nearest_tests(tree, name, count + len(broken)) if test not in broken][:count]
    path = os.path.join(tree, name)
    with open(path) as source:
        text = source.read()
    line = line_of(text, offset)
    shown = text.split('\n')[line - 1]
    if not tests:
        report.add(name, line, shown, operator, 'survived', ['no test reaches it'])
        return True
    unmutated = run_tests(tree, tests)
    if unmutated:
        print(f'{name}: without a mutant: {unmutated}', file=sys.stderr)
        broken.update(unmutated if unmutated != 'build' else tests)
        return mutate(tree, place, count, broken, report)
    try:
        with open(path, 'w') as out:
            out.write(text[:offset] + FLIPS[operator] + text[offset + len(operator):])
        outcome = run_tests(tree, tests)
    finally:
        with open(path, 'w') as out:
            out.write(text)
    if outcome == 'build':
        print(f'{name}:{line}: does not compile', file=sys.stderr)
        return False
    report.add(name, line, shown, operator, 'noticed' if outcome else 'survived', outcome or tests)
    print(f'{name}:{line} {operator}: {outcome or "SURVIVED"}', file=sys.stderr)
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('--seed', type=int, default=1)
    parser.add_argument('--count', type=int, default=50)
    parser.add_argument('--layers', default='kernels,gp,vision,tools', help='folders, by commas, in turn')
    parser.add_argument('--tests', type=int, default=4, help='tests for each mutant')
    parser.add_argument('--only', default='', help='places of a former run, PATH:LINE, by commas: these and no others')
    parser.add_argument('--tree', default='/tmp/egosieve_mutants', help='the clone to work in')
    parser.add_argument('--results', required=True, help='Markdown, written after every mutant')
    arguments = parser.parse_args()
    root = subprocess.run(['git', 'rev-parse', '--show-toplevel'], check=True, capture_output=True, text=True).stdout.strip()
    tree = arguments.tree
    if not os.path.isdir(tree):
        subprocess.run(['git', 'clone', '--quiet', '--shared', root, tree], check=True)
        if os.path.exists(os.path.join(root, '.bazelrc.user')):
            subprocess.run(['cp', os.path.join(root, '.bazelrc.user'), tree], check=True)
    commit = subprocess.run(['git', 'rev-parse', '--short', 'HEAD'], cwd=tree, check=True, capture_output=True, text=True).stdout.strip()
    chooser = random.Random(arguments.seed)
    layers = arguments.layers.split(',')
    by_layer = {layer: places(tree, layer) for layer in layers}
    for found in by_layer.values():
        chooser.shuffle(found)
    order = [by_layer[layers[turn % len(layers)]].pop() for turn in range(len(layers) * min(map(len, by_layer.values())))]
    if arguments.only:
        # A line has several operators: the one that the former run took is the first in its order.
        first = {}
        for place in order:
            first.setdefault(f'{place[0]}:{line_at(tree, place)}', place)
        order = [first[place] for place in arguments.only.split(',')]
    flags = f'--seed={arguments.seed} --layers={arguments.layers} --count={arguments.count}'
    report = Report(arguments.results, flags, commit)
    broken, counted = set(), 0
    for place in order:
        if counted == arguments.count:
            break
        counted += mutate(tree, place, arguments.tests, broken, report)
    subprocess.run(['bazel', 'shutdown'], cwd=tree, check=False)


main()
