"""Each measure of egosieve-eval and each form of truth on a case by hand."""

import os
import sys
import unittest
from pathlib import Path
from types import SimpleNamespace

import numpy as np

sys.path[:0] = [str(Path(__file__).parent), os.path.abspath('tools')]

import drive  # noqa: E402
from evaluate import boundary, box_scores, csv_truth, doubt, identity, objects  # noqa: E402
from evaluate import mask_scores, pixel_scores, stability, trajectory  # noqa: E402
from evaluate import truth as truths, uncertainty  # noqa: E402
from evaluate.files import InputError, UsageError  # noqa: E402
from evaluate.run_folder import Grid  # noqa: E402


class Doubt(unittest.TestCase):
    def test_ranks_bad_masks_by_the_expected_overlap(self):
        # Bad 0.35, 0.45; others 0.45, 0.6, 0.2: of six pairs three are won and one is tied.
        frames = [(0.1, 0.35), (0.29, 0.45), (0.3, 0.45), (0.9, 0.6), (0.5, 0.2), (0.7, None)]
        line = doubt.describe(frames)
        self.assertIn('2 of 5 frames have a mask J below 0.3', line)
        self.assertIn('AUC of 0.583: below 0.3 0.000 of these and 0.333 of the others; '
                      'below 0.4 0.500 of these and 0.333 of the others; '
                      'below 0.5 1.000 of these and 0.667 of the others', line)
        self.assertEqual(doubt.describe(frames[2:]), '')
        self.assertEqual(doubt.describe([]), '')


class Pixels(drive.FolderCase):
    def test_ranking_with_ties(self):
        # Positives 10, 20; negatives 10, 5: of four pairs three are won, one is tied.
        counts = pixel_scores.Counts([10, 20, 10, 5], [True, True, False, False])
        self.assertAlmostEqual(counts.auc(), 3.5 / 4)
        self.assertAlmostEqual(counts.average_precision(), 0.5 * 1 + 0.5 * 2 / 3)
        at = counts.at(10)
        self.assertEqual((at['iou'], at['recall'], at['precision']), (2 / 3, 1.0, 2 / 3))
        self.assertEqual(at['false_positive_rate'], 0.5)
        self.assertEqual(counts.best_threshold(), 6)  # the lowest of equal ones
        curve = counts.curve()
        self.assertEqual(curve[0][1:], (0, 0, 1))
        self.assertEqual(curve[-1][1:], (1, 1, 0.5))

    def test_one_class_has_no_auc(self):
        counts = pixel_scores.Counts([1, 2], [False, False])
        self.assertIsNone(counts.auc())
        self.assertIsNone(counts.best_threshold())
        self.assertEqual(counts.curve(), [])

    def test_counts_add(self):
        scores = np.array([3, 9, 9, 1, 65535, 0])
        positive = np.array([0, 1, 0, 0, 1, 1], bool)
        parts = pixel_scores.Counts(scores[:3], positive[:3])
        parts.add(pixel_scores.Counts(scores[3:], positive[3:]))
        self.assertEqual(parts.auc(), pixel_scores.Counts(scores, positive).auc())

    def test_calibration(self):
        # Stated 0.2 with a quarter of positives, stated 1 with all.
        low, high = pixel_scores.score_of(0.2), 65535
        calibration = pixel_scores.Counts([low] * 4 + [high] * 4,
                                          [True, False, False, False] + [True] * 4).calibration(5)
        self.assertAlmostEqual(calibration['brier'], (0.8**2 + 3 * 0.2**2) / 8)
        self.assertAlmostEqual(calibration['expected_calibration_error'], 0.5 * 0.05)
        self.assertAlmostEqual(calibration['log_loss'], -(np.log(0.2) + 3 * np.log(0.8)) / 8, 4)
        self.assertEqual([row['pixels'] for row in calibration['reliability']], [0, 4, 0, 0, 4])

    def test_sparsification(self):
        # Errors 2, 1 by deviations 1, 2: the wrong order. S is 2/1.5 after half.
        wrong = uncertainty.Uncertainty(32768)
        wrong.add(np.array([2, 1]), np.array([1, 2]), np.array([False, False]))
        found = wrong.to_json(2)
        self.assertEqual(found['sparsification'][1], [0.5, 2 / 1.5, 1 / 1.5])
        # Ranked: integral_0^1 (3 - x) / (2 - x) dx = 1 + log 2, then 2; oracle: (3 - 2x) / (2 - x).
        ranked, oracle = 1 + np.log(2) + 2, 2 - np.log(2) + 1
        self.assertAlmostEqual(found['area_under_sparsification_error'], (ranked - oracle) / 2 / 1.5)
        self.assertIsNone(found['error_auc'])  # none is wrong at the threshold

    def test_error_auc(self):
        one = uncertainty.Uncertainty(100)
        one.add(np.array([200, 0, 50]), np.array([9, 1, 5]), np.array([False, False, True]))
        self.assertEqual(one.to_json()['error_auc'], 1.0)


class Outlines(drive.FolderCase):
    def square(self, x, size=12):
        mask = np.zeros((60, 80), bool)
        mask[20:20 + size, x:x + size] = True
        return mask

    def test_boundary(self):
        # The bound is ceil(0.008 * 100) = 1 pixel.
        self.assertEqual(boundary.boundary_f(self.square(20), self.square(20)), 1.0)
        self.assertEqual(boundary.boundary_f(self.square(21), self.square(20)), 1.0)
        self.assertLess(boundary.boundary_f(self.square(24), self.square(20)), 0.7)
        nothing = np.zeros((60, 80), bool)
        self.assertEqual(boundary.boundary_f(nothing, nothing), 1.0)
        self.assertEqual(boundary.boundary_f(nothing, self.square(20)), 0.0)

    def test_stability(self):
        def change(a, b):
            return stability.outline_change(*map(stability.describe_outline, (a, b)))

        self.assertAlmostEqual(change(self.square(10), self.square(40)), 0.0)
        torn = self.square(10, 30)
        torn[25:30, 10:30] = False
        self.assertGreater(change(self.square(10, 30), torn), 0.03)
        self.assertIsNone(change(self.square(10), np.zeros((60, 80), bool)))

    def test_only_neighbours_in_time_are_compared(self):
        scores = mask_scores.MaskScores(SimpleNamespace(object_area=1, object_iou=0.5))
        for index in (0, 2, 3):
            mask = self.square(10 + index)
            scores.add(index, mask, np.where(mask, 255, 0).astype(np.uint8))
        self.assertEqual((len(scores.ts), scores.to_json()['j']), (1, 1.0))

    def test_least_path(self):
        cost = np.array([[0, 9, 9], [9, 9, 0], [9, 0, 9]], np.float32)
        # Over the diagonal and over (0, 0), (1, 2), (2, 2): 18.
        path = stability._least_path(cost)
        self.assertEqual(path[0].tolist(), [2, 2])
        self.assertEqual(path[-1].tolist(), [0, 0])
        self.assertEqual(cost[tuple(path.T)].sum(), 18)


class Things(drive.FolderCase):
    def test_a_region_over_two_objects_is_shared(self):
        ids = np.zeros((4, 20), int)
        ids[:, 2:6], ids[:, 10:14] = 5, 6
        predicted = np.zeros_like(ids)
        predicted[:, 2:14] = 1  # both, and the four columns between
        predicted[3, 17:20] = 2  # on nothing
        found, false_objects = objects.score_objects(predicted, ids, ids < 0, 3)
        self.assertEqual([number for number, _ in found], [5, 6])
        self.assertAlmostEqual(sum(16 / iou for _, iou in found), 48)  # all pixels are assigned
        self.assertEqual(false_objects, 1)
        void = np.zeros(ids.shape, bool)
        void[3, 17:20] = True
        self.assertEqual(objects.score_objects(predicted, ids, void, 3)[1], 0)
        self.assertEqual(objects.score_objects(predicted, ids, ids < 0, 17)[0], [])

    def test_objects_of_a_map_need_a_sure_pixel(self):
        scores = np.array([[3, 9, 0, 4, 4], [0, 0, 0, 0, 3]])
        self.assertEqual((objects.objects_of_map(scores, 3, 8) > 0).tolist(),
                         [[True, True, False, False, False], [False] * 5])

    def test_groups(self):
        tally = objects.ObjectTally(0.5)
        car = {'class': 'car', 'relation': 'ahead', 'distance_metres': 30, 'area_pixels': 500}
        tally.add([(1, 0.4), (2, 0.6)], 3, {1: car})
        found = tally.to_json()
        recall = found['object_recall']
        self.assertEqual(recall['all']['recall'], 0.5)
        self.assertEqual(recall['ahead vehicle within 40 m']['recall_at_0.3'], 1.0)
        self.assertEqual(set(recall), {
            'all', 'relation ahead', 'class car', 'size 400-1599', 'distance 20-40 m',
            'ahead within 40 m', 'vehicle within 40 m', 'ahead vehicle within 40 m'})
        self.assertEqual(found['false_objects_per_frame'], 3)

    def test_identity(self):
        """One object in four frames, whose number changes after the third."""
        score = identity.Identity(1)
        real = np.zeros((4, 4), int)
        real[:2] = 1
        for number in (7, 7, 7, 8):
            score.add(real, np.where(real, number, 0), real < 0)
        found = score.score()
        self.assertAlmostEqual(found['idf1'], 2 * 3 / 8)
        self.assertAlmostEqual(found['detection'], 1.0)
        # Pairs with 7: 3 / (4 + 3 - 3) each, the pair with 8: 1 / (4 + 1 - 1).
        self.assertAlmostEqual(found['association'], (3 * 3 / 4 + 1 / 4) / 4)
        self.assertAlmostEqual(found['hota'], np.sqrt(found['association']))
        self.assertIsNone(identity.Identity(1).score())

    def test_identity_leaves_out_small_and_void(self):
        score = identity.Identity(4)
        real = np.zeros((4, 6), int)
        real[0, :2] = 1  # too small
        predicted = real.copy()
        predicted[3] = 2
        void = np.zeros(real.shape, bool)
        void[3, :4] = True
        score.add(real, predicted, void)
        self.assertIsNone(score.score())

    def test_assignment(self):
        rows, columns = identity.assign_largest(np.array([[5.0, 4.0, 0], [4, 0, 0], [0, 0, 0]]))
        self.assertEqual(list(zip(rows, columns)), [(0, 1), (1, 0)])

    def test_boxes(self):
        grid = Grid(41, 31, 5)
        text = ('frame,id,type,x1,y1,x2,y2,moving,occluded,depth\n'
                '0,1,Car,0,0,10,10,1,0,8\n0,2,Cyclist,20,10,30,20,0,,\n'
                '0,3,Van,30,0,40,10,1,2,\n0,4,Dog,0,20,10,30,1,,\n')
        (self.root / 'boxes.csv').write_text(text)
        scores = box_scores.BoxScores(0.5)
        probability = np.zeros((7, 9), np.uint16)
        probability[:3, :3] = probability[6, 8] = 65535
        scores.add(csv_truth.read_boxes(self.root / 'boxes.csv'), probability, grid)
        json_ = scores.to_json()
        self.assertEqual(json_['kinds'], {
            'moving vehicle': {'0-10 m': {'boxes': 1, 'marked': 1},
                               'all': {'boxes': 1, 'marked': 1}},
            'standing cyclist': {'all': {'boxes': 1, 'marked': 0},
                                 'unknown': {'boxes': 1, 'marked': 0}}})
        self.assertEqual(json_['left_out'], 2)
        # Four boxes of 3 x 3 grid pixels, of which two share a corner.
        self.assertEqual(json_['outside_pixels'], 7 * 9 - (4 * 9 - 1))
        self.assertEqual(json_['outside_marked_share'], 1 / 28)
        self.assertRegex(box_scores.box_table([json_]), r'moving vehicle +1 of 1 1\.00 +1 of 1 1\.00 +-\n')

    def test_mean_in_the_middle(self):
        (self.root / 'boxes.csv').write_text('frame,id,type,x1,y1,x2,y2,moving\n'
                                             '0,1,Car,0,0,10,10,1\n0,2,Car,-90,0,-80,9,1\n')
        inside, outside = csv_truth.read_boxes(self.root / 'boxes.csv').itertuples()
        ramp = np.tile(np.array([0, 30000, 60000], np.uint16), (3, 1))  # 6000 x at pixel x
        self.assertAlmostEqual(box_scores.mean_in_middle(inside, ramp, Grid(11, 11, 5)),
                               6000 * 5 / 65535)
        self.assertIsNone(box_scores.mean_in_middle(outside, ramp, Grid(11, 11, 5)))


class Motion(drive.FolderCase):
    def pose(self, turn, x, z):
        c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
        return np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]), np.array([x, 0, z])

    def test_errors(self):
        truth = {k: self.pose(0, 0, k) for k in range(21)}
        # Turns by 0.1 degrees a frame, and drifts by 45 degrees.
        estimate = {k: self.pose(0.1 * k, 2 * k, 2 * k) for k in range(21)}
        errors = trajectory.compare(estimate, truth, 10)
        self.assertEqual(errors['frames'], 21)
        self.assertAlmostEqual(errors['rotation_degrees_per_second'], 1.0)
        self.assertAlmostEqual(errors['rotation_neighbours_degrees_per_second'], 1.0)
        self.assertEqual(errors['travelling_pairs'], 20)
        # The estimate's own axes turn from the drift by up to 2 degrees.
        self.assertAlmostEqual(errors['direction_degrees'], 45 - 0.95)
        still = {k: self.pose(0, 0, 0) for k in range(21)}
        self.assertEqual(trajectory.compare(still, truth, 10)['direction_degrees'], 90)
        self.assertEqual(trajectory.compare(truth, still, 10)['travelling_pairs'], 0)

    def test_a_span_is_a_second(self):
        truth = {k: self.pose(0, 0, 0) for k in range(11)}
        estimate = {k: self.pose(3 * (k == 10), 0, 0) for k in range(11)}
        errors = trajectory.compare(estimate, truth, 10)
        self.assertAlmostEqual(errors['rotation_degrees_per_second'], 3)  # frames 0 and 10 alone
        self.assertAlmostEqual(errors['rotation_neighbours_degrees_per_second'], 0)

    def test_frames_by_time(self):
        timed = [(0.0, 'a'), (0.104, 'b'), (0.16, 'c')]
        self.assertEqual(trajectory.by_frame(timed, {4: 0.0, 5: 0.1, 6: 0.2}),
                         {4: 'a', 5: 'b', 6: 'c'})
        self.assertEqual(trajectory.by_frame([(0.05, 'a')], {0: 0.0, 1: 0.1}), {})

    def test_focal_length(self):
        self.assertAlmostEqual(trajectory.focal_error_percent(
            {'focal_pixels': 110, 'width': 200}, {'focal_pixels': 50, 'width': 100}), 10)


class Readers(drive.FolderCase):
    def bad(self, reader, text, message, error=InputError):
        (self.root / 'table').write_text(text)
        with self.assertRaisesRegex(error, message):
            reader(self.root / 'table')

    def test_tracks(self):
        header = 'x, y,frame,label,track,more\n'
        (self.root / 't').write_text(header + '1.5, 2,0,1,4,a\n3,4,1,2,5,"b,c"\n')
        points = csv_truth.read_tracks(self.root / 't')
        self.assertEqual(points.dynamic.tolist(), [False, True])
        self.assertEqual(points.x.tolist(), [1.5, 3.0])
        self.bad(csv_truth.read_tracks, header + '1,2,0,1,4,\n', 'both are needed', UsageError)
        self.bad(csv_truth.read_tracks, header + '1,2,0,1,4,\n1,2,0,0,4,\n', 'line 3: label')
        self.bad(csv_truth.read_tracks, header + '1,nan,0,1,4,\n', 'line 2: y is no number')
        self.bad(csv_truth.read_tracks, 'x,y,frame,label\n', 'no field "track"')

    def test_boxes(self):
        header = 'frame,id,type,x1,y1,x2,y2,moving,range\n'
        self.bad(csv_truth.read_boxes, header + '0,1,Car,5,5,5,9,1,\n', 'line 2: the box has no')
        self.bad(csv_truth.read_boxes, header + '0,1,Car,5,5,8,9,2,\n', 'moving is not 0, 1')
        self.bad(csv_truth.read_boxes, header + '0,1,Car,5,5,8,9,1,wide\n', 'range is not')
        self.bad(csv_truth.read_boxes, header + '-1,1,Car,5,5,8,9,1,\n', 'no integer from 0')
        for labels in (Path(__file__).parent / 'labels').glob('*.csv'):
            self.assertGreater(len(csv_truth.read_boxes(labels)), 10, labels)

    def test_distances(self):
        header = 'frame,id,type,x1,y1,x2,y2,moving,depth,range\n'
        rows = ('10,', '39.9,', '40,', ',far', ',')
        (self.root / 'b').write_text(header + ''.join(f'0,1,Bus,0,0,1,1,,{r}\n' for r in rows))
        boxes = csv_truth.read_boxes(self.root / 'b')
        self.assertEqual(boxes.distance.tolist(), ['10-20 m', '20-40 m', '40+ m', 'far', 'unknown'])
        self.assertEqual(set(boxes.kind), {''})

    def masks(self, *names):
        for name in names:
            drive.write_png(self.root / 'm' / name, np.zeros((2, 2), np.uint8))
        return self.root / 'm'

    def test_masks_are_matched(self):
        folder = self.masks('a10.png', 'a9.png')
        way, paths = truths.list_masks(folder, ['a9', 'b', 'a10'])
        self.assertEqual((way, {k: p.stem for k, p in paths.items()}),
                         ('name', {0: 'a9', 2: 'a10'}))
        self.assertEqual(truths.list_masks(folder, ['x', 'y'])[0], 'number')
        self.masks('b.png')
        way, paths = truths.list_masks(folder, ['x', 'y', 'z'])
        self.assertEqual((way, [paths[k].stem for k in range(3)]), ('order', ['a9', 'a10', 'b']))
        with self.assertRaisesRegex(UsageError, '3 masks'):
            truths.list_masks(folder, ['x'])

    def test_colours_of_masks(self):
        colours = np.array([[[0, 0, 0], [128, 128, 128], [128, 0, 0], [0, 0, 1]]], np.uint8)
        drive.write_png(self.root / 'c.png', colours)
        self.assertEqual(truths.read_mask(self.root / 'c.png').tolist(), [[0, 128, 255, 255]])
        drive.write_png(self.root / 'd.png', np.zeros((2, 2), np.uint16))
        with self.assertRaisesRegex(InputError, '8-bit'):
            truths.read_mask(self.root / 'd.png')

    def test_poses(self):
        self.bad(trajectory.read_kitti, '1 2 3\n', 'must have 12 numbers')
        self.bad(trajectory.read_kitti, ' '.join(['0'] * 12), 'no rotation')
        self.bad(trajectory.read_tum, '0 0 0 zero 0 0 0 1\n', 'row 0')
        self.bad(trajectory.read_camera, '{"focal_pixels": 0, "width": 3}', 'positive')
