"""The documents' commands and those of --help, one after the other, on a small synthetic drive.

They name files of their reader's: my.mp4, images, videos, drives.toml and so on. They are made here. What is not run
stands in NOT_RUN with its reason; commands_test.py reads its flags.
"""

import json
import os
import re
import shutil
import subprocess
import tempfile
import unittest

from documents import code_lines, documents, read, repository

PROGRAM = os.path.abspath('tools/egosieve')
EVALUATION = os.path.abspath('tools/evaluate/egosieve-eval')
GUIDES = ('README.md', 'docs/drives.md', 'docs/masks.md', 'docs/masks-recipes.md', 'docs/questions.md', 'docs/scaling.md')
# How a line of a document that is a command begins.
COMMAND = re.compile(r'(\./run|egosieve|bazel|colcon|ros2|colmap|ns-train|tests/\S+|bench/\S+|grep|awk|ffmpeg|cmake|cc|cp|python|for d|export|P=\S+|PYTHONPATH=\S+) ?')
# By words of theirs.
NOT_RUN = {
    'slurm': 'needs a cluster: tests/tools/batch/slurm_test.cc submits to a simulated one',
    'JOB_COMPLETION_INDEX': 'needs a cluster of Kubernetes',
    'AWS_BATCH_JOB_ARRAY_INDEX': 'needs an account',
    'out/live': 'needs a camera: tests/tools/segment/stream_test.cc sends streams',
    'out/bag': 'needs a recording of ROS, and a package from the network',
    './run view': 'needs a package from the network: tests/tools/view reads what it writes',
    'colmap feature_extractor': 'needs COLMAP: bench/colmap runs it',
    'faces/0': "needs FFmpeg's program",
    'ns-train': 'needs nerfstudio and a GPU',
    'python train.py': "a program of Gaussian splatting's authors; needs a GPU",
    'shared/data': 'needs data outside the repository; minutes to hours',
    './run bench': 'builds the benchmarks; minutes to hours',
    'bench/drive/': 'benchmarks; minutes to hours',
    'bench/peers/': 'benchmarks; minutes to hours',
    './run demo': 'builds the program, minutes: tests/run/demo_test.sh runs the script',
    './run test': 'builds and runs this test: tests/run/test_count_test.sh runs the script',
    './run setup': 'installs as root, from the network: tests/run/setup_test.sh runs the script',
    './run install': 'builds the program again: tests/tools/embed/install installs it',
    './run wheel': 'builds for other machines, with packages from the network',
    './run tune': 'minutes: tests/tools/tune tunes small cases',
    'bazel ': 'builds tests',
    'tests/mutation/mutate.py': 'builds the program for each mutant; hours',
    './run evaluate folds': 'needs suites of several clips: tests/tools/evaluate has folds',
    'tests/vision/strangers/score.py': 'needs data outside the repository',
    'egosieve-eval RUN': 'needs data outside the repository',
    'P=$HOME': 'the examples: tests/tools/embed/install builds and runs them',
    'cmake -S cpp': 'the same',
    'colcon build': 'needs ROS 2: tests/tools/embed/ros2 builds and runs the node against a stub',
    'ros2 run': 'the same',
    'export PKG_CONFIG_PATH': 'the same',
    'cc -std=c99 c/': 'the same',
    'PYTHONPATH=': 'the same',
    '--device=gpu': 'needs a GPU',
}
FRAMES = 6
# What is of long drives, for one of FRAMES.
SHORTER = {'--task=K': '--task=0', '--to=9999': '--to=3', '--from=9990 --to=19999': '--from=2 --to=4', '--from=19990': '--from=3',
           '--from=9980': '--from=2', '--from=300 --max_frames=240': '--from=2 --max_frames=3', '000049': '000005', '--seed=3 ': '--frames=2 '}
# What a recipe shows that is refused, by its exit code 2.
REFUSED = '--out=data/images --overwrite'
# What has been made before an example of --help or a recipe, by its words.
DRIVE = 'egosieve segment drive.mp4 --out=out/drive'
BEFORE = {
    'egosieve refine': DRIVE,
    'egosieve render': DRIVE,
    'egosieve report': DRIVE,
    'egosieve masks out/masks.run': 'egosieve masks images --for=colmap --out=out/masks',
    'egosieve points': 'egosieve masks images --for=colmap --out=masks',
    'egosieve masks masks.run': 'egosieve masks images --for=colmap --dilate=10 --out=masks; rm -r masks',
    '--frames=images': 'rm -r images',
    'cp data': 'mkdir masked',
}


def is_run(line):
    return not any(word in line for word in NOT_RUN)


def shorter(line):
    if line.endswith(REFUSED):
        line += ' && exit 1 || [ $? = 2 ]'
    for words, replacement in SHORTER.items():
        line = line.replace(words, replacement)
    return line


def before(line):
    return next((made + '; ' for words, made in BEFORE.items() if words in line), '')


def examples(name):
    """The examples of a command's help."""
    text = subprocess.run([PROGRAM, *name.split(), '--help'], capture_output=True, text=True, check=True).stdout
    lines = [line.strip() for line in text.partition('\nExample:')[2].split('\n')]
    return [line for line in lines if line.startswith('egosieve ')]


def commands():
    """The names that the program's help lists."""
    listed = subprocess.run([PROGRAM, '--help'], capture_output=True, text=True, check=True).stdout
    return re.findall(r'^  (\w+) {2,}', listed.partition('Commands:')[2].partition('\n\n')[0], re.MULTILINE)


def call(folder, line):
    environment = dict(os.environ, PATH=f'{folder}/bin:' + os.environ['PATH'], ASAN_OPTIONS='detect_leaks=0')
    done = subprocess.run(['bash', '-ec', line + '\nwait'], cwd=folder, env=environment, capture_output=True, text=True, check=False)
    return f'{line}: exit code {done.returncode}: {done.stderr[-300:]}' if done.returncode else ''


def write_model(folder, camera, names):
    """COLMAP's, without points."""
    os.makedirs(folder)
    texts = {'cameras': f'1 {camera}\n', 'images': ''.join(f'{k + 1} 1 0 0 0 0 0 0 1 {name}\n\n' for k, name in enumerate(names)), 'points3D': ''}
    for name, text in texts.items():
        with open(f'{folder}/{name}.txt', 'w') as out:
            out.write(text)


def readers_files(folder):
    """What the guides take for the reader's own."""
    size = f'--frames={FRAMES} --width=256 --height=144 --out=made'
    faults = call(folder, f'./run synthesize --scenario=crossing {size} && ./run synthesize --scenario=crossing --video {size}_video')
    if faults:
        raise AssertionError(faults)
    shutil.copy(f'{folder}/made_video/video.mp4', f'{folder}/my.mp4')
    shutil.copytree(f'{folder}/made/frames', f'{folder}/images')
    shutil.copytree(f'{folder}/made/masks', f'{folder}/masks')
    shutil.copy(f'{folder}/made/masks/000000.png', f'{folder}/bonnet.png')
    shutil.copytree(f'{folder}/made/frames', f'{folder}/data/images')
    with open(f'{folder}/data/transforms.json', 'w') as out:
        names = sorted(os.listdir(f'{folder}/images'))
        json.dump({'frames': [{'file_path': f'images/{name}', 'transform_matrix': [[1.0 * (i == j) for j in range(4)] for i in range(4)]}
                              for name in names]}, out)
    write_model(f'{folder}/sparse/0', 'SIMPLE_RADIAL 256 144 200 128 72 -0.05', names)
    write_model(f'{folder}/dense/sparse', 'PINHOLE 256 144 200 200 128 72', names)
    shutil.copytree(f'{folder}/images', f'{folder}/dense/images')
    os.mkdir(f'{folder}/videos')
    shutil.copy(f'{folder}/my.mp4', f'{folder}/videos/a.mp4')
    shutil.copy(f'{folder}/my.mp4', f'{folder}/a.mp4')
    shutil.copy(f'{folder}/my.mp4', f'{folder}/drive.mp4')
    shutil.copytree(f'{folder}/images', f'{folder}/frames')
    for drive in ('drive', 'clip', 'sequences/one', 'streets/one'):
        shutil.copytree(f'{folder}/made', f'{folder}/{drive}')
    with open(f'{folder}/clip/tracks.csv', 'w') as out:
        out.write('track,label,frame,x,y\n' + ''.join(f'{k},{k},{frame},{80 * k - 40},70\n' for k in (1, 2) for frame in range(1, FRAMES)))
    with open(f'{folder}/boxes.csv', 'w') as out:
        out.write('frame,id,type,x1,y1,x2,y2,moving\n3,1,Car,10,60,60,100,1\n')
    with open(f'{folder}/drives.toml', 'w') as out:
        out.write(manifest(read(repository(), 'docs/drives.md')))


def manifest(guide):
    lines = code_lines(guide)
    begin = lines.index('[defaults]')
    return '\n'.join(lines[begin:begin + 8]) + '\n'


class Guides(unittest.TestCase):
    maxDiff = None

    def setUp(self):
        self.folder = tempfile.mkdtemp(dir=os.environ.get('TEST_TMPDIR'))
        made = f'{self.folder}/made'
        os.makedirs(f'{made}/bin')
        with open(f'{made}/run', 'w') as out:
            out.write(f'#!/bin/bash\nexport EGOSIEVE_PROGRAM="{PROGRAM}"\n[ "$1" != evaluate ] || exec "{EVALUATION}" "${{@:2}}"\n'
                      f'exec "{PROGRAM}" "$@"\n')
        os.chmod(f'{made}/run', 0o755)
        os.symlink(PROGRAM, f'{made}/bin/egosieve')
        readers_files(made)

    def tearDown(self):
        shutil.rmtree(self.folder)

    def fresh(self, *without):
        """A copy of the reader's files."""
        folder = tempfile.mkdtemp(dir=self.folder)
        shutil.copytree(f'{self.folder}/made', folder, symlinks=True, dirs_exist_ok=True)
        for name in without:
            shutil.rmtree(f'{folder}/{name}')
        return folder

    def check(self, name, more_than=4, first='true'):
        """The commands of a guide, one after the other in one folder."""
        lines = [line for line in code_lines(read(repository(), name)) if re.match(r'(\./run|egosieve|grep) ', line) and is_run(line)]
        self.assertGreater(len(lines), more_than)
        folder = self.fresh('frames')
        self.assertEqual(call(folder, first), '')
        for line in lines:
            # grep says by 1 that it found nothing.
            line = f'{line} || [ $? = 1 ]' if line.startswith('grep ') else line
            self.assertEqual(call(folder, before(line) + shorter(line)), '', name)

    def check_each(self, lines):
        """Commands that do not belong together: each in a folder of its own."""
        faults = []
        for line in lines:
            folder = self.fresh('masks')
            faults += [fault for fault in [call(folder, before(line) + shorter(line))] if fault]
            shutil.rmtree(folder)
        self.assertEqual(faults, [])

    def test_readme(self):
        self.check('README.md', more_than=1)

    def test_questions(self):
        self.check('docs/questions.md', first='./run segment my.mp4 --out=out/my')

    def test_drives(self):
        self.check('docs/drives.md')

    def test_masks(self):
        self.check('docs/masks.md')

    def test_scaling(self):
        self.check('docs/scaling.md')

    def test_recipes(self):
        text = read(repository(), 'docs/masks-recipes.md').replace('&\n    egosieve', '& egosieve')
        lines = [line for line in code_lines(text) if re.match('(egosieve|cp) ', line) and is_run(line)]
        self.assertGreater(len(lines), 10)
        self.check_each(lines)

    def test_help(self):
        names = [name for name in commands() if name != 'merge']
        lines = [line for name in names for line in examples(name) if is_run(line)]
        self.assertGreater(len(lines), 18)
        self.check_each([*lines, '\n'.join(examples('merge'))])


class NotRun(unittest.TestCase):
    maxDiff = None

    def test_has_a_reason(self):
        root = repository()
        lines = [(name, line) for name in documents(root) for line in code_lines(read(root, name)) if COMMAND.match(line)]
        lines = [(name, line) for name, line in lines if not name.startswith('tools/embed/reference/')]
        self.assertGreater(len(lines), 100)
        self.assertEqual([entry for entry in lines if entry[0] not in GUIDES and is_run(entry[1])], [])
        shown = '\n'.join(line for _, line in lines) + '\n'.join(examples('devices'))
        self.assertEqual([word for word in NOT_RUN if word not in shown], [])
