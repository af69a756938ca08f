"""tools/evaluate/compare.py on a small synthetic drive, and its location prior against the program's."""

import csv
import importlib.util
import json
import os
import subprocess
import tempfile
import unittest

PROGRAM = os.path.abspath('tools/egosieve')
SCRIPT = os.path.abspath('tools/evaluate/compare.py')
PACKAGES = ('cv2', 'scipy', 'sklearn')
FRAMES = 8  # with fewer than six pairs of pictures no direction of travel is told, hence no ground


def call(*words):
    return subprocess.run(list(words), capture_output=True, text=True, check=False)


@unittest.skipUnless(all(map(importlib.util.find_spec, PACKAGES)), 'needs python3-sklearn and python3-opencv')
class Compare(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp(dir=os.environ.get('TEST_TMPDIR'))
        cls.suite, cls.out = f'{cls.folder}/suite', f'{cls.folder}/out'
        made = call(PROGRAM, 'synthesize', '--scenario=street', f'--frames={FRAMES}', '--width=320', '--height=180', f'--out={cls.suite}/one')
        assert made.returncode == 0, made.stderr
        cls.done = cls.compare(cls.suite, f'--out={cls.out}')

    @classmethod
    def compare(cls, *words):
        return call('/usr/bin/python3', SCRIPT, *words, f'--program={PROGRAM}', '--segment_flags=--budget=300')

    def test_every_method_has_a_row_per_frame(self):
        self.assertEqual(self.done.returncode, 0, self.done.stderr)
        with open(f'{self.out}/compare.json') as file:
            table = {entry['method']: entry for entry in json.load(file)}
        self.assertEqual(len(table), 9)
        with open(f'{self.out}/compare.csv') as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 9 * FRAMES)
        for method, entry in table.items():
            own = [float(row['auc']) for row in rows if row['method'] == method and row['auc'] != 'nan']
            self.assertAlmostEqual(entry['auc'], sum(own) / len(own), 12)
            self.assertGreater(entry['milliseconds'], 0)
        for method in ('arcsine', 'svm', 'forest', 'labels'):
            self.assertGreater(table[method]['auc'], 0.75, method)
        mean, least, most = table['ransac']['arcsine_leads_in_auc']
        self.assertAlmostEqual(mean, table['arcsine']['auc'] - table['ransac']['auc'], 12)
        self.assertTrue(least <= mean <= most)

    def test_the_prior_is_the_programs(self):
        import cv2  # pylint: disable=import-outside-toplevel
        import numpy as np  # pylint: disable=import-outside-toplevel
        spec = importlib.util.spec_from_file_location('compare', SCRIPT)
        compare = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(compare)
        for weight in ('0', '0.5'):
            done = call(PROGRAM, 'segment', f'{self.suite}/one/frames', f'--out={self.folder}/{weight}', f'--set=location_prior={weight}',
                        '--budget=200', f'--set=dump_features={self.folder}/features')
            self.assertEqual(done.returncode, 0, done.stderr)
        prior, changed = compare.LocationPrior(0.5), 0.0
        for index in range(FRAMES):
            without, with_prior = (cv2.imread(f'{self.folder}/{w}/grid/{index:06d}.prob.png', cv2.IMREAD_UNCHANGED).ravel() / 65535
                                   for w in ('0', '0.5'))
            dump = compare.Dump(f'{self.folder}/features/{index:06d}.npz')
            prior.learn(dump)
            # Maps are written in steps of 1/65535, which the prior's factor of the odds enlarges.
            np.testing.assert_allclose(prior.apply(without, dump), with_prior, atol=2e-4)
            changed = max(changed, np.abs(without - with_prior).max())
        self.assertGreater(changed, 0.05)

    def test_refuses_what_cannot_be(self):
        for words, why in ((['--methods=magic'], "no method 'magic'"), (['--methods=svm'], 'needs one of arcsine')):
            done = self.compare(self.suite, f'--out={self.folder}/no', *words)
            self.assertEqual(done.returncode, 2)
            self.assertIn(why, done.stderr)
        os.makedirs(f'{self.folder}/empty', exist_ok=True)
        self.assertIn('no sequence', self.compare(f'{self.folder}/empty', f'--out={self.folder}/no').stderr)
