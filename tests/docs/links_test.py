"""Links, anchors and paths of the documents lead somewhere."""

import os
import re
import unittest

from documents import documents, files_below, inline_code, read, repository

LINK = re.compile(r'\[[^\]]*\]\(([^)\s]+)\)')
SOURCE = re.compile(r'[\w*-]+(/[\w.*-]+)*\.(h|cc|cl|py|sh|bzl)')
FOLDERS = ('bench', 'docs', 'gp', 'kernels', 'tests', 'third_party', 'tools', 'vision')


def anchors(text):
    """The anchors of a document's headings, as mkdocs and GitHub make them."""
    headings = re.findall(r'^#+ +(.*)$', text, re.MULTILINE)
    return {re.sub(r'\s', '-', re.sub(r'[^\w\s-]', '', heading).strip().lower()) for heading in headings}


def broken_links(root, name, text):
    broken = []
    for link in LINK.findall(text):
        if re.match(r'[a-z]+:', link):
            continue
        path, _, anchor = link.partition('#')
        target = os.path.normpath(os.path.join(os.path.dirname(name), path)) if path else name
        if not os.path.exists(os.path.join(root, target)):
            broken.append(f'{name}: {link}: no such file')
        elif anchor and anchor not in anchors(text if target == name else read(root, target)):
            broken.append(f'{name}: {link}: no such heading')
    return broken


def sources(root):
    """The names of all sources, with and without their folders."""
    return {name for path in files_below(root, FOLDERS) for name in (path, os.path.basename(path))}


def broken_paths(root, name, text, known):
    """Of what stands in backticks: sources, and folders below `FOLDERS`, that are not there."""
    broken = []
    for code in inline_code(text):
        if '*' in code or '<' in code:
            continue
        is_source = SOURCE.fullmatch(code) and code not in known
        is_folder = (re.fullmatch(r'[a-z_]+(/[\w.-]+)+', code) and code.split('/')[0] in FOLDERS
                     and not os.path.exists(os.path.join(root, code))
                     and not any(path.startswith(code + '.') for path in known))
        if is_source or is_folder:
            broken.append(f'{name}: {code}: no such file')
    return broken


class Links(unittest.TestCase):
    def test_lead_somewhere(self):
        root = repository()
        known = sources(root)
        broken = []
        self.assertIn('docs/concepts.md', documents(root))
        for name in documents(root):
            text = read(root, name)
            broken += broken_links(root, name, text)
            # Results of a mutation run name the sources of their day.
            if not name.startswith('tests/mutation/'):
                broken += broken_paths(root, name, text, known)
        self.assertEqual(broken, [])

    def test_would_notice(self):
        root = repository()
        text = '# One\n[a](none.md) [b](#two) [c](#one) [d](docs/results.md#none) `vision/none` `none.h` `vision/frame`'
        self.assertEqual(len(broken_links(root, 'README.md', text)), 3)
        self.assertEqual(len(broken_paths(root, 'README.md', text, sources(root))), 2)
