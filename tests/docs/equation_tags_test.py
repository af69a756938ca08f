"""A numbered equation is cited by its tag, (TV3) for instance: no two headers give the same tag to two equations."""

import os
import re
import unittest

from documents import repository

FOLDERS = ('kernels', 'gp', 'vision', 'tools', 'bench')
# At the end of a line of comment, behind what it names.
DEFINED = re.compile(r'^\s*//.*\S {2,}\(([A-Z]{1,3}\d{1,2})\)$', re.MULTILINE)
# Tags that several headers of vision/ still give. A tag leaves this list when it is one header's own.
SHARED = {'D1', 'L1', 'M1', 'M2', 'P1', 'R1', 'R2', 'S1', 'S2'}


def tags(text):
    return set(DEFINED.findall(text))


class EquationTags(unittest.TestCase):
    def test_have_one_meaning(self):
        root = repository()
        headers = {}
        for folder in FOLDERS:
            for path, _, names in os.walk(os.path.join(root, folder)):
                for name in names:
                    if name.endswith('.h'):
                        with open(os.path.join(path, name)) as text:
                            for tag in tags(text.read()):
                                headers.setdefault(tag, []).append(os.path.relpath(os.path.join(path, name), root))
        self.assertGreater(len(headers), 50)
        twice = {tag: sorted(names) for tag, names in headers.items() if len(names) > 1}
        self.assertEqual({tag: names for tag, names in twice.items() if tag not in SHARED}, {})
        self.assertEqual(SHARED - set(twice), set())

    def test_would_notice(self):
        self.assertEqual(tags('//   a = b   (X1)\n// as (X2) says\n// of (X3)\n'), {'X1'})


if __name__ == '__main__':
    unittest.main()
