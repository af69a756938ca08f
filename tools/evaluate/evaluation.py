"""Scores one run: eval.json and eval.csv of a truth of its pixels, further.json of other truth.

The scored pixels are those of the grid (the 16-bit probabilities as written) or, if requested and
the run was refined, all pixels of full/. Frames before the first learnt frame have the map of
the prior, which is the same everywhere: they are left out and counted, unless `with_prior` is set.
Masks of refine are scored at full resolution, in every frame with a mask.
"""

from collections import Counter

import numpy as np
import pandas

from .drive_scores import FIGURES, DriveScores
from .drive_truth import DriveTruth, check_same_drive
from .errors import InputError, UsageError
from .mask_scores import MaskScores
from .run_folder import read_image
from .texts import to_json, to_text, write_file
from .truth_masks import STATIC, VOID, read_mask

COUNTS = ("dynamic_pixels", "static_pixels", "void_pixels")


class Evaluation:
    """A run's scores against one truth. after_frame: called after each frame."""

    def __init__(self, run, truth_path, options, after_frame=lambda: None):
        self.run, self.options = run, options
        truth = DriveTruth(truth_path, run, options.match)
        check_same_drive(run, truth_path)
        self.truth = truth
        area = options.object_area
        if options.pixels == "grid":
            area = max(1, area // run.stride**2)
        self.scores, self.masks = DriveScores(options, area), MaskScores(options)
        self.left_out = Counter()
        self.misfits = []
        matched = 0
        for line in run.scorable_lines():
            if line.index not in truth.frames:
                self.left_out["without_mask"] += 1
                continue
            matched += 1
            self._score_mask(line)
            if line.of_prior and not options.with_prior:
                self.left_out["of_prior"] += 1
            else:
                self._score(line)
            after_frame()
        self.left_out["without_map"] = len(truth.frames) - matched
        self.mask_figures = self.masks.to_json()
        self._check()

    def _score(self, line):
        grid = self.run.grid(line, self.options.pixels)
        if self.truth.scattered:
            outside = len(self.truth.points[line.index]) - len(self.truth.inside(line.index, grid))
            self.left_out["points_outside"] += outside
        frame = self.truth.compare(line, grid, self.run.maps(line, self.options.pixels))
        if frame is None:
            self.misfits.append(line.index)
        elif (frame.truth == VOID).all():  # or no point
            self.left_out["without_points"] += 1
        else:
            self.scores.add(frame)

    def _score_mask(self, line):
        path = self.run.frame_file("masks", line.index, ".png")
        size = (line.height, line.width)
        if self.truth.scattered or not path.exists():
            return
        true_mask, mask = self.truth.mask(line.index, size), read_mask(path)
        if true_mask is None:
            return  # counted by _score
        if mask.shape != size:
            raise InputError(f"{path} is damaged; run egosieve refine again")
        true_ids = self.truth.moving_ids(line.index, size)
        ids, ids_path = None, self.run.frame_file("ids", line.index, ".png")
        if true_ids is not None and ids_path.exists():
            ids = read_image(ids_path)
            if ids.dtype != np.uint16 or ids.shape != size:
                raise InputError(f"{ids_path} is damaged; run egosieve refine again")
            ids = ids.astype(np.int32)
        self.masks.add(line.index, mask != STATIC, true_mask, ids, true_ids,
                       self.truth.objects(line.index))

    def _check(self):
        truth = self.truth
        if self.misfits:
            raise UsageError(f"{len(self.misfits)} masks of {truth.path} do not fit their frames, "
                             f"first: that of frame {self.misfits[0]} has another size; give the "
                             "masks of this drive")
        if not self.scores.frames:
            raise UsageError(
                f"no frame of {self.run.path} can be scored against {truth.path} "
                f"({len(self.run.lines)} frames, {self.left_out['of_prior']} of them with the "
                f"prior only; truth for {len(truth.frames)} frames, matched by {truth.matched_by}, "
                f"void in {self.left_out['without_points']}; {self.left_out['points_outside']} "
                "points outside the image); give the truth of this drive, or choose --match")

    @property
    def pixels(self):
        return f"{'interpolated from ' * self.truth.scattered}{self.options.pixels}"

    def to_json(self):
        scores = self.scores
        return {"truth": str(self.truth.path), "truth_kind": self.truth.kind,
                "matched_by": self.truth.matched_by, "pixels": self.pixels,
                "pooled_auc": scores.pooled.auc(), "mean_auc": scores.mean("auc"),
                "frames_scored": len(scores.frames),
                "frames_of_prior": self.left_out["of_prior"],
                "frames_without_map": self.left_out["without_map"],
                "frames_without_mask": self.left_out["without_mask"],
                "frames_without_points": self.left_out["without_points"],
                "points": self.truth.count_points(),
                "points_outside": self.left_out["points_outside"],
                "scores": scores.to_json(),
                "masks": self.mask_figures if self.masks.frames else None,
                "frames": [{name: frame[name] for name in ("index", *COUNTS, *FIGURES)}
                           for frame in scores.frames]}

    def to_csv(self):
        rows = pandas.DataFrame(self.scores.frames)[["index", *COUNTS, *FIGURES]]
        rows = rows.astype(dict.fromkeys(FIGURES, float)).rename(columns={"index": "frame"})
        return rows.to_csv(index=False, float_format="%.6f")

    def write(self):
        write_file(self.run.file("eval.json"), to_json(self.to_json()))
        write_file(self.run.file("eval.csv"), self.to_csv())

    def _left_out_text(self, without_auc, pooled):
        tracks = self.truth.scattered
        one_class = ("have no AUC of their own; they are in the pooled one" if pooled is not None
                     else "lack AUC, average precision and IoU")
        reasons = (
            (self.left_out["of_prior"], "before the first that was learnt from (the prior)"),
            (self.left_out["without_mask"],
             "without a labelled point" if tracks else "without a mask"),
            (self.left_out["without_map"],
             f"with {'labelled points' if tracks else 'a mask'}, but without a map"),
            (self.left_out["without_points"], "whose labelled points lie outside the image"
             if tracks else "whose mask is void everywhere"),
            (without_auc, f"whose truth has one class: they {one_class}"))
        text = "".join(f"left out: {count} frame{'s' * (count != 1)} {why}\n"
                       for count, why in reasons if count)
        if outside := self.left_out["points_outside"]:
            text += (f"left out: {outside} of {self.truth.count_points()} labelled points, outside "
                     "the image\n")
        return text

    def table(self):
        """For people; the last line is "pooled AUC 0.NNN over N frames"."""
        frames, pooled = self.scores.frames, self.scores.pooled.auc()
        rows = pandas.DataFrame(frames)[["index", *COUNTS, *FIGURES]]
        headings = {"index": "frame", **dict(zip(COUNTS, ("dynamic", "static", "void"))), **FIGURES}
        text = to_text(rows.rename(columns=headings))
        with_auc = sum(frame["auc"] is not None for frame in frames)
        text += self._left_out_text(len(frames) - with_auc, pooled)
        matched = "tracks" if self.truth.scattered else "masks"
        text += f"scored: {self.pixels} pixels; {matched} matched by {self.truth.matched_by}\n"
        text += self.scores.summary() + self.masks.summary(self.mask_figures)
        if with_auc:
            text += f"mean AUC {self.scores.mean('auc'):.4f} over {with_auc} frames\n"
        if pooled is None:
            return text + "pooled AUC: none, the truth has one class only\n"
        return text + f"pooled AUC {pooled:.4f} over {len(frames)} frames\n"
