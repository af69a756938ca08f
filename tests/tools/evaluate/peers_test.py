"""egosieve-eval against the field's own programs, each skipped where it is not installed:

    python3 -m venv --system-site-packages P && P/bin/pip install trackeval evo pycocotools
    P/bin/python tests/tools/evaluate/peers_test.py
"""

import importlib
import os
import sys
import unittest
from pathlib import Path

import numpy as np

sys.path[:0] = [str(Path(__file__).parent), os.path.abspath('tools')]

import drive  # noqa: E402
from evaluate import identity, trajectory  # noqa: E402


def peer(name):
    try:
        return importlib.import_module(name)
    except ImportError:
        raise unittest.SkipTest(f'there is no {name.partition(".")[0]}') from None


class Peers(unittest.TestCase):
    def frames(self):
        """(truth, prediction) by number: near, late, with a false object and a changing number."""
        for k in range(drive.FRAMES):
            truth = drive.ids_of(k).astype(int)
            predicted = np.roll(truth, 2, axis=1)
            predicted[(predicted == 2) & (k > 3)] = 4
            predicted[50:54, 2:30 + k] = 7
            yield truth, predicted if k else np.zeros_like(predicted)

    def data(self):
        """As TrackEval wants it."""
        own, data = identity.Identity(1), {'gt_ids': [], 'tracker_ids': [], 'similarity_scores': []}
        for truth, predicted in self.frames():
            own.add(truth, predicted, truth < 0)
        for i, j, similarity in own.frames:
            data['gt_ids'].append(i)
            data['tracker_ids'].append(j)
            data['similarity_scores'].append(similarity)
        data |= {'num_gt_ids': len(own.truth), 'num_tracker_ids': len(own.predicted),
                 'num_gt_dets': sum(map(len, data['gt_ids'])),
                 'num_tracker_dets': sum(map(len, data['tracker_ids'])),
                 'num_timesteps': drive.FRAMES}
        return own.score(), data

    def test_trackeval(self):
        metrics = peer('trackeval.metrics')
        own, data = self.data()
        hota = metrics.HOTA().eval_sequence(data)
        self.assertAlmostEqual(own['hota'], hota['HOTA'].mean(), 9)
        self.assertAlmostEqual(own['detection'], hota['DetA'].mean(), 9)
        self.assertAlmostEqual(own['association'], hota['AssA'].mean(), 9)
        idf1 = metrics.Identity({'PRINT_CONFIG': False}).eval_sequence(data)['IDF1']
        self.assertAlmostEqual(own['idf1'], idf1, 9)
        self.assertTrue(0.3 < own['hota'] < 0.9)  # not a case that any measure gets right

    def test_pycocotools(self):
        mask = peer('pycocotools.mask')
        own = identity.Identity(1)
        for truth, predicted in self.frames():
            own.add(truth, predicted, truth < 0)
            encoded = [[mask.encode(np.asfortranarray((image == n).astype(np.uint8)))
                        for n in np.unique(image[image > 0])] for image in (truth, predicted)]
            if all(encoded):
                ious = mask.iou(*encoded, [False] * len(encoded[1]))
                np.testing.assert_allclose(own.frames[-1][2], ious, atol=1e-12)

    def test_evo(self):
        metrics, paths = peer('evo.core.metrics'), peer('evo.core.trajectory')
        rng = np.random.RandomState(1)

        def poses(noise):
            """A walk, by frame."""
            walk, at, turn = {}, np.zeros(3), np.eye(3)
            for k in range(31):
                walk[k] = turn, at
                step = 0.02 * np.array([np.sin(k), 1, np.cos(k)]) + noise * rng.randn(3)
                turn = turn @ trajectory.Rotation.from_rotvec(step).as_matrix()
                at = at + turn @ np.array([0.0, 0.1, 0.5])
            return walk

        truth, estimate = poses(0.0), poses(0.004)

        def path(walk):
            matrices = [np.vstack([np.column_stack(pose), [0, 0, 0, 1]]) for pose in walk.values()]
            return paths.PosePath3D(poses_se3=matrices)

        own = trajectory.compare(estimate, truth, 10)
        for name, delta in (('rotation_degrees_per_second', 10),
                            ('rotation_neighbours_degrees_per_second', 1)):
            error = metrics.RPE(metrics.PoseRelation.rotation_angle_deg, delta,
                                metrics.Unit.frames, all_pairs=True)
            error.process_data((path(truth), path(estimate)))
            self.assertAlmostEqual(own[name], np.median(error.error) / (delta / 10), 5)


if __name__ == '__main__':
    unittest.main()
