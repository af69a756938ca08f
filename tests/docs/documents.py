"""The repository's documents and the commands that they show."""

import os
import re
import shlex


def repository():
    """The root of the working tree, which the test reads as it is: documents name any of its files."""
    return os.path.dirname(os.path.realpath('run'))


def files_below(root, folders):
    """Paths of all files of these folders, from the root."""
    for folder in folders:
        for path, _, names in os.walk(os.path.join(root, folder)):
            yield from (os.path.relpath(os.path.join(path, name), root) for name in names)


def documents(root):
    """Paths of all documents, from the root."""
    found = os.listdir(root) + list(files_below(root, ('bench', 'docs', 'tests', 'tools')))
    return sorted(name for name in found if name.endswith('.md'))


def read(root, name):
    with open(os.path.join(root, name)) as text:
        return text.read()


def code_lines(text):
    """Indented lines, which Markdown shows as code."""
    return [line.strip() for line in text.split('\n') if line.startswith('    ') and line.strip()]


def inline_code(text):
    return re.findall(r'`([^`\n]+)`', '\n'.join(line for line in text.split('\n') if not line.startswith('    ')))


def commands(line):
    """The commands of a line of shell, as lists of words."""
    line = re.sub(r'\$\(\((.*?)\)\)', '1', line)
    line = re.sub(r'<\((.*?)\)', '', line)
    words = shlex.shlex(line.replace('{}', '1'), posix=True, punctuation_chars='&|;')
    words.whitespace_split = True
    split = [[]]
    for word in words:
        if word in ('&&', '||', '|', '&', ';'):
            split.append([])
        else:
            split[-1].append(word)
    return [command for command in split if command]
