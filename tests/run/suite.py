#!/usr/bin/env python3
"""What `./run test` does: the whole suite; ends with "N passed, N failed, N skipped".

--checks: with warnings as errors, and sanitizers over fast tests of what works on memory, files and threads.
--all: sanitizers over all tests of the libraries, and clang-tidy.
EGOSIEVE_SANITIZE_WITHIN: the fast sanitizers also run if the suite took fewer seconds than this.
EGOSIEVE_TIDY_UNTIL: clang-tidy also checks gp and kernels, as far as it gets in so many seconds after the beginning.

Counted are test cases. One failure is a target that failed without a report of its cases (crash, time-out, failed build), each
warning of the compiler in our sources, and each source in which clang-tidy finds something.
"""

import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).absolute().parents[2]
LIBRARIES = ['//tests/kernels/...', '//tests/gp/...', '//tests/vision/...', '//tests/tools/...']
FAST = ['//tests/kernels/base/...', '//tests/kernels/files/...', '//tests/gp/io/...', '//tests/gp/linalg/...',
        '//tests/vision:parts_test']
ADDRESS = ['--config=asan', '--config=ubsan']
BAZEL = ['bazel', 'test', '--keep_going', '--local_test_jobs=2', '--test_summary=short', '--test_output=errors', '--show_progress',
         '--curses=no', '--color=no', '--show_progress_rate_limit=15', '--progress_report_interval=15']
# As .bazelrc and third_party have them.
TIDY = ['-std=c++20', '-I.', '-isystem', '/usr/include/eigen3', '-isystem', '/usr/include/opencv4', '-DCL_TARGET_OPENCL_VERSION=120',
        '-DCL_HPP_TARGET_OPENCL_VERSION=120', '-DCL_HPP_MINIMUM_OPENCL_VERSION=120', '-DCL_HPP_ENABLE_EXCEPTIONS', '-DTOML_HEADER_ONLY=1']
PROGRESS = re.compile(r'\[([0-9,]+) / ([0-9,]+)\]')
OUTCOME = re.compile(r'(//\S+) +(?:\(cached\) )?(PASSED|FAILED|TIMEOUT|NO STATUS)')
WARNING = re.compile(r'(bench|gp|kernels|tests|tools|vision)/\S+: warning: ')

start = time.monotonic()
passed = failed = skipped = 0


def say(text):
    print(f'run: {text}', file=sys.stderr, flush=True)


def within(variable):
    """Whether the seconds that the variable allows are not over; None without it."""
    return time.monotonic() - start < float(os.environ[variable]) if os.environ.get(variable) else None


def cases(target, has_passed):
    """Passed, failed and skipped cases of a target, in all of its shards."""
    folder = ROOT / 'bazel-testlogs' / target[2:].replace(':', '/')
    texts = [report.read_text(errors='replace') for report in folder.glob('shard_*/test.xml')]
    if not texts:
        texts = [report.read_text(errors='replace') for report in [folder / 'test.xml'] if report.exists()]
    heads = [re.search(r'<testsuites[^>]*', text) for text in texts]
    count = lambda name: sum(int((re.search(rf' {name}="(\d+)"', head[0] if head else '') or [0, 0])[1]) for head in heads)  # noqa: E731
    bad, left_out = count('failures') + count('errors'), sum(text.count('result="skipped"') for text in texts)
    if not has_passed:
        bad = max(bad, 1)
    return max(count('tests'), 1) - bad - left_out, bad, left_out


def stage(*arguments):
    """Runs `bazel test` and adds to the counts."""
    global passed, failed, skipped
    say(f'bazel test {" ".join(arguments)}')
    before, outcomes = failed, {}
    with subprocess.Popen([*BAZEL, *arguments], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors='replace') as bazel:
        for line in bazel.stdout:
            if progress := PROGRESS.match(line):
                if progress[1] != '0':
                    say(f'{progress[1]} of {progress[2]} steps are done')
            elif not re.match(r'(Loading|Analyzing|INFO)[: ]', line):
                print(line, end='', flush=True)
            failed += bool(WARNING.match(line))
            if outcome := OUTCOME.match(line):
                outcomes[outcome[1]] = outcome[2] == 'PASSED'
    for target, has_passed in outcomes.items():
        good, bad, left_out = cases(target, has_passed)
        passed, failed, skipped = passed + good, failed + bad, skipped + left_out
    if bazel.returncode and failed == before:
        failed += 1


def tidy(folders, has_time):
    """The checks of .clang-tidy, of the last commit's sources first."""
    global failed
    if not shutil.which('clang-tidy'):
        return say('there is no clang-tidy; its checks are left out')
    patterns = [f'{folder}/*.cc' for folder in folders]
    git = lambda *words: subprocess.run(['git', *words, *patterns], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()  # noqa: E731
    files = list(dict.fromkeys(git('diff', '--name-only', '--diff-filter=d', 'HEAD~1', '--') + git('ls-files')))
    checked = 0
    for checked, file in enumerate(files, 1):
        if not has_time():
            checked -= 1
            break
        failed += subprocess.run(['clang-tidy', '--quiet', '--warnings-as-errors=*', file, '--', *TIDY], cwd=ROOT,
                                 stderr=subprocess.DEVNULL, check=False).returncode != 0
    return say(f'clang-tidy has checked {checked} of {len(files)} sources')


def main(words):
    mode = words.pop(0) if words[:1] in (['--checks'], ['--all']) else ''
    stage(*['--config=werror'] * bool(mode), *words, '//...')
    if mode == '--all':
        stage(*ADDRESS, *words, *LIBRARIES)
        stage('--config=tsan', *words, *LIBRARIES[:2], '//tests/vision/segmentation/...', '//tests/tools/embed/c/...')
        tidy(['kernels', 'gp', 'vision', 'tools'], lambda: True)
    elif mode or within('EGOSIEVE_SANITIZE_WITHIN'):
        stage(*ADDRESS, *words, *FAST)
        stage('--config=tsan', *words, '//tests/kernels/base/...', '//tests/kernels/runtime/...')
    elif within('EGOSIEVE_SANITIZE_WITHIN') is not None:
        say(f'the suite took {time.monotonic() - start:.0f} s: the sanitizers are left out')
    if mode != '--all' and within('EGOSIEVE_TIDY_UNTIL') is not None:
        tidy(['gp', 'kernels'], lambda: within('EGOSIEVE_TIDY_UNTIL'))
    print(f'{passed} passed, {failed} failed, {skipped} skipped', flush=True)
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main(sys.argv[1:]))
