"""egosieve-eval: the figures of a small drive as they were, suites and cross-validation."""

import contextlib
import io
import json
import os
import sys
import unittest
from pathlib import Path

import numpy as np
import pandas

sys.path[:0] = [str(Path(__file__).parent), os.path.abspath('tools')]

import drive  # noqa: E402
from evaluate import figures, folds, suite, table  # noqa: E402
from evaluate.command import main  # noqa: E402
from evaluate.files import InputError, UsageError  # noqa: E402
from evaluate.run_folder import RunFolder  # noqa: E402
from evaluate.sequences import find_sequences  # noqa: E402

GOLDEN = Path(__file__).parent / 'golden.json'
# What differs, and by how much: scores at points are rounded to 16 bits once, where they were
# rounded to float32 before; and 0.60 is 0.6, where 12 * 0.05 was a little more, so that scores of
# just 0.6 count.
ONE_SCORE = 1.6e-5
EXCEPT = {'mean_iou_at_0.05_to_0.95[11]': 2e-4}


def run(*arguments):
    """(exit code, stdout, stderr)."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            code = main(list(map(str, arguments)))
        except SystemExit as stop:
            code = stop.code
    return code, out.getvalue(), err.getvalue()


class Case(drive.FolderCase):
    def same(self, expected, actual, where='', within=1e-6):
        """Of structures of numbers."""
        if isinstance(expected, dict):
            self.assertEqual(set(expected), set(actual) & set(expected), where)
            for name, value in expected.items():
                self.same(value, actual[name], f'{where}/{name}', within)
        elif isinstance(expected, list):
            self.assertEqual(len(expected), len(actual), where)
            for place, (a, b) in enumerate(zip(expected, actual)):
                self.same(a, b, f'{where}[{place}]', within)
        elif isinstance(expected, float) and actual is not None:
            most = EXCEPT.get(where.rsplit('/', 1)[-1], within)
            self.assertLessEqual(abs(expected - actual), most, where)
        else:
            self.assertEqual(expected, actual, where)

    def refused(self, code, message, *arguments):
        got, _, err = run(*arguments)
        self.assertEqual(got, code, err)
        self.assertIn(message, err)


class Golden(Case):
    """The figures of the program in C++ that came before."""

    def test_small_drive(self):
        drive.write_drive(self.root)
        for name, golden in json.loads(GOLDEN.read_text()).items():
            with self.subTest(truth=name):
                flags = [flag.replace('=.', '=').replace('--truth=', f'--truth={self.root}/')
                         if flag.startswith('--truth') else flag for flag in golden['flags']]
                code, out, err = run(self.root / 'run', *flags, '--no-plots', '--json')
                self.assertEqual(code, 0, err)
                self.same(golden['eval'], json.loads((self.root / 'run/eval.json').read_text()),
                          within=ONE_SCORE if name == 'tracks' else 1e-6)
                further = json.loads((self.root / 'run/further.json').read_text())
                self.same(golden['further'], further)
                self.assertEqual(json.loads(out)['further'], further)
                if 'csv' in golden:
                    self.assertEqual(golden['csv'],
                                     (self.root / 'run/eval.csv').read_text().split('\n'))

    def test_frames_left_out_are_told(self):
        drive.write_drive(self.root)
        (self.root / 'labels/000006.png').unlink()
        _, out, _ = run(self.root / 'run', f'--truth={self.root}/labels', '--no_plots')
        self.assertIn('left out: 1 frame before the first that was learnt from (the prior)', out)
        self.assertIn('left out: 1 frame without a mask or a labelled point', out)
        self.assertIn('left out: 1 frame whose truth has one class', out)
        self.assertRegex(out, r'\npooled AUC 0\.\d{4} over 5 frames\n$')

    def test_truth_beside_the_frames_is_found(self):
        drive.write_drive(self.root)
        code, out, err = run(self.root / 'run', '--json', '--no-plots')
        self.assertEqual((code, json.loads(out)['truth']), (0, str(self.root)), err)

    def test_tracks_name_their_frames(self):
        drive.write_drive(self.root)
        tracks = pandas.read_csv(self.root / 'tracks.csv')
        tracks.assign(frame=tracks.frame + 100).to_csv(self.root / 'tracks.csv')
        for k in range(drive.FRAMES):
            (self.root / f'frames/{k:06d}.png').rename(self.root / f'frames/a_{k + 100}.png')
        run(self.root / 'run', f'--truth={self.root}/tracks.csv', '--no-plots')
        golden = json.loads(GOLDEN.read_text())['tracks']['eval']
        self.same(golden, json.loads((self.root / 'run/eval.json').read_text()), within=ONE_SCORE)

    def test_a_clock_in_doubt_is_told(self):
        drive.write_drive(self.root)
        turns = np.cumsum([0, 1, 5, 2, 9, 4, 3, 8]) * 0.02
        rows, poses = [], []
        for k in range(drive.FRAMES):
            c, s = np.cos(turns[k + 1]), np.sin(turns[k + 1])  # row k is of frame k + 1
            rows.append(f'{c} 0 {s} 0 0 1 0 0 {-s} 0 {c} {k}')
            half = turns[k] / 2
            poses.append(f'{k / drive.RATE} 0 0 {k} 0 {np.sin(half)} 0 {np.cos(half)}')
        (self.root / 'poses.txt').write_text('\n'.join(rows))
        (self.root / 'run/trajectory.txt').write_text('\n'.join(poses))
        _, out, err = run(self.root / 'run', '--no-plots')
        further = json.loads((self.root / 'run/further.json').read_text())
        self.assertEqual(further['row_shift'], 1, err)
        shifted = further['trajectory_with_shifted_rows']
        self.assertAlmostEqual(shifted['rotation_degrees_per_second'], 0, 6)
        self.assertRegex(out, r'run +0\.000 .* 1\n')  # rows shifted by one

    def test_lines_of_several_logs(self):
        drive.write_drive(self.root)
        path = self.root / 'run'
        lines = [drive.line(k) | {'outcome': 'answered', 'model_size': 5 * (k > 1)}
                 for k in range(4)]
        lines[2]['width_pixels'] = 0
        (path / 'frames.jsonl').write_text(''.join(json.dumps(li) + '\n' for li in lines) + '{"cut')
        later = [lines[3] | {'width_pixels': 0}, lines[2] | {'width_pixels': drive.WIDTH}]
        (path / 'log').mkdir()
        (path / 'log/1.jsonl').write_text(''.join(json.dumps(line) + '\n' for line in later))
        read = RunFolder(path).lines
        self.assertEqual([line.width_pixels > 0 for line in read], [True] * 4)
        self.assertEqual([line.of_prior for line in read], [True, True, False, False])

    def test_plots(self):
        drive.write_drive(self.root)
        code, _, err = run(self.root / 'run', f'--truth={self.root}/masks')
        self.assertEqual(code, 0, err)
        page = (self.root / 'run/plots/index.html').read_text()
        self.assertEqual(page.count('<figure>'), 6)
        self.assertTrue((self.root / 'run/plots/roc.svg').stat().st_size > 1000)

    def test_refusals(self):
        drive.write_drive(self.root)
        made = self.root / 'run'
        self.refused(3, 'run.json', self.root)
        self.refused(3, 'no folder', made, f'--truth={self.root}/nothing')
        self.refused(2, 'above', made, '--object-low=0.9')
        self.refused(2, 'from 0 to 1', made, '--threshold=2')
        drive.write_drive(self.root / 'other')
        for frame in (self.root / 'other/frames').iterdir():
            drive.write_png(frame, np.zeros((drive.HEIGHT, drive.WIDTH), np.uint8))
        self.refused(2, 'which are other frames', made, f'--truth={self.root}/other/masks')
        drive.write_png(self.root / 'labels/000003.png', np.zeros((9, 9), np.uint8))
        self.refused(2, 'has another size', made, f'--truth={self.root}/labels')
        map_file = made / 'grid/000002.prob.png'
        map_file.unlink()
        self.refused(3, '000002.prob.png is not there', made, f'--truth={self.root}/masks')
        os.mkfifo(map_file)  # reading it would wait forever
        self.refused(3, 'is no file', made, f'--truth={self.root}/masks')
        lines = [drive.line(k) | {'width_pixels': 0} for k in range(drive.FRAMES)]
        (made / 'frames.jsonl').write_text(''.join(json.dumps(line) + '\n' for line in lines))
        self.refused(2, f'the run in {made} has no map', made)
        (made / 'frames.jsonl').write_text('{\n')
        self.refused(3, 'line 1', made)


class Suites(Case):
    def test_sequences(self):
        for name in ('a/one/masks', 'a/one/frames', 'b/two/frames', 'b/two/labels', 'c/frames',
                     'd/frames', 'd/masks'):
            (self.root / name).mkdir(parents=True)
        (self.root / 'd/unfinished').touch()
        found, without = find_sequences(self.root)
        self.assertEqual([(s.name, s.truth.name) for s in found],
                         [('a/one', 'masks'), ('b/two', 'labels')])
        self.assertEqual(without, ['c', 'd'])
        with self.assertRaisesRegex(InputError, 'no sequence'):
            find_sequences(self.root / 'c')

    def test_variants(self):
        self.assertEqual(suite.parse_variants('paper,default', ['x+1=--a=1 --b']),
                         {'paper': ['--profile=paper'], 'default': ['--profile=default'],
                          'x+1': ['--a=1', '--b']})
        for profiles, variants in (('', []), ('a', ['a=']), ('', ['b']), ('', ['b c=--x'])):
            with self.assertRaises(UsageError):
                suite.parse_variants(profiles, variants)

    def program(self, text):
        path = self.root / 'egosieve'
        path.write_text(f'#!/bin/sh\n{text}\n')
        path.chmod(0o755)
        return f'--program={path}'

    def test_runs_are_scored_and_compared(self):
        drive.write_drive(self.root / 'drives/town/one')
        drive.write_drive(self.root / 'drives/town/two')
        # A program that "segments" by copying the run that lies there, and fails in the second.
        program = self.program(
            'case "$1 $2" in *two*) echo "egosieve: no luck" >&2; exit 3;; "segment "*) '
            'out=${3#--out=}; mkdir -p "$out"; cp -r "$(dirname "$2")/run/." "$out";; esac')
        out = self.root / 'out'
        code, text, err = run('suite', self.root / 'drives', f'--out={out}', program, '--jobs=2')
        self.assertEqual(code, 4, err)
        self.assertIn('failed: town/two, default: segmenting ended with code 3: egosieve: no luck',
                      text)
        self.assertIn('1 of 2 runs scored, 1 failed', text)
        self.assertRegex(text, r'ahead vehicle within 40 m +6 +[01]\.\d{3} +[01]\.\d{3}\n')
        self.assertIn('default, all sequences with boxes', text)
        self.assertIn('| town | default | 1 of 2 |', text)
        scores = json.loads((out / 'suite.json').read_text())
        golden = json.loads(GOLDEN.read_text())['synthetic']['eval']
        self.same(golden['scores'], scores['sequences'][0]['scores'])
        self.assertAlmostEqual(scores['sequences'][0]['mask_j'], golden['masks']['j'], 6)
        self.assertEqual(scores['sequences'][0]['seconds_per_frame'], 1 / drive.FRAMES)
        self.assertTrue((out / 'plots/by_sequence_mean_auc.svg').exists())
        written = pandas.read_csv(out / 'suite.csv')
        self.assertEqual(written['sequence'].tolist(), ['town/one', 'town/two'])
        self.assertTrue(np.isnan(written.mean_auc[1]))
        written.loc[0, 'mean_auc'] -= 0.125
        written.to_csv(self.root / 'old.csv')
        _, text, _ = run('suite', self.root / 'drives', f'--out={out}', program, '--no-plots',
                         f'--against={self.root}/old.csv', '--quiet')
        self.assertRegex(text, r'\nmean +0\.\d{3} +0\.\d{3} +0\.125')
        self.refused(2, 'another build', 'suite', self.root / 'drives', f'--out={out}',
                     self.program('exit 3 # another'))

    def test_markdown(self):
        entries = [dict.fromkeys(figures.FIGURES) | {
            'sequence': f'g/{auc}', 'group': 'g', 'profile': 'default', 'truth_kind': kind, 'frames': 1,
            'error': None, 'mean_auc': auc, 'mean_iou': auc / 2, 'mask_j': 0.875}
            for auc, kind in ((0.5, 'masks'), (0.75, 'masks'), (0.25, 'tracks'))]
        self.assertIn('| g | default | 3 of 3 | 0.500 | 0.250 | 0.312 | 0.250 | 0.875 | 0.875 |\n',
                      table.to_markdown(entries, table.to_frame(entries)))
        alone = table.to_markdown(entries[:1], table.to_frame(entries[:1]))
        self.assertNotIn('| g |', alone)
        self.assertIn('| all | default | 1 of 1 |', alone)

    def test_refusals(self):
        self.refused(2, '--out', 'suite', self.root)
        self.refused(3, 'no sequence', 'suite', self.root, f'--out={self.root}/o',
                     self.program('exit 0'))
        self.refused(3, 'no egosieve', 'suite', self.root, f'--out={self.root}/o',
                     '--program=/none')


class Folds(Case):
    CLIPS = [f'clip{k}' for k in range(20)]

    def test_folds_are_fixed(self):
        own = [folds.fold_of(name, 5) for name in self.CLIPS]
        self.assertEqual(own, [folds.fold_of(f'suite/{name}', 5) for name in self.CLIPS])
        self.assertEqual(sorted(set(own)), [0, 1, 2, 3, 4])
        self.assertEqual([folds.fold_of(name, 5) for name in ('bear', 'bus', 'hike')],
                         [0, 3, 2])

    def values(self, **columns):
        return pandas.DataFrame(columns, index=self.CLIPS)

    def test_the_best_of_the_others_is_chosen(self):
        """One clip alone would choose b; held out, it does not."""
        lucky = self.CLIPS[0]
        values = self.values(a=0.5, b=[10.0] + [0.4] * 19)
        clips = folds.cross_validate(values, 5)
        fold = folds.fold_of(lucky, 5)
        self.assertEqual(set(clips.chosen[clips.fold == fold]), {'a'})
        self.assertEqual(set(clips.chosen[clips.fold != fold]), {'b'})
        self.assertEqual(clips['held out'][lucky], 0.5)
        self.assertFalse(folds.report(values, 'mean_auc', 5)[1])

    def test_a_change_counts(self):
        old = np.linspace(0.5, 0.9, 20)
        self.assertTrue(folds.report(self.values(old=old, new=old + 0.01), 'f', 5)[1])
        text, counts = folds.report(self.values(old=old, new=old), 'f', 5)
        self.assertFalse(counts)  # it does not rise
        worse = old + 0.05
        worse[1] = old[1] - 0.021  # of the five worst
        text, counts = folds.report(self.values(old=old, new=worse), 'f', 5)
        self.assertFalse(counts)
        self.assertIn('clip1 falls by 0.0210', text)
        worse[1], worse[15] = old[1] - 0.019, old[15] - 0.1  # the best may fall
        self.assertTrue(folds.report(self.values(old=old, new=worse), 'f', 5)[1])
        worse[15] = 0.3  # now it is among the worst
        self.assertFalse(folds.report(self.values(old=old, new=worse), 'f', 5)[1])

    def test_suites(self):
        for name, auc in (('a', 0.5), ('b', 0.6)):
            (self.root / name).mkdir()
            rows = pandas.DataFrame({'sequence': self.CLIPS, 'profile': 'default',
                                     'mean_auc': [auc] * 19 + [None]})
            rows.to_csv(self.root / name / 'suite.csv')
        code, text, _ = run('folds', self.root / 'a', self.root / 'b/suite.csv', '--folds=4')
        self.assertEqual(code, 0)
        self.assertIn('left out, without a value everywhere: clip19', text)
        self.assertIn('mean over held-out clips: +0.1000\nthe change counts\n', text)
        self.refused(2, 'one candidate only', 'folds', self.root / 'a')
        rows.assign(mask_j=np.nan).to_csv(self.root / 'b/suite.csv')
        self.refused(2, 'no value of mask_j', 'folds', self.root / 'b', self.root / 'b/suite.csv', '--figure=mask_j')
        self.refused(2, 'no figure j', 'folds', self.root / 'a', self.root / 'b', '--figure=j')
        self.refused(3, 'no table', 'folds', self.root / 'c', self.root / 'b')
