"""Commands in the documents and in --help examples: the program takes their flags, and what they name is there.

--print_config reads a command line as the command itself would, and does nothing.
"""

import os
import re
import subprocess
import unittest

from documents import code_lines, commands, documents, inline_code, read, repository

PROGRAM = os.path.abspath('tools/egosieve')
# Commands of ./run that are not the program's.
OWN = ('bag', 'view', 'demo', 'evaluate', 'results', 'test', 'bench', 'bench_gpu', 'bench_drive', 'bench_live', 'bench_colmap', 'bench_slam', 'slurm_demo', 'install', 'wheel', 'docs', 'setup', 'help')
# Others' programs, and the shell's own words.
FOREIGN = ('colmap', 'ns-train', 'docker', 'apptainer', 'cmake', 'cc', 'awk', 'export', 'source', 'clang-format', 'clang-tidy', 'build/kriging', 'colcon', 'ros2')


def without_placeholders(word):
    word = word.replace('K/N', '1/2')
    return re.sub(r'=[KN]$', '=1', word)


def text_of(root, path):
    """All text below a path."""
    path = os.path.join(root, path)
    if os.path.isfile(path):
        return read('', path)
    return ''.join(read('', os.path.join(folder, name)) for folder, _, names in os.walk(path) for name in names
                   if name.endswith(('.cc', '.h', '.py', 'BUILD')))


def help_of(*words):
    return subprocess.run([PROGRAM, *words, '--help'], capture_output=True, text=True, check=True).stdout


def every_command():
    """The names of the program's commands."""
    listed = help_of().partition('\nCommands:')[2].partition('\n\n')[0]
    return [(name,) for name in re.findall(r'^  (\w+) {2,}', listed, re.MULTILINE)]


def absent_flags(flags, text):
    names = [flag.partition('=')[0].lstrip('-') for flag in flags if flag.startswith('--') and flag != '--']
    return [name for name in names if not re.search(rf'\b{name.replace("-", "[-_]")}\b', text)]


def fault_of_program(words):
    words = [without_placeholders(word) for word in words]
    if words[0] not in ('--help', '--version', '--man', 'completion') and '--help' not in words:
        words.append('--print_config')
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)
    return done.stderr.strip() if done.returncode else ''


def fault_of_run(root, words):
    command, rest = words[0], words[1:]
    if command not in OWN:
        return fault_of_program(words)
    script = read(root, 'run')
    text = {'bench': text_of(root, 'bench'), 'bench_drive': text_of(root, 'bench/drive'),
            'bench_live': text_of(root, 'bench/live'), 'bench_colmap': text_of(root, 'bench/colmap'), 'bench_slam': text_of(root, 'bench/slam'), 'bag': text_of(root, 'tools/ros'), 'view': text_of(root, 'tools/view'),
            'evaluate': text_of(root, 'tools/evaluate')}.get(command, script)
    # Google Benchmark's own; its value names one of ours.
    filters = [word.partition('=')[2].rstrip('/') for word in rest if word.startswith('--benchmark_filter=')]
    absent = absent_flags([word for word in rest if not word.startswith('--benchmark_')], text)
    absent += [name for name in filters if name not in text]
    if f'./run {command}' not in script and command != 'help':
        absent.append(command)
    return f'./run {command} has no {absent}' if absent else ''


def fault_of_bazel(root, words):
    absent = [word for word in words if word.startswith('--config=')
              and f'build:{word.partition("=")[2]} ' not in read(root, '.bazelrc')]
    for label in (word for word in words if word.startswith('//') and '...' not in word):
        package, _, name = label[2:].partition(':')
        build = os.path.join(root, package, 'BUILD')
        if not os.path.exists(build) or f'"{name or os.path.basename(package)}"' not in read('', build):
            absent.append(label)
    return f'there is no {absent}' if absent else ''


def fault(root, words):
    """What is wrong with a command; '' if nothing is."""
    while words and re.match(r'\w+=', words[0]):
        words = words[1:]
    if not words or words[0] in FOREIGN:
        if words[:1] != ['awk'] and './run' in words:
            return fault_of_run(root, words[words.index('./run') + 1:])
        return ''
    program = words[0]
    if program == 'xargs':
        return fault_of_run(root, words[words.index('./run') + 1:])
    if program == 'egosieve-eval':
        return fault_of_run(root, ['evaluate', *words[1:]])
    if program == 'egosieve-view':
        return fault_of_run(root, ['view', *words[1:]])
    if program in ('./run', 'egosieve'):
        return (fault_of_run(root, words[1:]) if program == './run' else fault_of_program(words[1:])) if len(words) > 1 else ''
    if program == 'bazel':
        return fault_of_bazel(root, words[1:])
    if os.path.isfile(os.path.join(root, program)):
        absent = absent_flags(words[1:], read(root, program))
        return f'{program} has no {absent}' if absent else ''
    if program in ('python3', 'pip'):
        return ''
    return f'{program} is not known to this test'


def shown_commands(root):
    """(where, words) of every command in the documents."""
    for name in documents(root):
        text = read(root, name)
        shell = [line for line in code_lines(text) if re.match(r'(\./run|egosieve|bazel|colmap|ns-train|tests/\S+) ', line)]
        shell += [code for code in inline_code(text) if re.match(r'(\./run|egosieve|bazel|bench/|tests/|docker|source)\S* ', code)]
        for line in shell:
            for words in commands(line):
                yield f'{name}: {line}', words


class Commands(unittest.TestCase):
    maxDiff = None

    def test_documents_show_what_works(self):
        root = repository()
        shown = list(shown_commands(root))
        self.assertGreater(len(shown), 60)
        faults = [f'{where}: {said}' for where, words in shown if (said := fault(root, words))]
        self.assertEqual(faults, [])

    def test_help_shows_what_works(self):
        root = repository()
        names = every_command()
        self.assertIn(('segment',), names)
        faults, count = [], 0
        for name in names:
            for line in help_of(*name).partition('\nExample:')[2].split('\n'):
                if line.strip().startswith('egosieve'):
                    for words in commands(line):
                        count += 1
                        faults += [f'{line}: {said}' for said in [fault(root, words)] if said]
        self.assertGreater(count, 24)
        self.assertEqual(faults, [])

    def test_would_notice(self):
        root = repository()
        for line in ('./run segment a.mp4 --out=b --no_such_flag', './run bench_drive --no_such_flag', './run no_such_command',
                     'bazel test //tests/docs:no_such_test', './run evaluate out/my --no_such_flag', 'bazel test --config=none //...',
                     './run bench --benchmark_filter=BM_None', 'no_such_program a'):
            self.assertTrue(any(fault(root, words) for words in commands(line)), line)
