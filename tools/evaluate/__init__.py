"""Scores runs of egosieve against truth: `egosieve-eval`.

    files, run_folder   files; what a run holds: its lines and maps
    truth, csv_truth    forms of truth
    pixel_scores, uncertainty, boundary, stability          measures of pixels and outlines
    objects, identity                                       measures of objects
    trajectory          measures of the camera
    drive_scores, mask_scores, box_scores, further          collections of them for one drive
    evaluation          one run: eval.json, eval.csv
    suite, table, folds many runs
    figures, plots      the figures that are compared; pages of curves
    command             the command line
"""
