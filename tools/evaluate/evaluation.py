"""Scores one run against a truth of its pixels: eval.json and eval.csv.

The scored pixels are those of the grid (the 16-bit probabilities as written) or, if requested and
the run was refined, all pixels of full/. Frames before the first learnt frame have the map of
the prior, which is the same everywhere: they are left out and counted, unless `with_prior` is set.
Masks of refine are scored at full resolution, in every frame with a mask.
"""

from collections import Counter

import pandas

from .drive_scores import FIGURES, DriveScores
from .files import InputError, UsageError, read_numbers, to_json, to_text, write_file
from .figures import figures_of
from .mask_scores import MaskScores
from .objects import object_tables
from .pixel_scores import ratio
from .truth import STATIC, VOID, DriveTruth, check_same_drive, read_mask

COUNTS = {"dynamic_pixels": "dynamic", "static_pixels": "static", "void_pixels": "void"}
LEFT_OUT = {"of_prior": "before the first that was learnt from (the prior)",
            "without_mask": "without a mask or a labelled point",
            "without_map": "with a truth, but without a map",
            "without_points": "whose truth is void, or outside the image, everywhere"}


class Evaluation:
    """A run's scores against one truth. eval: the content of eval.json."""

    def __init__(self, run, truth_path, options):
        self.run, self.options = run, options
        self.truth = DriveTruth(truth_path, run)
        check_same_drive(run, truth_path)
        area = options.object_area
        if options.pixels == "grid":
            area = max(1, area // run.stride**2)
        self.scores, self.masks = DriveScores(options, area), MaskScores(options)
        self.left_out = Counter()
        lines = run.scorable_lines()
        for line in lines:
            if line.index not in self.truth.frames:
                self.left_out["without_mask"] += 1
                continue
            self._score_mask(line)
            if line.of_prior and not options.with_prior:
                self.left_out["of_prior"] += 1
            else:
                self._score(line)
        self.left_out["without_map"] = len(self.truth.frames - {line.index for line in lines})
        if not self.scores.frames:
            raise UsageError(
                f"no frame of {run.path} can be scored against {self.truth.path}: of "
                f"{len(lines)} frames with a map {self.left_out['of_prior']} have the prior only; "
                f"of {len(self.truth.frames)} with truth, matched by {self.truth.matched_by}, "
                f"{self.left_out['without_points']} are void; give the truth of this drive")
        self.eval = self._to_json()

    def _score(self, line):
        grid = self.run.grid(line, self.options.pixels)
        if self.truth.scattered:
            outside = len(self.truth.points[line.index]) - len(self.truth.inside(line.index, grid))
            self.left_out["points_outside"] += outside
        frame = self.truth.compare(line, grid, self.run.maps(line, self.options.pixels))
        if (frame.truth == VOID).all():  # or no point
            self.left_out["without_points"] += 1
        else:
            self.scores.add(frame)

    def _score_mask(self, line):
        path, ids_path = (self.run.frame_file(folder, line) for folder in ("masks", "ids"))
        if self.truth.scattered or not path.exists():
            return
        mask = read_mask(path)
        if mask.shape != line.size:
            raise InputError(f"{path} is damaged; run egosieve refine again")
        ids = read_numbers(ids_path, line.size) if ids_path.exists() else None
        self.masks.add(line.index, mask != STATIC, self.truth.mask(line), ids,
                       self.truth.moving_ids(line), self.truth.objects.get(line.index))

    def _to_json(self):
        scores, truth = self.scores.to_json(), self.truth
        description = self.run.description
        return {"truth": str(truth.path), "truth_kind": truth.kind,
                "matched_by": truth.matched_by,
                "pixels": f"{'interpolated from ' * truth.scattered}{self.options.pixels}",
                "pooled_auc": scores["pooled_auc"], "mean_auc": scores["mean_auc"],
                "seconds_per_frame": ratio(description["seconds"], description["frames_answered"]),
                "frames_scored": len(self.scores.frames),
                **{f"frames_{reason}": self.left_out[reason] for reason in LEFT_OUT},
                "points": sum(map(len, truth.points.values())),
                "points_outside": self.left_out["points_outside"],
                "scores": scores,
                "masks": self.masks.to_json() if self.masks.frames else None,
                "frames": [{name: frame[name] for name in ("index", *COUNTS, *FIGURES)}
                           for frame in self.scores.frames]}

    def write(self):
        write_file(self.run.path / "eval.json", to_json(self.eval))
        rows = pandas.DataFrame(self.eval["frames"]).astype(dict.fromkeys(FIGURES, float))
        rows = rows.rename(columns={"index": "frame"})
        write_file(self.run.path / "eval.csv", rows.to_csv(index=False, float_format="%.6f"))

    def table(self):
        """For people; the last line is "pooled AUC 0.NNN over N frames"."""
        rows = pandas.DataFrame(self.eval["frames"])
        headings = {"index": "frame", **COUNTS, **FIGURES}
        text = to_text(rows.rename(columns=headings))
        one_class = "whose truth has one class: they have no AUC of their own"
        left_out = [(self.left_out[reason], why) for reason, why in LEFT_OUT.items()]
        for count, why in (*left_out, (rows.auc.isna().sum(), one_class)):
            if count:
                text += f"left out: {count} frame{'s' * (count != 1)} {why}\n"
        if outside := self.eval["points_outside"]:
            text += f"left out: {outside} of {self.eval['points']} points, outside the image\n"
        matched = f"{self.truth.kind} matched by {self.truth.matched_by}"
        text += f"scored: {self.eval['pixels']} pixels; {matched}\n"
        for name, value in figures_of(self.eval).items():
            if value is not None:
                text += f"{name.replace('_', ' ')} {value:.4f}\n"
        text += object_tables([("found", self.eval)])
        if self.eval["pooled_auc"] is None:
            return text + "pooled AUC: none, the truth has one class only\n"
        return text + f"pooled AUC {self.eval['pooled_auc']:.4f} over {len(rows)} frames\n"
