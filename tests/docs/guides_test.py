"""The guides' commands, one after the other, on a small synthetic drive.

A guide names files of its reader's: my.mp4, images, videos, drives.toml and so on. They are made here, and what needs
a cluster or another program is left to commands_test.py.
"""

import json
import os
import shutil
import subprocess
import tempfile
import unittest

from documents import code_lines, read, repository

PROGRAM = os.path.abspath('tools/egosieve')
ELSEWHERE = ('slurm', 'out/live', 'colmap feature_extractor', 'ns-train', 'out/bag', './run bench', './run demo', './run test', './run install', 'awk', 'FIRST', 'shared/data')
FRAMES = 6


def call(folder, line):
    environment = dict(os.environ, PATH=f'{folder}/bin:' + os.environ['PATH'], ASAN_OPTIONS='detect_leaks=0')
    done = subprocess.run(['bash', '-ec', line + '\nwait'], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    return f'{line}: exit code {done.returncode}: {done.stderr[-300:]}' if done.returncode else ''


def readers_files(folder):
    """What the guides take for the reader's own."""
    size = f'--frames={FRAMES} --width=256 --height=144 --out=made'
    faults = call(folder, f'./run synthesize --scenario=crossing {size} && ./run synthesize --scenario=crossing --video {size}_video')
    if faults:
        raise AssertionError(faults)
    shutil.copy(f'{folder}/made_video/video.mp4', f'{folder}/my.mp4')
    shutil.copytree(f'{folder}/made/frames', f'{folder}/images')
    shutil.copytree(f'{folder}/made/masks', f'{folder}/masks')
    shutil.copytree(f'{folder}/made/frames', f'{folder}/data/images')
    with open(f'{folder}/data/transforms.json', 'w') as out:
        names = sorted(os.listdir(f'{folder}/images'))
        json.dump({'frames': [{'file_path': f'images/{name}', 'transform_matrix': [[1.0 * (i == j) for j in range(4)] for i in range(4)]}
                              for name in names]}, out)
    os.mkdir(f'{folder}/videos')
    shutil.copy(f'{folder}/my.mp4', f'{folder}/videos/a.mp4')
    shutil.copy(f'{folder}/my.mp4', f'{folder}/a.mp4')
    with open(f'{folder}/boxes.csv', 'w') as out:
        out.write('frame,id,type,x1,y1,x2,y2,moving\n3,1,Car,10,60,60,100,1\n')
    with open(f'{folder}/drives.toml', 'w') as out:
        out.write(manifest(read(repository(), 'docs/drives.md')))


def manifest(guide):
    lines = code_lines(guide)
    begin = lines.index('[defaults]')
    return '\n'.join(lines[begin:begin + 8]) + '\n'


class Guides(unittest.TestCase):
    def check(self, name, more_than=4):
        root = repository()
        with tempfile.TemporaryDirectory(dir=os.environ.get('TEST_TMPDIR')) as folder:
            with open(f'{folder}/run', 'w') as out:
                out.write(f'#!/bin/bash\nexec "{PROGRAM}" "$@"\n')
            os.chmod(f'{folder}/run', 0o755)
            os.mkdir(f'{folder}/bin')
            os.symlink(PROGRAM, f'{folder}/bin/egosieve')
            readers_files(folder)
            lines = [line for line in code_lines(read(root, name))
                     if line.startswith('./run ') and not any(word in line for word in ELSEWHERE)]
            self.assertGreater(len(lines), more_than)
            for line in lines:
                self.assertEqual(call(folder, line), '', name)

    def test_readme(self):
        self.check('README.md')

    def test_questions(self):
        self.check('docs/questions.md', more_than=2)

    def test_drives(self):
        self.check('docs/drives.md')

    def test_masks(self):
        self.check('docs/masks.md')


if __name__ == '__main__':
    unittest.main()
