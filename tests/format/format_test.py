"""Sizes: files of at most 450 lines, functions of at most 60, headers that open with a comment; and the layout of C and C++.

A function is found by its closing brace, which clang-format sets under the beginning of its first line.
"""

import ast
import os
import re
import shutil
import subprocess
import unittest

FOLDERS = ('bench', 'gp', 'kernels', 'tests', 'tools', 'vision')
C_LIKE = ('.h', '.hpp', '.cc', '.c', '.cl', '.inc')
MOST_LINES = 450
MOST_OF_A_FUNCTION = 60
# One thought each: tables, and a function per scenario. An entry leaves when it is not needed any more.
LONG_FILES = {'vision/synthetic/scenario_catalogue.cc'}
LONG_FUNCTIONS = {
    'tests/kernels/covariance/scikit_learn_test.cc:AllNumbers',
    'tools/masks/masks_flags.cc:AddFlags',
    'tools/segment/segment_options.cc:MakeOptions',
}


def sources():
    """(path, lines) of the sources of the working tree, which the test reads as it is."""
    root = os.path.dirname(os.path.realpath('run'))
    for folder in FOLDERS:
        for path, _, names in os.walk(os.path.join(root, folder)):
            for name in names:
                if name.endswith((*C_LIKE, '.py', '.sh', 'BUILD', '.bzl')):
                    with open(os.path.join(path, name)) as text:
                        yield os.path.relpath(os.path.join(path, name), root), text.read().split('\n')


def c_functions(lines):
    """(name, number of lines) of the functions at namespace level and within a class."""
    for end, line in enumerate(lines):
        closing = re.match(r'( {0,2})}$', line)
        if not closing:
            continue
        indent, begin = closing.group(1), end - 1
        while begin >= 0 and not re.match(indent + r'[^\s}#]', lines[begin]):
            begin -= 1
        head = ' '.join(lines[max(begin, 0):begin + 3])
        # The last name before the arguments: of `absl::Status Class::Method(`, Method.
        name = re.search(r'(\w+|operator\S+)\((?!\()', head)
        if name and begin >= 0:
            yield name.group(1), end - begin + 1


def python_functions(lines):
    for node in ast.walk(ast.parse('\n'.join(lines))):
        if isinstance(node, ast.FunctionDef):
            yield node.name, node.end_lineno - node.lineno + 1


def functions(path, lines):
    if path.endswith(C_LIKE):
        return c_functions(lines)
    return python_functions(lines) if path.endswith('.py') else ()


class Sizes(unittest.TestCase):
    maxDiff = None

    def test_files(self):
        found = {path: len(lines) - 1 for path, lines in sources()}
        self.assertGreater(len(found), 1000)
        self.assertEqual({path for path, count in found.items() if count > MOST_LINES}, LONG_FILES)

    def test_functions(self):
        found = {(f'{path}:{name}', count) for path, lines in sources() for name, count in functions(path, lines)}
        self.assertGreater(len(found), 5000)
        long = {(name, count) for name, count in found if count > MOST_OF_A_FUNCTION}
        self.assertEqual({entry for entry in long if entry[0] not in LONG_FUNCTIONS}, set())
        self.assertEqual(LONG_FUNCTIONS - {name for name, _ in long}, set())

    def test_headers_open_with_a_comment(self):
        found = {path for path, lines in sources() if path.endswith(('.h', '.hpp')) and not lines[0].startswith(('//', '/*'))}
        self.assertEqual(found, set())

    def test_layout(self):
        """As clang-format 14 (Debian 12's) leaves it; other versions lay out some things otherwise."""
        if not shutil.which('clang-format') or b'version 14.' not in subprocess.check_output(['clang-format', '--version']):
            self.skipTest('there is no clang-format 14')
        root = os.path.dirname(os.path.realpath('run'))
        files = [path for path, _ in sources() if path.endswith(C_LIKE) and not path.endswith('.cl')]
        subprocess.run(['clang-format', '--dry-run', '-Werror', *files], cwd=root, check=True)

    def test_would_notice(self):
        text = ['absl::Status Class::Method(int a,', '                           int b) {', *['  call();'] * 60, '}', '',
                'class C {', '  int Short() const {', '    return 1;', '  }', '};']
        self.assertEqual(dict(c_functions(text)), {'Method': 63, 'Short': 3})
        self.assertEqual(dict(python_functions(['def f():', '    return 1'])), {'f': 2})


if __name__ == '__main__':
    unittest.main()
