"""A numbered equation is cited by its tag, (TV3) for instance: each tag stands for one equation, in one file."""

import os
import re
import unittest

from documents import files_below, read, repository

FOLDERS = ('kernels', 'gp', 'vision', 'tools', 'bench')
TAG = r'\(([A-Z]{1,3}\d{1,2})\)'
# In a comment, an equation's tag stands in front of it, or at the line's end behind it. Equations are indented, or the
# tag is set apart from the words before it.
DEFINED = re.compile(fr'^\s*//(?: {{2,}}{TAG} | {{2,}}\S.* {TAG}$|.* {{2,}}{TAG}$)', re.MULTILINE)


def defined(text):
    return {tag for found in DEFINED.findall(text) for tag in found if tag}


def cited_with_a_file(text):
    """The (file's name, tag) of each "(file.h, X1)"."""
    return re.findall(r'([\w.]+\.h), ([A-Z]{1,3}\d{1,2})\b', text)


def sources():
    """(path, text) of the sources of the working tree."""
    root = repository()
    for path in files_below(root, FOLDERS):
        if path.endswith(('.h', '.hpp', '.cc', '.c', '.cl')):
            yield path, read(root, path)


class EquationTags(unittest.TestCase):
    maxDiff = None

    def test_have_one_meaning(self):
        files = {}
        for path, text in sources():
            for tag in defined(text):
                files.setdefault(tag, []).append(path)
        self.assertGreater(len(files), 190)
        self.assertEqual({tag: sorted(paths) for tag, paths in files.items() if len(paths) > 1}, {})

    def test_what_is_cited_is_defined(self):
        cited, known = set(), set()
        for _, text in sources():
            known |= defined(text)
            cited |= set(re.findall(TAG, '\n'.join(line.partition('//')[2] for line in text.split('\n'))))
        self.assertEqual(cited - known, set())

    def test_a_file_that_is_named_has_the_tag(self):
        files, wrong = {}, []
        for path, text in sources():
            files.setdefault(os.path.basename(path), set()).update(defined(text))
        for path, text in sources():
            wrong += [(path, name, tag) for name, tag in cited_with_a_file(text) if tag not in files.get(name, set())]
        self.assertEqual(wrong, [])

    def test_would_notice(self):
        self.assertEqual(cited_with_a_file('// as in (a/pose.h, N4)\n// (b.h, X1\n// and X2), (c.h)'), [('pose.h', 'N4'), ('b.h', 'X1')])
        self.assertEqual(defined('//   a = b   (X1)\n// as (X2) says\n// of (X3)\n'), {'X1'})
        self.assertEqual(defined('//   (X1) a = b\n  //   (X2)  c = d\n// (X3) and (X4) of it\n//   (X5), (X6) again\n'), {'X1', 'X2'})
        self.assertEqual(defined('//   a = b (X1)\n//                (X2)\n//   rows  (X3)-(X4)\n'), {'X1', 'X2'})
